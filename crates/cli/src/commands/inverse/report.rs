//! The results of inverse dynamics as text, table, summary and figure.

use qrm_sim::analysis::PrescribedState;
use qrm_sim::columns::columns;
use qrm_view::figure::{Abscissa, Curve, Extremes, Figure, Panel, Scale};
use serde::Serialize;

use super::actuators::Actuators;
use crate::error::Error;
use crate::format::number;
use crate::output::{Named, csv};
use crate::setup::Setup;

/// The forces and torques of a motion, row by row, and their statistics.
#[derive(Serialize)]
pub(super) struct Report<'r> {
    scene: &'static str,
    end_time: f64,
    rows: usize,
    results: Named<Statistics>,
    #[serde(skip)]
    setup: &'r Setup,
    #[serde(skip)]
    states: &'r [PrescribedState],
    /// A column for each force or torque, and the power.
    #[serde(skip)]
    columns: Vec<Vec<f64>>,
}

/// A force, torque or power over the motion.
#[derive(Serialize)]
struct Statistics {
    unit: &'static str,
    minimum: [f64; 2],
    maximum: [f64; 2],
    mean: f64,
    root_mean_square: f64,
}

impl<'r> Report<'r> {
    pub(super) fn new(setup: &'r Setup, actuators: &Actuators, states: &'r [PrescribedState]) -> Self {
        let forces: Vec<Vec<f64>> = states.iter().map(|state| actuators.forces(state)).collect();
        let mut columns: Vec<Vec<f64>> =
            (0..actuators.all.len()).map(|place| forces.iter().map(|row| row[place]).collect()).collect();
        let mechanism = setup.mechanism();
        columns.push(states.iter().map(|state| actuators.power(&*mechanism, state)).collect());
        let names = actuators.all.iter().map(|own| (own.name.clone(), own.unit));
        let taken = |name: &str| setup.description.outputs.iter().any(|output| output.name == name);
        // Outputs of the scene keep their names.
        let free = |mut name: String| {
            while taken(&name) {
                name.push('_');
            }
            name
        };
        let names = names.chain([("power".to_owned(), "W")]).map(|(name, unit)| (free(name), unit));
        let times: Vec<f64> = states.iter().map(|state| state.t).collect();
        let results = names.zip(&columns).map(|((name, unit), values)| (name, Statistics::new(unit, &times, values)));
        Self {
            scene: setup.description.name,
            end_time: times.last().copied().unwrap_or(0.0),
            rows: states.len(),
            results: Named(results.collect()),
            setup,
            states,
            columns,
        }
    }

    /// The results as text with this title.
    pub(super) fn text(&self, title: &str) -> String {
        let mut text = format!(
            "{title}\n\n  {:12}{:>15}{:>12}{:>15}{:>12}{:>15}{:>15}\n",
            "", "minimum", "at t", "maximum", "at t", "mean", "rms"
        );
        for (name, own) in &self.results.0 {
            let [(low, at_low), (high, at_high)] = [own.minimum, own.maximum].map(|[value, t]| (number(value), t));
            let (mean, rms) = (number(own.mean), number(own.root_mean_square));
            let unit = own.unit;
            text +=
                &format!("  {name:12}{low:>15}{at_low:>12.6}{high:>15}{at_high:>12.6}{mean:>15}{rms:>15}  {unit}\n");
        }
        text
    }

    /// The rows as a table.
    pub(super) fn csv(&self) -> Result<Vec<u8>, Error> {
        let columns = columns(self.setup.description).into_iter().filter(|column| !column.kind.is_check());
        let header = columns.map(|column| column.name).chain(self.results.0.iter().map(|(name, _)| name.clone()));
        let row = |(place, state): (usize, &PrescribedState)| {
            let motion = (0..state.q.len()).flat_map(|i| [state.q[i], state.qd[i], state.qdd[i]]);
            let results = self.columns.iter().map(|column| column[place]);
            let numbers = [state.t].into_iter().chain(motion).chain(state.multipliers.iter().copied());
            let numbers = numbers.chain(state.outputs.iter().copied()).chain(results);
            numbers.map(|number| format!("{number:?}")).collect::<Vec<_>>()
        };
        csv(header, self.states.iter().enumerate().map(row))
    }

    /// Forces and torques over time, a panel for each, and the power.
    pub(super) fn figure(&self) -> Figure {
        let panel = |((name, own), values): (&(String, Statistics), &Vec<f64>)| {
            let points = self.states.iter().zip(values).map(|(state, value)| (state.t, *value)).collect();
            let mark = |[value, t]: [f64; 2]| (t, value);
            let extremes = Extremes { minimum: mark(own.minimum), maximum: mark(own.maximum) };
            let curve =
                Curve { name: name.clone(), doc: String::new(), points, extremes: Some(extremes), has_dots: false };
            Panel {
                quantity: name.clone(),
                unit: own.unit.to_owned(),
                scale: Scale::Linear,
                curves: vec![curve],
                floor: None,
            }
        };
        Figure {
            title: format!("{}: forces and torques that its motion takes", self.scene),
            abscissa: Abscissa::time(),
            panels: self.results.0.iter().zip(&self.columns).map(panel).collect(),
        }
    }
}

impl Statistics {
    fn new(unit: &'static str, times: &[f64], values: &[f64]) -> Self {
        let extreme = |is_beyond: fn(f64, f64) -> bool| {
            let places = 0..values.len();
            let place = places.reduce(|best, place| if is_beyond(values[place], values[best]) { place } else { best });
            let row = place.map_or([0.0; 2], |place| [values[place], times[place]]);
            let vertex = place.and_then(|place| vertex(times, values, place));
            vertex.filter(|vertex| is_beyond(vertex[0], row[0])).unwrap_or(row)
        };
        let whole = times.last().copied().unwrap_or(0.0) - times.first().copied().unwrap_or(0.0);
        let mean = |of: fn(f64) -> f64| {
            let pieces = times.windows(2).zip(values.windows(2));
            pieces.map(|(t, v)| 0.5 * (t[1] - t[0]) * (of(v[0]) + of(v[1]))).sum::<f64>() / whole
        };
        Self {
            unit,
            minimum: extreme(|value, best| value < best),
            maximum: extreme(|value, best| value > best),
            mean: mean(|value| value),
            root_mean_square: mean(|value| value * value).sqrt(),
        }
    }
}

/// Value and time at the vertex of the parabola through a row and its neighbours; `None` at the ends.
fn vertex(times: &[f64], values: &[f64], place: usize) -> Option<[f64; 2]> {
    let [before, after] = [place.checked_sub(1)?, place + 1];
    let (t, v) = (times[place], values[place]);
    let [left, right] = [t - times[before], times.get(after)? - t];
    // Two rows at the same time mean a jump.
    if left <= 0.0 || right <= 0.0 {
        return None;
    }
    let [fall, rise] = [(v - values[before]) / left, (values[after] - v) / right];
    let bend = (rise - fall) / (left + right);
    let slope = (fall * right + rise * left) / (left + right);
    let offset = -slope / (2.0 * bend);
    (-left < offset && offset < right).then(|| [v + slope * offset / 2.0, t + offset])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_lie_between_rows() {
        let times = [0.0, 0.1, 0.3, 0.4];
        let values = times.map(|t| 2.0 - 3.0 * (t - 0.15_f64).powi(2));
        let result = Statistics::new("N", &times, &values);
        assert!((result.maximum[0] - 2.0).abs() < 1e-14 && (result.maximum[1] - 0.15).abs() < 1e-14);
        assert_eq!(result.minimum, [values[3], 0.4]);
    }
}
