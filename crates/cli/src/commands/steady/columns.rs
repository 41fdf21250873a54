//! The rates and outputs of a period: means, extremes, fluctuation, work.

use std::f64::consts::TAU;

use qrm_pictures::Recording;
use qrm_scene::unit::Unit;
use qrm_sim::analysis::SteadyMotion;
use qrm_sim::columns::{Column, Kind};
use qrm_sim::run::Outcome;
use serde::Serialize;

use crate::error::Error;
use crate::format::with_error;
use crate::output::Named;
use crate::setup::Setup;

/// The rates and the outputs by their names.
#[derive(Serialize)]
pub(super) struct Columns(pub(super) Named<ColumnEntry>);

/// A rate or an output in a period.
#[derive(Serialize)]
pub(super) struct ColumnEntry {
    pub(super) unit: String,
    pub(super) mean: f64,
    pub(super) mean_error: f64,
    pub(super) min: f64,
    pub(super) min_error: Option<f64>,
    pub(super) min_time: f64,
    /// The coordinate of the phase there.
    pub(super) min_phase: Option<f64>,
    pub(super) max: f64,
    pub(super) max_error: Option<f64>,
    pub(super) max_time: f64,
    pub(super) max_phase: Option<f64>,
    /// The coefficient of fluctuation of a rate: the difference of its extremes, in parts of its mean.
    pub(super) fluctuation: Option<f64>,
    pub(super) fluctuation_error: Option<f64>,
    /// The integral of a power over the period, in J.
    pub(super) work: Option<f64>,
    pub(super) work_error: Option<f64>,
}

/// The number of rows in a recorded period, between which extremes are sought.
const ROWS: f64 = 180.0;
/// The least part of the largest rate that a mean has to be for a coefficient of fluctuation.
const TURNING: f64 = 1e-6;
/// Times in a shorter period, in s, are printed with an exponent.
const SHORT: f64 = 1e-2;
/// The coefficient of fluctuation of an even motion.
const EVEN: f64 = 1e-12;

/// The rates and the outputs of a motion, by a run over its period, which is recorded.
pub(super) fn record_period(
    setup: &mut Setup,
    motion: &SteadyMotion,
    phase: Option<usize>,
    recording: &mut Recording,
) -> Result<Columns, Error> {
    setup.run_over([motion.start.clone(), motion.other_start.clone()], motion.period, motion.period / ROWS);
    let outcome = setup.simulate(true, recording)?;
    Ok(columns(motion, phase, recording, &outcome))
}

/// The rates and the outputs over a period that was recorded; `phase` is the coordinate that tells cycles.
pub(super) fn columns(found: &SteadyMotion, phase: Option<usize>, recording: &Recording, outcome: &Outcome) -> Columns {
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
        // The mean next to a pole is not known.
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
    Columns(Named(recording.columns().filter_map(entry).collect()))
}

/// The value of a series at a time, by lines between its points.
fn interpolated(series: &[(f64, f64)], t: f64) -> Option<f64> {
    let next = series.partition_point(|(other, _)| *other < t).clamp(1, series.len().checked_sub(1)?.max(1));
    let [(t0, x0), (t1, x1)] = [*series.get(next - 1)?, *series.get(next)?];
    Some(x0 + (x1 - x0) * (t - t0) / (t1 - t0))
}

impl Columns {
    /// The columns, one a line; `phase` is the angle whose values are printed with extremes.
    pub(super) fn table(&self, phase: Option<&str>, period: f64) -> String {
        if self.0.0.is_empty() {
            return String::new();
        }
        let at = phase.map_or_else(|| "at t".to_owned(), |phase| format!("at {phase}"));
        let mut text = format!("  {:12} {:>19} {:>19} {at:>11} {:>19} {at:>11}\n", "", "mean", "minimum", "maximum");
        for (name, column) in &self.0.0 {
            let place = |angle: Option<f64>, t: f64| match angle.filter(|_| phase.is_some()) {
                Some(phase) => format!("{:.2} deg", phase.to_degrees().rem_euclid(360.0)),
                None if period < SHORT => format!("{t:.4e}"),
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
        text.extend(self.0.0.iter().filter_map(fluctuation));
        text.extend(self.0.0.iter().filter_map(work));
        text.push('\n');
        text
    }
}
