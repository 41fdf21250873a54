//! What a person wants to know of a finished run at once.

use std::path::Path;

use qrm_core::Description;

use super::words::seconds;
use crate::summary::Summary;

/// How a run went.
pub(super) fn facts(summary: &Summary) -> [(&'static str, String); 6] {
    let Summary { steps, run_seconds, max_residual_position, max_residual_velocity, .. } = summary;
    let before = match summary.max_residual_before_correction {
        open if open > 0.0 => format!("; {open:.1e} before the corrections"),
        _ => String::new(),
    };
    let per_step = run_seconds * 1e9 / (*steps).max(1) as f64;
    let method = match summary.tolerance {
        None if summary.method == "document" => {
            format!("RK4 as in the document, {steps} steps of {}", seconds(summary.step))
        }
        None => format!("RK4, {steps} steps of {}, projection: {}", seconds(summary.step), summary.projection),
        Some(tolerance) => format!(
            "{}, {steps} steps{} and {} rejected for a tolerance of {tolerance:e}, rows every {}, projection: {}",
            summary.method.to_uppercase(),
            if summary.method == "auto" { format!(" ({} implicit)", summary.implicit_steps) } else { String::new() },
            summary.rejected_steps,
            seconds(summary.step),
            summary.projection
        ),
    };
    let second =
        if summary.tolerance.is_some() { "a run at a tenth of the tolerance" } else { "a run at twice the step" };
    let error = match summary.estimated_error {
        Some(error) => format!("about {error:.1e} at most in the coordinates, judged by {second}"),
        None => "not estimated".to_owned(),
    };
    let energy = match summary.energy_drift {
        Some(drift) => format!("within {drift:.1e} J of its value at the start"),
        None if summary.energy_imbalance > 0.0 => {
            format!("differs from the work of the loads without potential by {:.1e} J", summary.energy_imbalance)
        }
        None => "changes by the work of the loads without potential, as far as the steps tell it".to_owned(),
    };
    [
        ("end", summary.message.clone()),
        ("method", method),
        ("time", format!("{:.3} ms for the integration, {per_step:.0} ns a step", run_seconds * 1e3)),
        ("error", error),
        (
            "residual",
            format!(
                "at most {max_residual_position:.1e} of a constraint, {max_residual_velocity:.1e} of its rate{before}"
            ),
        ),
        ("energy", energy),
    ]
}

/// The text that a run prints.
pub(super) fn digest(
    summary: &Summary,
    description: &Description,
    out: &Path,
    tables: &[String],
    has_summary: bool,
) -> String {
    let rows = summary.rows;
    let mut text = format!("{}: {}\n\n", summary.scene, description.doc);
    for (what, fact) in facts(summary) {
        text += &format!("  {what:8}  {fact}\n");
    }
    if !description.outputs.is_empty() {
        text += &format!("\n  {:10} {:>14} {:>11} {:>14} {:>11}\n", "", "minimum", "at t", "maximum", "at t");
    }
    for output in description.outputs {
        if let Some((name, e)) = summary.extremes.0.iter().find(|(name, _)| name == output.name) {
            let (low, high) = (number(e.min), number(e.max));
            text += &format!(
                "  {name:10} {low:>14} {:>11.6} {high:>14} {:>11.6}  {}\n",
                e.min_time, e.max_time, output.unit
            );
        }
    }
    for warning in &summary.warnings {
        text += &format!("\nwarning: {warning}\n");
    }
    let mut files = Vec::new();
    if rows > 0 {
        files.push(format!("{} ({rows} rows; units in trajectory.units.json)", out.join("trajectory.csv").display()));
    }
    files.extend_from_slice(tables);
    if has_summary {
        files.push(out.join("summary.json").display().to_string());
    }
    if !summary.figures.is_empty() {
        let name = |file: &String| Path::new(file).file_stem().unwrap_or_default().display().to_string();
        let names: Vec<String> = summary.figures.iter().map(name).collect();
        files.push(format!("{} ({})", out.join("figures").display(), names.join(", ")));
    }
    let files = if files.is_empty() { "nothing".to_owned() } else { files.join("\n      ") };
    text + &format!("\nwrote {files}")
}

/// A number in the width of a column.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) { format!("{value:.7}") } else { format!("{value:.6e}") }
}
