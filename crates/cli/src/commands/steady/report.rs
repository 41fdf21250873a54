//! The steady motion in words and numbers.

use std::f64::consts::TAU;
use std::path::Path;

use qrm_scene::unit::Unit;
use qrm_sim::analysis::SteadyMotion;
use qrm_sim::columns::{Column, Kind};
use qrm_sim::position::Start;
use serde::Serialize;

use crate::format::{counted, heading, number, with_error};
use crate::output::{Named, written};
use crate::run_files::FinishedRun;
use crate::run_report::RunReport;
use crate::setup::Setup;

/// A steady motion, in the order of `steady.json`.
#[derive(Serialize)]
pub(super) struct SteadyReport {
    #[serde(skip)]
    heading: String,
    scene: &'static str,
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
    stability: Stability,
    iterations: u32,
    residual: f64,
    steps: u64,
    columns: Named<ColumnEntry>,
}

/// A Floquet multiplier.
#[derive(Clone, Copy, Serialize)]
struct MultiplierEntry {
    re: f64,
    im: f64,
    size: f64,
    error: f64,
}

/// What becomes of small deviations.
#[derive(Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Stability {
    /// There are none: the drives leave no degree of freedom.
    NoDeviation,
    /// All become smaller.
    Attracting,
    /// One grows.
    Repelling,
    /// The largest multiplier is one within its error.
    Undecided,
    /// The motion is one of many at other speeds or amplitudes.
    OneOfMany,
}

/// A rate or an output in a period.
#[derive(Serialize)]
struct ColumnEntry {
    unit: String,
    mean: f64,
    mean_error: f64,
    min: f64,
    min_error: Option<f64>,
    min_time: f64,
    /// The coordinate of the phase there.
    min_phase: Option<f64>,
    max: f64,
    max_error: Option<f64>,
    max_time: f64,
    max_phase: Option<f64>,
    /// The coefficient of fluctuation of a rate: the difference of its extremes, in parts of its mean.
    fluctuation: Option<f64>,
    fluctuation_error: Option<f64>,
    /// The integral of a power over the period, in J.
    work: Option<f64>,
    work_error: Option<f64>,
}

/// The least part of the largest rate that a mean has to be for a coefficient of fluctuation.
const TURNING: f64 = 1e-6;
/// Times in a shorter period, in s, are printed with an exponent.
const SHORT: f64 = 1e-2;
/// The coefficient of fluctuation of an even motion.
const EVEN: f64 = 1e-12;

impl SteadyReport {
    pub(super) fn new(
        setup: &Setup,
        found: &SteadyMotion,
        phase: Option<usize>,
        settled: u32,
        finished: &FinishedRun,
    ) -> Self {
        let description = setup.description;
        let coordinates = description.coordinates;
        let errors =
            Start { q: found.start_errors[0].clone(), qd: found.start_errors[1].clone(), ..found.start.clone() };
        let entry = |multiplier: &qrm_sim::analysis::Multiplier| MultiplierEntry {
            re: multiplier.value.re,
            im: multiplier.value.im,
            size: multiplier.value.norm(),
            error: multiplier.error,
        };
        let multipliers: Vec<MultiplierEntry> = found.multipliers.iter().map(entry).collect();
        let angles = (0..coordinates.len()).filter(|&i| description.is_angle(i));
        Self {
            heading: heading(description),
            scene: description.name,
            period: found.period,
            period_error: found.period_error,
            has_own_period: phase.is_some(),
            phase: phase.map(|phase| coordinates[phase].name),
            is_angle: phase.is_some_and(|phase| description.is_angle(phase)),
            settled,
            turns: Named(angles.map(|i| (coordinates[i].name.to_owned(), found.turns[i])).collect()),
            start: Named(found.start.given_values(description)),
            start_errors: Named(errors.given_values(description)),
            stability: stability(&multipliers, found.is_one_of_many),
            multipliers,
            iterations: found.iterations,
            residual: found.residual,
            steps: found.steps,
            columns: columns(found, phase, finished),
        }
    }

