//! Equilibria and modes in words.

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use super::report::ModesReport;
use crate::format::{counted, number, quantity, with_error, wrapped};
use crate::output::{Named, written};

/// Derivatives that are rounding errors, in parts of the rate.
const ROUNDING: f64 = 1e-15;
/// The largest difference from half a turn, in rad.
const HALF_TURN: f64 = 1e-9;
/// The most entries of a shape that are printed.
const ENTRIES: usize = 8;
/// The most derivatives that are printed for a mode.
const PRINTED: usize = 12;

impl ModesReport {
    /// The text that the command prints.
    pub(super) fn text(&self, files: &[PathBuf]) -> String {
        let mut text = format!("{}\n\n", self.heading);
        let mut line = |topic: &str, line: &str| text += format!("  {topic:11} {line}\n").as_str();
        let no_errors = Named(Vec::new());
        let errors = self.equilibrium.errors.as_ref().unwrap_or(&no_errors);
        for (place, (name, value)) in self.equilibrium.coordinates.0.iter().enumerate() {
            let error = errors.get(name).copied().unwrap_or(0.0);
            let unit = self.units[place];
            let degrees = if unit == "rad" { format!(" = {}", quantity(*value, unit)) } else { String::new() };
            let topic = if place == 0 { "equilibrium" } else { "" };
            line(topic, &format!("{name} = {} {unit}{degrees}", with_error(*value, error)));
        }
        line("stability", &stability_text(self.equilibrium.stability, self.equilibrium.growth));
        let unit = if self.units.iter().all(|unit| *unit == "rad") { "N m" } else { "N or N m" };
        line(
            "found",
            &format!(
                "by {} from {}; forces balance within {:.1e} {unit}",
                counted(u64::from(self.iterations), "iteration"),
                if self.is_from_start { "the start" } else { "another position: the start leads to none" },
                self.equilibrium.residual
            ),
        );
        text.push('\n');
        text += &self.modes_text();
        text += &self.eigenvalues_text();
        text += &self.derivatives_text();
        text += &self.others_text();
        for note in &self.notes {
            text += &format!("\nnote: {note}\n");
        }
        let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        format!("{text}\n{}", written(&files))
    }

    fn modes_text(&self) -> String {
        let mut text = String::new();
        if !self.modes.is_empty() {
            text += &format!("  {:4} {:>22} {:>22}  shape\n", "mode", "frequency, Hz", "rad/s");
        }
        for (place, mode) in self.modes.iter().enumerate() {
            let [hertz, rate] = match mode.kind {
                "oscillation" => {
                    [with_error(mode.frequency, mode.frequency_error), with_error(mode.rate, mode.rate_error)]
                }
                "free" => ["0".to_owned(), "0".to_owned()],
                _ => ["none".to_owned(), with_error(mode.rate, mode.rate_error) + " i"],
            };
            let entries = mode.shape.0.iter().take(ENTRIES);
            let shape: Vec<String> = entries.map(|(name, value)| format!("{name} {}", four_decimals(*value))).collect();
            let left_out = mode.shape.0.len().saturating_sub(ENTRIES);
            let more = if left_out > 0 { format!(", and {left_out} more") } else { String::new() };
            text += &format!("  {:4} {hertz:>22} {rate:>22}  {}{more}\n", place + 1, shape.join(", "));
        }
        for [re, im] in &self.complex_squares {
            text +=
                &format!("  an oscillation grows by loads without a potential: w^2 = {re:.7e} + {im:.7e} i 1/s^2\n");
        }
        text
    }

    fn eigenvalues_text(&self) -> String {
        if self.eigenvalues.iter().all(|value| value.re == 0.0) {
            return String::new();
        }
        let header = ["eigenvalue, 1/s", "frequency, Hz", "damping ratio", "time to 1/e, s"];
        let [s, hertz, ratio, time] = header;
        let mut text = format!("\n  {s:>38} {hertz:>18} {ratio:>18} {time:>18}\n");
        for value in &self.eigenvalues {
            let re = with_error(value.re, value.error);
            let s = if value.im == 0.0 { re } else { format!("{re} +- {} i", with_error(value.im, value.error)) };
            let size = value.re.hypot(value.im);
            let ratio = value.damping_ratio.map_or("-".to_owned(), |ratio| with_error(ratio, value.error / size));
            let time = value.time.map_or("-".to_owned(), |time| {
                let text = with_error(time.abs(), value.error * time * time);
                if time < 0.0 { format!("grows: {text}") } else { text }
            });
            let hertz = if value.im == 0.0 { "-".to_owned() } else { with_error(value.frequency, value.error / TAU) };
            text += &format!("  {s:>38} {hertz:>18} {ratio:>18} {time:>18}\n");
        }
        text
    }

    fn derivatives_text(&self) -> String {
        let mut text = String::new();
        for (place, mode) in self.modes.iter().enumerate() {
            let Some(by) = &mode.by else {
                if mode.kind != "free" {
                    text += &format!(
                        "\n  mode {}: one of several with the same frequency, which has no derivatives",
                        place + 1
                    );
                }
                continue;
            };
            let mut rows: Vec<(&String, f64)> = by.0.iter().map(|(name, value)| (name, *value)).collect();
            rows.retain(|(_, value)| value.abs() > ROUNDING * mode.rate);
            let left_out = rows.len().saturating_sub(PRINTED);
            let values: Vec<String> =
                rows.iter().take(PRINTED).map(|(name, value)| format!("{name} {}", number(*value))).collect();
            let more = if left_out > 0 { format!(", and {left_out} more in modes.csv") } else { String::new() };
            if values.is_empty() {
                continue;
            }
            let first =
                format!("mode {}, derivatives of its rad/s by parameters: {}{more}", place + 1, values.join(", "));
            text += &format!("\n  {}", wrapped(&first, 110).replace('\n', "\n    "));
        }
        if text.is_empty() { text } else { text + "\n" }
    }

    fn others_text(&self) -> String {
        if self.others.is_empty() {
            return String::new();
        }
        let mut text = "\n  other equilibria\n".to_owned();
        for other in &self.others {
            let values = other.coordinates.0.iter().zip(&self.units);
            let place: Vec<String> = values
                .map(|((name, value), unit)| format!("{name} = {}", quantity(turned(*value, unit), unit)))
                .collect();
            let lowest = other.lowest_frequency.map_or(String::new(), |hertz| format!(", lowest {} Hz", number(hertz)));
            text += &format!("  {}: {}{lowest}\n", place.join(", "), stability_text(other.stability, other.growth));
        }
        text
    }
}

/// An angle near minus half a turn as half a turn; other numbers unchanged.
fn turned(value: f64, unit: &str) -> f64 {
    if unit == "rad" && (value + PI).abs() < HALF_TURN { value + TAU } else { value }
}

/// Four decimals, without the sign of a zero.
fn four_decimals(value: f64) -> String {
    let text = format!("{value:.4}");
    if text == "-0.0000" { "0.0000".to_owned() } else { text }
}

fn stability_text(stability: &str, growth: Option<f64>) -> String {
    match (stability, growth) {
        ("asymptotically_stable", _) => "asymptotically stable: deviations die down".to_owned(),
        ("stable", _) => "stable: deviations oscillate, and nothing damps some of them".to_owned(),
        ("free", _) => "free: the mechanism also rests at the positions next to it".to_owned(),
        ("unstable", Some(growth)) => {
            format!("unstable: deviations grow to e times their size in {:.3} s", 1.0 / growth)
        }
        ("unknown", _) => "not known: its linear equations cannot be solved".to_owned(),
        _ => "not known: the linear equations do not tell within their errors".to_owned(),
    }
}
