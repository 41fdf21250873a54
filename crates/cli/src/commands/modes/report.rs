//! Equilibria and modes in words and numbers.

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use qrm_core::Mechanism;
use qrm_scene::time_scales::depends_on_time;
use qrm_sim::analysis::{DampedMode, Equilibrium, Mode, ModeKind, Modes, Stability};
use serde::Serialize;

use crate::error::Error;
use crate::format::{counted, heading, number, quantity, with_error, wrapped};
use crate::output::{Named, written};
use crate::setup::Setup;

/// Equilibria and modes, in the order of `modes.json`.
#[derive(Serialize)]
pub(super) struct ModesReport {
    #[serde(skip)]
    heading: String,
    scene: &'static str,
    pub(super) equilibrium: EquilibriumEntry,
    iterations: u32,
    /// Whether the search from the start leads to the equilibrium.
    is_from_start: bool,
    /// The modes without damping.
    pub(super) modes: Vec<ModeEntry>,
    /// Squares of frequencies that are not real.
    complex_squares: Vec<[f64; 2]>,
    /// The eigenvalues with damping.
    eigenvalues: Vec<EigenvalueEntry>,
    /// The other equilibria that were found.
    others: Vec<EquilibriumEntry>,
    notes: Vec<String>,
    #[serde(skip)]
    pub(super) parameters: Vec<&'static str>,
    #[serde(skip)]
    units: Vec<&'static str>,
}

/// An equilibrium.
#[derive(Serialize)]
pub(super) struct EquilibriumEntry {
    pub(super) coordinates: Named<f64>,
    errors: Option<Named<f64>>,
    multipliers: Named<f64>,
    /// The largest force that is not balanced.
    residual: f64,
    stability: &'static str,
    /// The fastest growth of deviations, in 1/s.
    growth: Option<f64>,
    /// The lowest natural frequency, in Hz.
    lowest_frequency: Option<f64>,
}

/// A mode without damping.
#[derive(Serialize)]
pub(super) struct ModeEntry {
    pub(super) kind: &'static str,
    /// In Hz; zero where the mode does not oscillate.
    pub(super) frequency: f64,
    pub(super) frequency_error: f64,
    /// The frequency in rad/s, or the rate of growth in 1/s.
    pub(super) rate: f64,
    pub(super) rate_error: f64,
    pub(super) square: f64,
    pub(super) square_error: f64,
    pub(super) shape: Named<f64>,
    /// The derivatives of the rate by parameters.
    pub(super) by: Option<Named<f64>>,
}

/// An eigenvalue with damping.
#[derive(Serialize)]
struct EigenvalueEntry {
    re: f64,
    im: f64,
    error: f64,
    frequency: f64,
    damping_ratio: Option<f64>,
    /// The time in which a deviation falls to 1/e, or grows to e times its size; absent where it does neither.
    time: Option<f64>,
}

/// Derivatives that are rounding errors, in parts of the rate.
const ROUNDING: f64 = 1e-15;
/// The largest difference from half a turn, in rad.
const HALF_TURN: f64 = 1e-9;
/// The most entries of a shape that are printed.
const ENTRIES: usize = 8;
/// The most degrees of freedom with which other equilibria are sought.
const MOST_FREEDOM: usize = 8;
/// The most derivatives that are printed for a mode.
const PRINTED: usize = 12;

