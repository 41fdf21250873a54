//! The proved end of a motion, for people and for programs.

use std::time::Duration;

use qrm_core::Interval;
use qrm_sim::analysis::Enclosure;
use qrm_sim::columns::{Kind, columns};
use serde::Serialize;

use crate::format::counted;
use crate::setup::Setup;
use crate::table::{self, Align};

/// The largest number of decimals.
const MOST_DECIMALS: f64 = 18.0;

/// The intervals at the end of a motion.
#[derive(Serialize)]
pub(super) struct Report {
    scene: &'static str,
    /// Whether the given angle has completed its turn.
    has_turned: bool,
    /// The condition that became true.
    #[serde(skip_serializing_if = "Option::is_none")]
    condition: Option<String>,
    steps: u64,
    columns: Vec<Column>,
}

/// An interval with its name.
#[derive(Serialize)]
struct Column {
    name: String,
    unit: String,
    lower: f64,
    upper: f64,
}

impl Report {
    pub(super) fn new(setup: &Setup, reached: &Enclosure, until: Option<&str>) -> Self {
        let value = |kind: Kind| match kind {
            Kind::Time => Some(reached.t),
            Kind::Coordinate(i) => Some(reached.q[i]),
            Kind::Rate(i) => Some(reached.qd[i]),
            Kind::Acceleration(i) => Some(reached.qdd[i]),
            Kind::Multiplier(i) => Some(reached.multipliers[i]),
            Kind::Output(i) => Some(reached.outputs[i]),
            _ => None,
        };
        let of = |column: qrm_sim::columns::Column| {
            let value = value(column.kind)?;
            Some(Column { name: column.name, unit: column.unit, lower: outward(value)[0], upper: outward(value)[1] })
        };
        Self {
            scene: setup.description.name,
            has_turned: reached.is_at_event && until.is_none(),
            condition: until.filter(|_| reached.is_at_event).map(str::to_owned),
            steps: reached.steps,
            columns: columns(setup.description).into_iter().filter_map(of).collect(),
        }
    }

    /// The report as a table.
    pub(super) fn text(&self, elapsed: Duration) -> String {
        let end = match &self.condition {
            Some(condition) => format!("where `{condition}` becomes true"),
            None if self.has_turned => "after one turn".to_owned(),
            None => "at the time t".to_owned(),
        };
        let (steps, seconds) = (counted(self.steps, "step"), elapsed.as_secs_f64());
        let mut rows = vec![["", "value", "width", "lower", "upper", ""].map(str::to_owned).to_vec()];
        rows.extend(self.columns.iter().map(Column::cells));
        let lines = table::lines(&[Align::Left; 6], &rows);
        let title = format!("{}: intervals that contain the motion {end} ({steps}, {seconds:.2} s)", self.scene);
        format!("{title}\n{}\n", lines.join("\n"))
    }
}

impl Column {
    fn cells(&self) -> Vec<String> {
        let digits = digits(self.lower, self.upper);
        let width = match self.upper - self.lower {
            0.0 => "0".to_owned(),
            width => format!("{width:.1e}"),
        };
        let [lower, upper] = [self.lower, self.upper].map(|end| format!("{end:?}"));
        vec![self.name.clone(), digits, width, lower, upper, self.unit.clone()]
    }
}

/// Rounds the ends of an interval outward, so that their shortest decimals lie outside too.
fn outward(interval: Interval) -> [f64; 2] {
    let is_exact = |end: f64| Interval::rounded(end) == Interval::point(end);
    let (lower, upper) = (interval.lo(), interval.hi());
    let lower = if is_exact(lower) { lower } else { lower.next_down() };
    [lower, if is_exact(upper) { upper } else { upper.next_up() }]
}

/// The midpoint with as many digits as all numbers between two share, up to one unit in the last digit.
fn digits(lower: f64, upper: f64) -> String {
    let (middle, width) = (0.5 * lower + 0.5 * upper, upper - lower);
    if width == 0.0 {
        return format!("{middle:?}");
    }
    // Half a unit for the width, and half a unit for the rounding.
    let place = (-(1.001 * width).log10()).floor().min(MOST_DECIMALS);
    let leading = middle.abs().log10().floor();
    let is_plain = (1e-4..1e6).contains(&middle.abs()) || place + leading < 0.0;
    if place >= 0.0 && is_plain {
        format!("{middle:.0$}", place as usize)
    } else if place + leading >= 0.0 {
        format!("{middle:.0$e}", (place + leading) as usize)
    } else {
        "?".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_that_are_proved() {
        for (lower, upper, text) in [
            (1.234_567_8, 1.234_567_9, "1.234568"),
            (1.234_567_8, 1.234_567_8, "1.2345678"),
            (5.283_185_307_17, 5.283_185_307_19, "5.2831853072"),
            (-1e-9, 2e-9, "0.00000000"),
            (1.2e-7, 1.203e-7, "1.20e-7"),
            (12_340.0, 12_360.0, "1.24e4"),
            (12_345_678.0, 12_345_679.5, "1.234568e7"),
            (0.0, 5e-324, "0.000000000000000000"),
            (-5.0, 30.0, "?"),
        ] {
            assert_eq!(digits(lower, upper), text, "{lower} .. {upper}");
        }
    }

    #[test]
    fn decimals_of_ends_lie_outside() {
        assert_eq!(outward(Interval::new(-2.0, 0.5)), [-2.0, 0.5]);
        assert_eq!(outward(Interval::point(0.1)), [0.1_f64.next_down(), 0.1_f64.next_up()]);
    }
}
