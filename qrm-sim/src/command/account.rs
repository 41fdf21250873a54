//! What there is to say and to show of a run.

use qrm_core::{Description, QuantityDescription};
#[cfg(feature = "pictures")]
use qrm_view::figure::Figure;

use super::setup::Setup;
use super::words;
use crate::album::Album;
#[cfg(feature = "pictures")]
use crate::figures::{HEALTH, figure, groups, health};
use crate::outcome::{Outcome, Status};
use crate::summary::{ExtremesEntry, Named, SingularEntry, Summary};
use crate::trajectory::{CHECKS, columns};

/// The summary of a run, its files left open.
pub(super) fn summary(setup: &Setup, outcome: &Outcome, album: &Album) -> Summary {
    let description = &setup.description;
    let distrust = words::distrust(outcome, description, setup.method.scheme.tolerance());
    Summary {
        scene: description.name.to_owned(),
        method: setup.method_name,
        projection: setup.projection,
        tolerance: setup.method.scheme.tolerance(),
        closure_tolerance: setup.method.tolerance.residual,
        step: outcome.step,
        steps: outcome.counts.accepted,
        rejected_steps: outcome.counts.rejected,
        implicit_steps: outcome.counts.implicit,
        evaluations: outcome.counts.evaluations,
        rows: 0,
        status: status(outcome),
        message: words::ending(outcome, description, &setup.until),
        end_time: outcome.end_time,
        end_state: end_state(description, outcome),
        run_seconds: outcome.integration.as_secs_f64(),
        estimated_error: outcome.estimated_error,
        max_residual_position: outcome.residual_position.1,
        max_residual_velocity: outcome.residual_velocity.1,
        max_residual_before_correction: outcome.care.open,
        max_correction: outcome.care.moved,
        smallest_singular_value: outcome.nearest_singular.map(|nearest| SingularEntry {
            value: nearest.value,
            largest: nearest.most,
            row: nearest.row,
            time: nearest.t,
            constraint: description.constraints[nearest.constraint].name,
        }),
        careful_solves: outcome.care.singular_mass + outcome.care.suspicious_constraints,
        energy_drift: outcome.energy_drift,
        energy_imbalance: outcome.energy_imbalance,
        extremes: extremes(description, album),
        parameters: named(description.parameters.iter().map(|p| p.name), &setup.scene.parameters(&setup.replace())),
        figures: Vec::new(),
        warnings: words::warnings(outcome, description, &distrust),
        distrust,
    }
}

/// The figures of a run under the names of their files.
#[cfg(feature = "pictures")]
pub(super) fn figures(setup: &Setup, outcome: &Outcome, album: &Album) -> Vec<(String, Figure)> {
    let groups = groups(&setup.text).into_iter();
    let mut figures: Vec<(String, Figure)> = groups.map(|group| (group.file.clone(), figure(&group, album))).collect();
    let title = format!(
        "health of the run: {}, closure tolerance {:e}",
        words::method(setup.method_name, setup.method.scheme.tolerance(), outcome.step),
        setup.method.tolerance.residual
    );
    let is_conservative = outcome.energy_drift.is_some();
    figures.push((HEALTH.to_owned(), health(&setup.text, album, title, is_conservative)));
    figures
}

/// Why a run did not do what was asked.
pub(super) fn problem(outcome: &Outcome, summary: &Summary) -> Option<String> {
    if !outcome.status.is_done() {
        return Some(format!("error: {}", summary.message));
    }
    distrusted(summary)
}

/// Why the numbers of a run are not to be trusted.
pub(super) fn distrusted(summary: &Summary) -> Option<String> {
    (!summary.distrust.is_empty()).then(|| {
        let is_near_singular =
            summary.smallest_singular_value.as_ref().is_some_and(|entry| entry.value < words::SUSPECT * entry.largest);
        let help = if is_near_singular {
            "write that closure in another form, pass the position with other steps or another method, or change the dimensions"
        } else if summary.tolerance.is_some() {
            "use a smaller --tolerance; motions that are sensitive by nature cannot be followed for ever"
        } else {
            "use a shorter --step, or `--method auto`"
        };
        format!("error: do not trust the numbers: {}\n  = help: {help}", summary.distrust.join("; and "))
    })
}

fn status(outcome: &Outcome) -> &'static str {
    match outcome.status {
        Status::Completed => "completed",
        Status::Stopped | Status::StoppedAtStart => "stopped",
        Status::StopNotReached { .. } => "stop_not_reached",
        Status::Interrupted => "interrupted",
        Status::Broken(_) | Status::NotFinite { .. } | Status::Unwritable(_) => "failed",
    }
}

fn named<'n>(names: impl Iterator<Item = &'n str>, values: &[f64]) -> Named<f64> {
    Named(names.map(str::to_owned).zip(values.iter().copied()).collect())
}

fn end_state(description: &Description, outcome: &Outcome) -> Named<f64> {
    let states = description.coordinates.iter().zip(&outcome.q).zip(&outcome.qd);
    let each = |((coordinate, q), qd): ((&QuantityDescription, &f64), &f64)| {
        [(coordinate.name.to_owned(), *q), (format!("{}_dot", coordinate.name), *qd)]
    };
    Named(states.flat_map(each).collect())
}

/// Extremes of every column that describes the motion.
fn extremes(description: &Description, album: &Album) -> Named<ExtremesEntry> {
    let mut columns = columns(description);
    columns.truncate(columns.len() - CHECKS);
    let entry = |name: String| {
        let e = album.extremes(&name)?;
        let ((min, min_time), (max, max_time)) = (e.minimum, e.maximum);
        Some((name, ExtremesEntry { min, min_time, max, max_time }))
    };
    Named(columns.into_iter().skip(1).filter_map(entry).collect())
}
