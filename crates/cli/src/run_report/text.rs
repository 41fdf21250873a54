//! The report of a run in words.

use std::path::Path;

use qrm_core::{Description, QuantityDescription};

use super::RunReport;
use crate::format::{counted, decimals, heading, seconds, with_error};
use crate::output::written;

impl RunReport {
    /// How the run ended, how far to trust it and how it was computed, in lines with headings.
    pub(crate) fn report_lines(&self) -> [(&'static str, String); 6] {
        [
            ("end", self.message.to_string()),
            ("error", self.error_line()),
            ("closure", self.residual_line()),
            ("energy", self.energy_line()),
            ("method", self.method_line()),
            ("time", self.time_line()),
        ]
    }

    /// The extremes of the outputs: name, minimum, its time, maximum, its time, unit.
    pub(crate) fn output_extremes(&self) -> Vec<[String; 6]> {
        self.extremes_of(self.description.outputs)
    }

    /// The extremes of the outputs; those of the coordinates in a scene without outputs.
    fn shown_extremes(&self) -> Vec<[String; 6]> {
        let Description { outputs, coordinates, .. } = self.description;
        self.extremes_of(if outputs.is_empty() { coordinates } else { outputs })
    }

    fn extremes_of(&self, quantities: &[QuantityDescription]) -> Vec<[String; 6]> {
        let row = |quantity: &QuantityDescription| {
            let e = self.extremes.get(quantity.name)?;
            let [at_min, at_max] = [e.min_time, e.max_time].map(|t| format!("{t:.6}"));
            let [min, max] = [(e.min, e.min_error), (e.max, e.max_error)].map(|(value, error)| match error {
                _ if value.is_infinite() => "unbounded".to_owned(),
                Some(error) => with_error(value, error),
                None => decimals(value),
            });
            Some([quantity.name.to_owned(), min, at_min, max, at_max, quantity.unit.to_owned()])
        };
        quantities.iter().filter_map(row).collect()
    }

    /// Whether an output does not depend on how redundant constraints share their forces.
    fn is_unique(&self, output: &str) -> bool {
        !self.redundancy.as_ref().is_some_and(|redundancy| redundancy.outputs.contains(&output))
    }

    /// The text printed by a run; `tables` are additional files.
    pub(crate) fn text(&self, out: &Path, tables: &[String], has_summary: bool) -> String {
        let [(_, end), lines @ ..] = self.report_lines();
        let mut text = format!("{}\n\n  {end}\n\n", heading(self.description));
        let extremes = self.shown_extremes();
        if !extremes.is_empty() {
            text += &format!("  {:10} {:>19} {:>11} {:>19} {:>11}\n", "", "minimum", "at t", "maximum", "at t");
        }
        for [name, min, at_min, max, at_max, unit] in &extremes {
            let row = format!("  {name:10} {min:>19} {at_min:>11} {max:>19} {at_max:>11}  {unit}");
            let mark = if self.is_unique(name) { "" } else { "  (not unique)" };
            text += &format!("{}{mark}\n", row.trim_end());
        }
        if !extremes.is_empty() {
            text.push('\n');
        }
        for (topic, line) in lines {
            text += &format!("  {topic:8}  {line}\n");
        }
        for warning in &self.warnings {
            text += &format!("\n{}\n", warning.warning());
        }
        let mut files = Vec::new();
        if self.rows > 0 {
            let table = out.join("trajectory.csv");
            files.push(format!("{} ({}; units in trajectory.units.json)", table.display(), counted(self.rows, "row")));
        }
        files.extend_from_slice(tables);
        if has_summary {
            files.push(out.join("summary.json").display().to_string());
        }
        if !self.figures.is_empty() {
            let name = |file: &String| Path::new(file).file_stem().unwrap_or_default().display().to_string();
            let names: Vec<String> = self.figures.iter().map(name).collect();
            files.push(format!("{} ({})", out.join("figures").display(), names.join(", ")));
        }
        format!("{text}\n{}", written(&files))
    }

    fn method_line(&self) -> String {
        let (steps, step, projection) = (counted(self.steps, "step"), seconds(self.step), self.projection);
        let name = self.method.to_uppercase();
        let Some(tolerance) = self.tolerance else {
            return format!("{name}, {steps} of {step}, projection: {projection}");
        };
        let of_them = match self.method {
            "auto" => format!(" ({} implicit)", self.implicit_steps),
            _ if self.fallback_steps > 0 => format!(" ({} of them by auto)", self.fallback_steps),
            _ => String::new(),
        };
        format!(
            "{name}, {steps}{of_them} and {} rejected for a tolerance of {tolerance:e}, rows every {step}, \
             projection: {projection}",
            self.rejected_steps
        )
    }

    fn time_line(&self) -> String {
        let per_step = self.run_seconds * 1e9 / self.steps.max(1) as f64;
        let way = if self.is_interpreted {
            format!("; interpreted: compiled, it would be about {} times as fast", compiled_speed(self.method))
        } else {
            String::new()
        };
        let other = self.other_time.map(|time| format!("; {:.0} ms for everything else", time.as_secs_f64() * 1e3));
        let integration = format!("{:.3} ms for the integration, {per_step:.0} ns a step", self.run_seconds * 1e3);
        integration + &way + &other.unwrap_or_default()
    }

    fn error_line(&self) -> String {
        let Some(error) = self.estimated_error else { return "not estimated".to_owned() };
        let others = if self.tolerance.is_some() { "a smaller tolerance" } else { "steps 1.5 times as long" };
        format!("at most about {error:.1e} in the coordinates, estimated by comparison with {others}")
    }

    fn residual_line(&self) -> String {
        let before = match self.max_residual_before_correction {
            open if open > 0.0 => format!(" ({open:.1e} before projection)"),
            _ => String::new(),
        };
        let (position, velocity) = (self.max_residual_position, self.max_residual_velocity);
        format!("max |C| {position:.1e}{before}, max |dC/dt| {velocity:.1e}")
    }

    fn energy_line(&self) -> String {
        match self.energy_drift {
            Some(drift) => format!("within {drift:.1e} J of its value at the start"),
            None if self.energy_imbalance > 0.0 => {
                format!("differs from the work of the loads without potential by {:.1e} J", self.energy_imbalance)
            }
            None => "equals the work of the loads without potential, within the error of its sum".to_owned(),
        }
    }
}

/// The ratio of the speeds of compiled and interpreted functions, from `cargo bench --bench interpreted`.
fn compiled_speed(method: &str) -> u32 {
    // Fixed steps compute little apart from the functions.
    if method == "rk4" { 5 } else { 3 }
}