    /// The text that the command prints.
    pub(super) fn text(&self, run: &RunReport, folder: &Path) -> String {
        let mut text = format!("{}\n\n", self.heading);
        let mut line = |topic: &str, line: &str| text += &format!("  {topic:11} {line}\n");
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
        text += &self.table();
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
        format!("{period} s{whose}{turns}")
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
            (Stability::NoDeviation, _) | (_, None) => {
                "the drives prescribe the motion: nothing can deviate from it".to_owned()
            }
            (Stability::Attracting, Some(m)) => {
                let periods = 0.1_f64.ln() / (m.size + m.error).ln();
                if periods <= 1.0 {
                    "attracting: less than a tenth of a deviation is left after a period".to_owned()
                } else {
                    format!("attracting: deviations fall to a tenth within {} s", three_digits(periods * self.period))
                }
            }
            (Stability::Repelling, Some(_)) if doubled => {
                "repelling, and deviations change their sign: seek a motion of twice the period with --cycles 2"
                    .to_owned()
            }
            (Stability::Repelling, Some(m)) => {
                let e = self.period / m.size.ln();
                format!("repelling: deviations grow to e times their size in {} s", three_digits(e))
            }
            (Stability::Undecided, Some(_)) => "not known: the largest multiplier is one within its error".to_owned(),
            (Stability::OneOfMany, Some(_)) => {
                "one of many periodic motions: losses or motors that would choose a speed or an amplitude are absent"
                    .to_owned()
            }
        }
    }

    /// The columns, one a line.
    fn table(&self) -> String {
        if self.columns.0.is_empty() {
            return String::new();
        }
        let at = self.phase.filter(|_| self.is_angle).map_or_else(|| "at t".to_owned(), |phase| format!("at {phase}"));
        let mut text = format!("  {:12} {:>19} {:>19} {at:>11} {:>19} {at:>11}\n", "", "mean", "minimum", "maximum");
        for (name, column) in &self.columns.0 {
            let place = |phase: Option<f64>, t: f64| match phase.filter(|_| self.is_angle) {
                Some(phase) => format!("{:.2} deg", phase.to_degrees().rem_euclid(360.0)),
                None if self.period < SHORT => format!("{t:.4e}"),
                None => format!("{t:.6}"),
            };
            let [low, high] = [place(column.min_phase, column.min_time), place(column.max_phase, column.max_time)];
            let value = |value: f64, error: Option<f64>| match value {
                value if value.is_finite() => with_error(value, error.unwrap_or(0.0)),
                value if value.is_nan() => "unknown".to_owned(),
                _ => "unbounded".to_owned(),
            };
            text += format!(
                "  {name:12} {:>19} {:>19} {low:>11} {:>19} {high:>11}  {}",
                value(column.mean, Some(column.mean_error)),
                value(column.min, column.min_error),
                value(column.max, column.max_error),
                column.unit
            )
            .trim_end();
            text.push('\n');
        }
        let fluctuation = |(name, column): &(String, ColumnEntry)| {
            let fluctuation = column.fluctuation.filter(|fluctuation| *fluctuation > EVEN)?;
            let fluctuation = with_error(fluctuation, column.fluctuation_error.unwrap_or(0.0));
            Some(format!("\n  {name} fluctuates by {fluctuation} of its mean"))
        };
        let work = |(name, column): &(String, ColumnEntry)| {
            let work = with_error(column.work?, column.work_error.unwrap_or(0.0));
            Some(format!("\n  {name} does a work of {work} J in a period"))
        };
        text.extend(self.columns.0.iter().filter_map(fluctuation));
        text.extend(self.columns.0.iter().filter_map(work));
        text.push('\n');
        text
    }
}