impl ModesReport {
    /// The report of the equilibria with their modes; the first one has all of its numbers.
    pub(super) fn new(setup: &Setup, mechanism: &dyn Mechanism, found: Vec<super::WithModes>) -> Result<Self, Error> {
        let description = setup.description;
        let entries: Vec<EquilibriumEntry> = found.iter().map(|(at, modes)| entry(setup, at, modes)).collect();
        let mut notes = Vec::new();
        if description.coordinates.len().saturating_sub(description.constraints.len()) > MOST_FREEDOM {
            notes.push(format!("other equilibria are sought with up to {MOST_FREEDOM} degrees of freedom"));
        }
        if depends_on_time(&setup.scene) {
            notes.push("loads that depend on time are those at t = 0".to_owned());
        }
        let mut others = entries.into_iter();
        let mut found = found.into_iter();
        let ((Some(equilibrium), Some((at, modes))), parameters) = (
            (others.next(), found.next()),
            description.parameters.iter().map(|parameter| parameter.name).collect::<Vec<_>>(),
        ) else {
            return Err(Error::run("no equilibrium was found"));
        };
        let modes = modes?;
        if corners(mechanism, setup, &at) {
            notes.push(
                "a load has a corner or a jump at this position: the frequencies hold for the formula that counts there"
                    .to_owned(),
            );
        }
        Ok(Self {
            heading: heading(description),
            scene: description.name,
            equilibrium,
            iterations: at.iterations,
            is_from_start: at.is_from_start,
            modes: modes.undamped.iter().map(|mode| mode_entry(setup, mode)).collect(),
            complex_squares: modes.complex_squares.iter().map(|square| [square.re, square.im]).collect(),
            eigenvalues: modes.damped.iter().map(eigenvalue_entry).collect(),
            others: others.collect(),
            notes,
            parameters,
            units: description.coordinates.iter().map(|coordinate| coordinate.unit).collect(),
        })
    }

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

fn entry(setup: &Setup, at: &Equilibrium, modes: &Result<Modes, Error>) -> EquilibriumEntry {
    let coordinates = setup.description.coordinates;
    let named = |values: &[f64]| {
        Named(coordinates.iter().zip(values).map(|(own, value)| (own.name.to_owned(), *value + 0.0)).collect())
    };
    let constraints = setup.description.constraints.iter().zip(&at.multipliers);
    let modes = modes.as_ref().ok();
    let growth = modes.into_iter().flat_map(|modes| &modes.damped).filter(|mode| mode.value.re > mode.error);
    let oscillations = modes.into_iter().flat_map(|modes| &modes.undamped);
    let mut oscillations = oscillations.filter(|mode| mode.kind() == ModeKind::Oscillation);
    EquilibriumEntry {
        coordinates: named(&at.q),
        errors: modes.map(|modes| named(&modes.q_errors)),
        multipliers: Named(constraints.map(|(own, value)| (own.name.to_owned(), *value)).collect()),
        residual: at.residual,
        stability: modes.map_or("unknown", |modes| stability_name(modes.stability)),
        growth: growth.map(|mode| mode.value.re).reduce(f64::max),
        lowest_frequency: oscillations.next().map(|mode| mode.rate().0 / TAU),
    }
}

fn mode_entry(setup: &Setup, mode: &Mode) -> ModeEntry {
    let (rate, rate_error) = mode.rate();
    let hertz = if mode.kind() == ModeKind::Growth { 0.0 } else { 1.0 / TAU };
    let coordinates = setup.description.coordinates.iter().zip(&mode.shape);
    let parameters = |by: &Vec<f64>| {
        let named = setup.description.parameters.iter().zip(by);
        Named(named.map(|(own, value)| (own.name.to_owned(), *value)).collect())
    };
    ModeEntry {
        kind: match mode.kind() {
            ModeKind::Oscillation => "oscillation",
            ModeKind::Free => "free",
            ModeKind::Growth => "growth",
        },
        frequency: rate * hertz,
        frequency_error: rate_error * hertz,
        rate,
        rate_error,
        square: mode.square,
        square_error: mode.square_error,
        shape: Named(coordinates.map(|(own, value)| (own.name.to_owned(), *value)).collect()),
        by: mode.by_parameters.as_ref().map(parameters),
    }
}

fn eigenvalue_entry(mode: &DampedMode) -> EigenvalueEntry {
    EigenvalueEntry {
        re: mode.value.re + 0.0,
        im: mode.value.im,
        error: mode.error,
        frequency: mode.value.im / TAU,
        damping_ratio: mode.damping_ratio(),
        time: (mode.value.re.abs() > mode.error).then(|| -1.0 / mode.value.re),
    }
}

fn stability_name(stability: Stability) -> &'static str {
    match stability {
        Stability::AsymptoticallyStable => "asymptotically_stable",
        Stability::Stable => "stable",
        Stability::Free => "free",
        Stability::Unstable => "unstable",
        Stability::Undecided => "undecided",
    }
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

/// Whether a load has a corner or a jump at an equilibrium.
fn corners(mechanism: &dyn Mechanism, setup: &Setup, at: &Equilibrium) -> bool {
    let tape = setup.model.tape();
    let mut values = vec![0.0; tape.switching_functions.results.len()];
    let mut evaluator = qrm_core::TapeEvaluator::<Vec<f64>>::with_parameters(tape, mechanism.parameters());
    evaluator.switching_functions(0.0, &at.q, &vec![0.0; at.q.len()], &mut values);
    values.iter().any(|value| value.abs() <= CORNER)
}

/// Switching functions of this size are zero.
const CORNER: f64 = 1e-12;
