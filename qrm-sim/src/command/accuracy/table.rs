//! The measurements as a table.

use super::super::reference::Reference;
use super::super::setup::Setup;
use super::super::words;
use super::ladder::{Rung, Setting};

/// `accuracy.csv`
pub(super) fn csv(rungs: &[Rung], reference: &Reference) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
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
        "uncertainty_position",
        "uncertainty_rate",
        "uncertainty_force",
        "residual_position",
        "energy_drift",
        "estimated_error",
        "failure",
    ])?;
    let u = reference.uncertainty;
    for rung in rungs {
        let (step, tolerance) = match rung.setting {
            Setting::Step(step) => (format!("{step:?}"), String::new()),
            Setting::Tolerance(tolerance) => (String::new(), format!("{tolerance:?}")),
        };
        let mut record = vec![rung.method.to_owned(), step, tolerance];
        match &rung.result {
            Ok(m) => {
                record.extend([m.steps.to_string(), m.evaluations.to_string()]);
                let [quarter, median, three_quarters] = m.seconds;
                let e = m.errors;
                record.extend([median, quarter, three_quarters].map(|number| format!("{number:?}")));
                // What is below the reference's own uncertainty is not known.
                let shown = |(error, uncertainty): (f64, f64)| match error > uncertainty {
                    true => format!("{error:?}"),
                    false if uncertainty == 0.0 => String::new(),
                    false => format!("<{uncertainty:?}"),
                };
                record.extend([(e.position, u.position), (e.rate, u.rate), (e.force, u.force)].map(shown));
                record.extend([u.position, u.rate, u.force].map(|number| format!("{number:?}")));
                let known = |number: Option<f64>| number.map_or(String::new(), |number| format!("{number:?}"));
                record.extend([Some(m.residual), m.energy_drift, m.estimate].map(known));
                record.push(String::new());
            }
            Err(reason) => {
                record.extend(vec![String::new(); 14]);
                record.push(reason.lines().next().unwrap_or_default().to_owned());
            }
        }
        writer.write_record(record)?;
    }
    super::super::table_of(writer)
}

/// The table for a terminal.
pub(super) fn printed(setup: &Setup, rungs: &[Rung], reference: &Reference) -> String {
    let times: Vec<String> =
        reference.times().iter().map(|&t| if t < 1e-3 { format!("{t:.6e}") } else { format!("{t:.6}") }).collect();
    let u = reference.uncertainty;
    let mut text = format!(
        "{}: errors at t = {} s\nagainst {}\n(uncertain by {:.1e} in the coordinates, {:.1e} in the rates{})\n",
        setup.description.name,
        times.join(", "),
        reference.origin,
        u.position,
        u.rate,
        if u.force > 0.0 { format!(", {:.1e} in the reactions", u.force) } else { String::new() }
    );
    let mut method = "";
    for rung in rungs {
        if rung.method != method {
            method = rung.method;
            let order =
                order(rungs, method, u.position).map_or(String::new(), |order| format!(", of order {order:.2}"));
            text += &format!(
                "\n  {method}{order}\n  {:>16} {:>8} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
                "", "steps", "time", "position", "rate", "reaction", "residual", "energy", "estimate"
            );
        }
        let setting = match rung.setting {
            Setting::Step(step) => format!("h = {step:.3e} s"),
            Setting::Tolerance(tolerance) => format!("tol = {tolerance:e}"),
        };
        text += &match &rung.result {
            Ok(m) => {
                let shown = |error: f64, uncertainty: f64| {
                    // What is below the reference's own uncertainty is not known.
                    match error > uncertainty {
                        true => format!("{error:.1e}"),
                        // Nothing is without rounding errors: there are no such values.
                        false if uncertainty == 0.0 => "-".to_owned(),
                        false => format!("<{uncertainty:.0e}"),
                    }
                };
                let known = |number: Option<f64>| number.map_or("-".to_owned(), |number| format!("{number:.1e}"));
                let e = m.errors;
                format!(
                    "  {setting:>16} {:>8} {:>10} {:>9} {:>9} {:>9} {:>9.1e} {:>9} {:>9}\n",
                    m.steps,
                    words::milliseconds(m.seconds[1]),
                    shown(e.position, u.position),
                    shown(e.rate, u.rate),
                    shown(e.force, u.force),
                    m.residual,
                    known(m.energy_drift),
                    known(m.estimate)
                )
            }
            Err(reason) => format!("  {setting:>16} {}\n", reason.lines().next().unwrap_or_default()),
        };
    }
    text
}

/// The order that a method with fixed steps shows in the errors of the coordinates: the slope of the straight line nearest to
/// its points, as far as they are clear of rounding errors, and of steps that are too long.
fn order(rungs: &[Rung], method: &str, uncertainty: f64) -> Option<f64> {
    let floor = CLEAR * uncertainty;
    let point = |rung: &Rung| match (&rung.setting, &rung.result) {
        (Setting::Step(step), Ok(m)) if m.errors.position > floor => Some((step.ln(), m.errors.position.ln())),
        _ => None,
    };
    let points: Vec<(f64, f64)> = rungs.iter().filter(|rung| rung.method == method).map_while(point).collect();
    let points = points.get(SKIPPED..)?;
    if points.len() < 3 {
        return None;
    }
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>();
    let order = sum(&|point| (point.0 - x) * (point.1 - y)) / sum(&|point| (point.0 - x).powi(2));
    // Points on no straight line show no order.
    let mut slopes = points.windows(2).map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0));
    slopes.all(|slope| (slope - order).abs() < 1.0).then_some(order)
}

/// So many times the uncertainty is clear of rounding errors.
const CLEAR: f64 = 250.0;
/// The longest steps do not show the order yet.
const SKIPPED: usize = 1;
