//! The measurements as tables.

use super::study::{Sample, Setting, Study};
use crate::error::Error;
use crate::format::milliseconds;
use crate::output::csv;
use crate::setup::Setup;

const HEADER: [&str; 20] = [
    "method",
    "step",
    "tolerance",
    "steps",
    "evaluations",
    "run_seconds",
    "run_seconds_quarter",
    "run_seconds_three_quarters",
    "error_position",
    "error_rate",
    "error_force",
    "error_of_column",
    "uncertainty_position",
    "uncertainty_rate",
    "uncertainty_force",
    "uncertainty_of_column",
    "residual_position",
    "energy_drift",
    "estimated_error",
    "failure",
];

impl Study {
    /// `accuracy.csv`
    pub(crate) fn csv(&self) -> Result<Vec<u8>, Error> {
        csv(HEADER, self.samples.iter().map(|sample| self.record(sample)))
    }

    fn record(&self, sample: &Sample) -> Vec<String> {
        let full = |number: f64| format!("{number:?}");
        let (step, tolerance) = match sample.setting {
            Setting::Step(step) => (full(step), String::new()),
            Setting::Tolerance(tolerance) => (String::new(), full(tolerance)),
        };
        let mut record = vec![sample.method.clone(), step, tolerance];
        let u = self.reference.uncertainty;
        match &sample.result {
            Ok(m) => {
                record.extend([m.steps.to_string(), m.evaluations.to_string()]);
                let [quarter, median, three_quarters] = m.seconds;
                record.extend([median, quarter, three_quarters].map(full));
                // Errors below the uncertainty of the reference are unknown.
                let error = |(error, uncertainty): (f64, f64)| match error > uncertainty {
                    true => full(error),
                    false if uncertainty == 0.0 => String::new(),
                    false => format!("<{uncertainty:?}"),
                };
                let e = m.errors;
                let asked = e.asked.zip(u.asked);
                record.extend([(e.position, u.position), (e.rate, u.rate), (e.force, u.force)].map(error));
                record.push(asked.map_or(String::new(), error));
                record.extend([u.position, u.rate, u.force].map(full));
                record.push(u.asked.map_or(String::new(), full));
                let known = |number: Option<f64>| number.map_or(String::new(), full);
                record.extend([Some(m.residual), m.energy_drift, m.estimate].map(known));
                record.push(String::new());
            }
            Err(reason) => {
                record.resize(HEADER.len() - 1, String::new());
                record.push(reason.text.clone());
            }
        }
        record
    }

    /// The table for a terminal.
    pub(crate) fn table(&self, setup: &Setup) -> String {
        let shown = |&t: &f64| if t < 1e-3 { format!("{t:.6e}") } else { format!("{t:.6}") };
        let times: Vec<String> = self.reference.times().iter().map(shown).collect();
        let u = self.reference.uncertainty;
        let mut text = format!(
            "{}: errors at t = {} s\nagainst {}\n(uncertain by {:.1e} in the coordinates, {:.1e} in the rates{})\n",
            setup.description.name,
            times.join(", "),
            self.reference.origin,
            u.position,
            u.rate,
            if u.force > 0.0 { format!(", {:.1e} in the reactions", u.force) } else { String::new() }
        );
        let asked = self.of.as_ref().map_or(String::new(), |of| format!("{:>9} ", of.name));
        if let (Some(column), Some(uncertainty)) = (&self.of, u.asked) {
            let (name, unit) = (&column.name, &column.unit);
            text += format!("({name} is uncertain by {uncertainty:.1e} {unit}").trim_end();
            text += ")\n";
        }
        let mut method = "";
        for sample in &self.samples {
            if sample.method != method {
                method = &sample.method;
                let order = self.order(method).map_or(String::new(), |order| format!(", of order {order:.2}"));
                text += &format!(
                    "\n  {method}{order}\n  {:>16} {:>8} {:>10} {:>9} {:>9} {:>9} {asked}{:>9} {:>9} {:>9}\n",
                    "", "steps", "time", "position", "rate", "reaction", "residual", "energy", "estimate"
                );
            }
            text += &self.line(sample);
        }
        text
    }

    fn line(&self, sample: &Sample) -> String {
        let setting = match sample.setting {
            Setting::Step(step) => format!("h = {step:.3e} s"),
            Setting::Tolerance(tolerance) => format!("tol = {tolerance:e}"),
        };
        let m = match &sample.result {
            Ok(m) => m,
            Err(reason) => return format!("  {setting:>16} {}\n", reason.text),
        };
        // Errors below the uncertainty of the reference are unknown.
        let error = |error: f64, uncertainty: f64| match error > uncertainty {
            true => format!("{error:.1e}"),
            // Zero uncertainty means that there are no such values, since rounding errors always exist.
            false if uncertainty == 0.0 => "-".to_owned(),
            false => format!("<{uncertainty:.0e}"),
        };
        let known = |number: Option<f64>| number.map_or("-".to_owned(), |number| format!("{number:.1e}"));
        let (e, u) = (m.errors, self.reference.uncertainty);
        let asked = e.asked.zip(u.asked).map_or(String::new(), |(e, u)| format!("{:>9} ", error(e, u)));
        format!(
            "  {setting:>16} {:>8} {:>10} {:>9} {:>9} {:>9} {asked}{:>9.1e} {:>9} {:>9}\n",
            m.steps,
            milliseconds(m.seconds[1]),
            error(e.position, u.position),
            error(e.rate, u.rate),
            error(e.force, u.force),
            m.residual,
            known(m.energy_drift),
            known(m.estimate)
        )
    }

    /// The observed order of a method with fixed steps, from the errors of the coordinates: the slope of a straight
    /// line fitted to its points. Points near rounding errors, and too long steps, are excluded.
    fn order(&self, method: &str) -> Option<f64> {
        let floor = CLEAR * self.reference.uncertainty.judged();
        let point = |sample: &Sample| match (&sample.setting, &sample.result) {
            (Setting::Step(step), Ok(m)) if m.errors.judged() > floor => Some((step.ln(), m.errors.judged().ln())),
            _ => None,
        };
        let samples = self.samples.iter().filter(|sample| sample.method == method);
        let points: Vec<(f64, f64)> = samples.map_while(point).collect();
        let points = points.get(SKIPPED..)?;
        if points.len() < 3 {
            return None;
        }
        let count = points.len() as f64;
        let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
        let sum = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>();
        let order = sum(&|point| (point.0 - x) * (point.1 - y)) / sum(&|point| (point.0 - x).powi(2));
        // Points that are not on a straight line show no order.
        let mut slopes = points.windows(2).map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0));
        slopes.all(|slope| (slope - order).abs() < 1.0).then_some(order)
    }
}

/// The multiple of the uncertainty above which rounding errors do not matter.
const CLEAR: f64 = 250.0;
/// The number of longest steps that do not show the order yet.
const SKIPPED: usize = 1;
