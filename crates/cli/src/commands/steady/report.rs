//! The steady motion in words and numbers.

use std::path::Path;

use qrm_pictures::Recording;
use qrm_sim::analysis::{MotionStability, Multiplier, SteadyMotion};
use qrm_sim::position::Start;
use qrm_sim::run::Outcome;
use serde::{Serialize, Serializer};

use super::FoundMotion;
use super::columns::{Columns, columns};
use super::solve::Solved;

use crate::format::{counted, heading, number, with_error};
use crate::output::{Named, written};
use crate::run_report::RunReport;
use crate::setup::Setup;

/// A steady motion, in the order of `steady.json`.
#[derive(Serialize)]
pub(crate) struct SteadyReport {
    #[serde(skip)]
    heading: String,
    scene: &'static str,
    /// The parameter that was solved for.
    #[serde(skip_serializing_if = "Option::is_none")]
    solved: Option<Solved>,
    period: f64,
    period_error: f64,
    /// Whether the period is that of the motion itself.
    has_own_period: bool,
    /// The coordinate whose cycles are the period.
    phase: Option<&'static str>,
    #[serde(skip)]
    is_angle: bool,
    /// The periods of the ordinary motion before the search.
    settled: u32,
    /// The whole turns of each angle in a period.
    turns: Named<f64>,
    /// The coordinates and rates given at the start of a period, and their errors.
    start: Named<f64>,
    start_errors: Named<f64>,
    multipliers: Vec<MultiplierEntry>,
    #[serde(serialize_with = "as_name")]
    stability: MotionStability,
    cycles: u32,
    /// The number of times that the motion repeats within the period.
    repetitions: u32,
    iterations: u32,
    residual: f64,
    steps: u64,
    columns: Columns,
}

/// A Floquet multiplier.
#[derive(Clone, Copy, Serialize)]
pub(super) struct MultiplierEntry {
    re: f64,
    im: f64,
    pub(super) size: f64,
    error: f64,
}

impl SteadyReport {
    /// The report of a motion by a run over its period.
    pub(crate) fn new(setup: &Setup, found: FoundMotion, recording: &Recording, outcome: &Outcome) -> Self {
        let FoundMotion { motion: found, phase, cycles, settled, solved } = found;
        let description = setup.description;
        let coordinates = description.coordinates;
        let multipliers: Vec<MultiplierEntry> = found.multipliers.iter().map(MultiplierEntry::from).collect();
        let angles = (0..coordinates.len()).filter(|&i| description.is_angle(i));
        Self {
            heading: heading(description),
            scene: description.name,
            solved,
            period: found.period,
            period_error: found.period_error,
            has_own_period: phase.is_some(),
            phase: phase.map(|phase| coordinates[phase].name),
            is_angle: phase.is_some_and(|phase| description.is_angle(phase)),
            settled,
            turns: Named(angles.map(|i| (coordinates[i].name.to_owned(), found.turns[i])).collect()),
            start: Named(found.start.given_values(description)),
            start_errors: Named(start_errors(&found).given_values(description)),
            stability: found.stability,
            cycles,
            repetitions: found.repetitions,
            multipliers,
            iterations: found.iterations,
            residual: found.residual,
            steps: found.steps,
            columns: columns(&found, phase, recording, outcome),
        }
    }

    /// The text that the command prints.
    pub(super) fn text(&self, run: &RunReport, folder: &Path) -> String {
        let mut text = format!("{}\n\n", self.heading);
        let mut line = |topic: &str, line: &str| text += &format!("  {topic:11} {line}\n");
        if let Some(solved) = &self.solved {
            line("solved", &solved.text());
        }
        line("period", &self.period_line());
        line("start", &self.start_line());
        line(
            "found",
            &format!(
                "by {} after {}; end and start {}",
                counted(u64::from(self.iterations), "iteration"),
                counted(u64::from(self.settled), "period"),
                if self.residual > 0.0 {
                    format!("differ by {:.1e} of the ranges", self.residual)
                } else {
                    "agree".to_owned()
                }
            ),
        );
        for (place, multiplier) in self.multipliers.iter().enumerate() {
            line(if place == 0 { "multipliers" } else { "" }, &multiplier.text());
        }
        line("stability", &self.stability_line());
        let [_, (_, error), ..] = run.report_lines();
        line("error", &error);
        text.push('\n');
        text += &self.columns.table(self.phase.filter(|_| self.is_angle), self.period);
        for warning in &run.warnings {
            text += &format!("\n{}\n", warning.warning());
        }
        let file = |name: &str| folder.join(name).display().to_string();
        let mut files = vec![
            file("steady.json"),
            format!("{} ({})", file("trajectory.csv"), counted(run.rows, "row")),
            file("summary.json"),
        ];
        if !run.figures.is_empty() {
            files.push(file("figures"));
        }
        format!("{text}\n{}", written(&files))
    }