impl MultiplierEntry {
    fn text(&self) -> String {
        if self.im == 0.0 {
            return with_error(self.re, self.error);
        }
        let sign = if self.im < 0.0 { '-' } else { '+' };
        let [re, im] = [self.re, self.im.abs()].map(|part| with_error(part, self.error));
        format!("{re} {sign} {im} i, of size {}", with_error(self.size, self.error))
    }
}

fn stability(multipliers: &[MultiplierEntry], is_one_of_many: bool) -> Stability {
    match multipliers.first() {
        None => Stability::NoDeviation,
        Some(_) if is_one_of_many => Stability::OneOfMany,
        Some(largest) if largest.size + largest.error < 1.0 => Stability::Attracting,
        Some(largest) if largest.size - largest.error > 1.0 => Stability::Repelling,
        Some(_) => Stability::Undecided,
    }
}

/// The rates and the outputs.
fn columns(found: &SteadyMotion, phase: Option<usize>, finished: &FinishedRun) -> Named<ColumnEntry> {
    let FinishedRun { recording, outcome, .. } = finished;
    let phases = phase.map(|phase| recording.series(Kind::Coordinate(phase)));
    let phase_at = |t: f64| phases.as_ref().and_then(|series| interpolated(series, t));
    let entry = |column: &Column| {
        let estimates = outcome.errors.as_ref();
        let (mean, mean_error) = match column.kind {
            Kind::Rate(i) => {
                let mean = TAU * found.turns[i] / found.period;
                (mean, mean.abs() * (found.period_error / found.period + f64::EPSILON))
            }
            Kind::Output(i) => {
                let (mean, of_sum) = found.means[i];
                let of_motion =
                    estimates.and_then(|errors| errors.column(column.kind)).map_or(0.0, |error| error.largest);
                (mean, of_sum + of_motion)
            }
            _ => return None,
        };
        let e = recording.extremes(column.kind)?;
        let ((min, min_time), (max, max_time)) = (e.minimum, e.maximum);
        // The mean beside a pole is not known.
        let mean = if min.is_finite() && max.is_finite() { mean } else { f64::NAN };
        let [min_error, max_error] = match estimates.and_then(|errors| errors.extremes(column.kind, &e)) {
            Some(errors) => errors.map(Some),
            None => [None; 2],
        };
        let is_turning = matches!(column.kind, Kind::Rate(_)) && mean.abs() > TURNING * min.abs().max(max.abs());
        let fluctuation = is_turning.then(|| (max - min) / mean.abs());
        let of_extremes = min_error.unwrap_or(0.0) + max_error.unwrap_or(0.0);
        let power = Unit::parse("W").zip(Unit::parse(&column.unit)).filter(|(watt, unit)| unit.fits(watt));
        let power = power.map(|(_, unit)| unit.factor());
        Some((
            column.name.clone(),
            ColumnEntry {
                unit: column.unit.clone(),
                mean,
                mean_error,
                min,
                min_error,
                min_time,
                min_phase: phase_at(min_time),
                max,
                max_error,
                max_time,
                max_phase: phase_at(max_time),
                fluctuation,
                fluctuation_error: fluctuation.map(|value| (of_extremes + value * mean_error) / mean.abs()),
                work: power.map(|watts| mean * watts * found.period),
                work_error: power.map(|watts| watts * (mean_error * found.period + mean.abs() * found.period_error)),
            },
        ))
    };
    Named(recording.columns().filter_map(entry).collect())
}

/// The value of a series at a time, by lines between its points.
fn interpolated(series: &[(f64, f64)], t: f64) -> Option<f64> {
    let next = series.partition_point(|(other, _)| *other < t).clamp(1, series.len().checked_sub(1)?.max(1));
    let [(t0, x0), (t1, x1)] = [*series.get(next - 1)?, *series.get(next)?];
    Some(x0 + (x1 - x0) * (t - t0) / (t1 - t0))
}

/// A number in three digits.
fn three_digits(value: f64) -> String {
    format!("{value:.2e}").parse::<f64>().map_or_else(|_| value.to_string(), |rounded| rounded.to_string())
}
