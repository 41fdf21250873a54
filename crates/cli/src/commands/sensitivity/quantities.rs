//! The quantities whose derivatives are computed.

use qrm_sim::analysis::{DerivativeErrors, Derivatives, Sensitivity};
use qrm_sim::columns::per_second;

use crate::setup::Setup;

/// A quantity of a motion with its derivatives: a row of the table.
pub(crate) struct Quantity<'f> {
    /// The kind of the quantity: `end`, `minimum`, `time_of_minimum`, ...
    pub(crate) what: &'static str,
    /// The column of the trajectory.
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) value: &'f Derivatives,
    /// Estimated errors, if they are asked for.
    pub(crate) errors: Option<DerivativeErrors>,
    /// A significant size of the quantity.
    pub(super) scale: f64,
}

/// The smallest significant size, in SI units.
const LEAST: f64 = 1e-4;

/// The end of the motion, then each output: the requested ones, or all.
pub(super) fn quantities<'f>(setup: &Setup, found: &'f Sensitivity, of: &[String]) -> Vec<Quantity<'f>> {
    let mut rows = Vec::new();
    let mut row = |what, name: &str, unit: String, value: &'f Derivatives, scale, chosen_by: &str| {
        if of.is_empty() || of.iter().any(|of| of == chosen_by) {
            let errors = value.errors.clone();
            rows.push(Quantity { what, name: name.to_owned(), unit, value, errors, scale: f64::max(scale, LEAST) });
        }
    };
    let duration = found.end_time.value;
    let is_stopped = setup.end_time.is_none() && !setup.until.is_empty();
    if is_stopped {
        row("end", "t", "s".to_owned(), &found.end_time, duration, "end");
    }
    let largest = |values: &[Derivatives]| values.iter().map(|value| value.value.abs()).fold(0.0, f64::max);
    let (of_q, of_qd) = (largest(&found.q), largest(&found.qd));
    for (i, coordinate) in setup.description.coordinates.iter().enumerate() {
        let (q, qd) = (&found.q[i], &found.qd[i]);
        row("end", coordinate.name, coordinate.unit.to_owned(), q, of_q, "end");
        row("end", &format!("{}_dot", coordinate.name), per_second(coordinate.unit, 1), qd, of_qd, "end");
    }
    for (output, values) in setup.description.outputs.iter().zip(&found.outputs) {
        let unit = || output.unit.to_owned();
        let seconds = || "s".to_owned();
        let range = values.maximum[0].value - values.minimum[0].value;
        let mut row = |what, unit, value, scale| row(what, output.name, unit, value, scale, output.name);
        row("end", unit(), &values.end, range);
        row("minimum", unit(), &values.minimum[0], range);
        row("time_of_minimum", seconds(), &values.minimum[1], duration);
        row("maximum", unit(), &values.maximum[0], range);
        row("time_of_maximum", seconds(), &values.maximum[1], duration);
        let unit = if output.unit.is_empty() { seconds() } else { format!("{} s", output.unit) };
        row("integral", unit, &values.integral, range * duration);
    }
    rows
}