    fn period_line(&self) -> String {
        let period = if self.has_own_period { with_error(self.period, self.period_error) } else { number(self.period) };
        let turns = |(name, turns): &(String, f64)| match turns.abs() {
            0.0 => None,
            1.0 if *turns < 0.0 => Some(format!("{name} turns once backwards")),
            1.0 => Some(format!("{name} turns once")),
            _ => Some(format!("{name} turns {turns} times")),
        };
        let turns: Vec<String> = self.turns.0.iter().filter_map(turns).collect();
        let turns = if turns.is_empty() { String::new() } else { format!(": {}", turns.join(", ")) };
        let whose = if self.has_own_period { "" } else { ", that of the loads and drives" };
        let again = match self.repetitions {
            1 => String::new(),
            _ => format!("; it repeats already after --cycles {}", self.cycles / self.repetitions),
        };
        format!("{period} s{whose}{turns}{again}")
    }

    fn start_line(&self) -> String {
        let value = |((name, value), (_, error)): (&(String, f64), &(String, f64))| {
            format!("{name} = {}", with_error(*value, *error))
        };
        let values: Vec<String> = self.start.0.iter().zip(&self.start_errors.0).map(value).collect();
        if values.is_empty() { "follows from the drives".to_owned() } else { values.join(", ") }
    }

    fn stability_line(&self) -> String {
        let largest = self.multipliers.first();
        let doubled = largest.is_some_and(|m| m.re < 0.0 && m.im == 0.0 && m.size > 1.0);
        match (self.stability, largest) {
            (MotionStability::NoDeviation, _) | (_, None) => {
                "the drives prescribe the motion: nothing can deviate from it".to_owned()
            }
            (MotionStability::Attracting, Some(m)) => {
                let periods = 0.1_f64.ln() / (m.size + m.error).ln();
                if periods <= 1.0 {
                    "attracting: less than a tenth of a deviation is left after a period".to_owned()
                } else {
                    format!("attracting: deviations fall to a tenth within {} s", three_digits(periods * self.period))
                }
            }
            (MotionStability::Repelling, Some(_)) if doubled => {
                format!(
                    "repelling, and deviations change their sign: seek a motion of twice the period with --cycles {}",
                    2 * self.cycles / self.repetitions
                )
            }
            (MotionStability::Repelling, Some(m)) => {
                let e = self.period / m.size.ln();
                format!("repelling: deviations grow to e times their size in {} s", three_digits(e))
            }
            (MotionStability::Undecided, Some(_)) => {
                "not known: the largest multiplier is one within its error".to_owned()
            }
            (MotionStability::OneOfMany, Some(_)) => {
                "one of many periodic motions: losses or motors that would choose a speed or an amplitude are absent"
                    .to_owned()
            }
        }
    }
}

impl From<&Multiplier> for MultiplierEntry {
    fn from(multiplier: &Multiplier) -> Self {
        let Multiplier { value, error } = *multiplier;
        Self { re: value.re, im: value.im, size: value.norm(), error }
    }
}

impl MultiplierEntry {
    pub(super) fn text(&self) -> String {
        if self.im == 0.0 {
            return with_error(self.re, self.error);
        }
        let sign = if self.im < 0.0 { '-' } else { '+' };
        let [re, im] = [self.re, self.im.abs()].map(|part| with_error(part, self.error));
        format!("{re} {sign} {im} i, of size {}", with_error(self.size, self.error))
    }
}

fn as_name<S: Serializer>(stability: &MotionStability, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(stability_name(*stability))
}

/// The errors of the start of a motion, as a start.
pub(super) fn start_errors(motion: &SteadyMotion) -> Start {
    let [q, qd] = motion.start_errors.clone();
    Start { q, qd, ..motion.start.clone() }
}

/// The name of a stability in files.
pub(super) fn stability_name(stability: MotionStability) -> &'static str {
    match stability {
        MotionStability::NoDeviation => "no_deviation",
        MotionStability::Attracting => "attracting",
        MotionStability::Repelling => "repelling",
        MotionStability::Undecided => "undecided",
        MotionStability::OneOfMany => "one_of_many",
    }
}

/// A number in three digits.
fn three_digits(value: f64) -> String {
    format!("{value:.2e}").parse::<f64>().map_or_else(|_| value.to_string(), |rounded| rounded.to_string())
}
