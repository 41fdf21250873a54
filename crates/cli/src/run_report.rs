//! The report of a run: printed, written as `summary.json` and shown in `report.html`.

mod judgement;
mod text;

use std::path::Path;
use std::time::Duration;

use qrm_core::Description;
use qrm_scene::files::read_at_most;
use qrm_sim::columns::{Column, Kind};
use qrm_sim::run::{ErrorEstimate, ErrorEstimates, Outcome, Redundancy, Status};
use serde::Serialize;

use crate::error::{Error, Message};
use crate::messages::WITHOUT_JUMPS;
use crate::output::Named;
use crate::setup::Setup;
pub(crate) use judgement::{design_warnings, rejection_reasons};
use qrm_pictures::Recording;

/// The largest summary that is read, in bytes.
const MAX_SUMMARY: u64 = 1 << 24;

/// A finished run, in the order of `summary.json`.
#[derive(Debug, Serialize)]
pub(crate) struct RunReport {
    #[serde(skip)]
    description: &'static Description,
    scene: &'static str,
    /// Whether the scene has no compiled functions.
    #[serde(rename = "interpreted")]
    is_interpreted: bool,
    method: &'static str,
    projection: &'static str,
    tolerance: Option<f64>,
    closure_tolerance: f64,
    step: f64,
    steps: u64,
    rejected_steps: u64,
    implicit_steps: u64,
    fallback_steps: u64,
    evaluations: u64,
    pub(crate) rows: u64,
    status: &'static str,
    #[serde(skip)]
    is_done: bool,
    pub(crate) message: Message,
    /// The coordinates and rates that are given at the start.
    start: Named<f64>,
    end_time: f64,
    /// The estimated error of the end time, if a condition ended the run.
    end_time_error: Option<f64>,
    end_state: Named<f64>,
    /// The estimated errors of the end state.
    end_state_errors: Named<f64>,
    run_seconds: f64,
    /// The time that the command took besides.
    #[serde(skip)]
    pub(crate) other_time: Option<Duration>,
    /// The largest estimated error of a coordinate.
    estimated_error: Option<f64>,
    /// The largest estimated error of each column.
    estimated_errors: Named<f64>,
    max_residual_position: f64,
    max_residual_velocity: f64,
    /// The largest residual before a correction after a step, and the largest correction of a coordinate.
    max_residual_before_correction: f64,
    max_correction: f64,
    smallest_singular_value: Option<SingularEntry>,
    /// Solves for which the fast factorization did not suffice.
    careful_solves: u64,
    /// Redundant constraints.
    redundancy: Option<RedundancyEntry>,
    energy_drift: Option<f64>,
    energy_imbalance: f64,
    extremes: Named<ExtremesEntry>,
    pub(crate) parameters: Named<f64>,
    pub(crate) figures: Vec<String>,
    /// Whether a load jumps during the motion.
    #[serde(skip)]
    has_jumps: bool,
    #[serde(skip)]
    has_links: bool,
    /// Whether the given coordinates hardly determine the others at the start.
    #[serde(skip)]
    has_uncertain_start: bool,
    /// The reasons not to trust the results.
    distrust: Vec<String>,
    pub(crate) warnings: Vec<Message>,
}

/// The extremes of a column; null where it is unbounded.
#[derive(Debug, Serialize)]
struct ExtremesEntry {
    min: f64,
    min_time: f64,
    /// The estimated error, like the other one.
    min_error: Option<f64>,
    max: f64,
    max_time: f64,
    max_error: Option<f64>,
}

/// The position with the smallest singular value of C_q.
#[derive(Debug, Serialize)]
struct SingularEntry {
    value: f64,
    /// The largest such value in any row.
    largest: f64,
    row: u64,
    time: f64,
    /// The constraint with the largest part in the vanishing combination.
    constraint: &'static str,
    /// Whether that constraint vanishes alone.
    #[serde(skip)]
    is_alone: bool,
}

/// Redundant constraints, and the quantities that are therefore not unique.
#[derive(Debug, Serialize)]
struct RedundancyEntry {
    constraints: usize,
    /// The rank of C_q.
    rank: usize,
    degrees_of_freedom: usize,
    /// The constraints whose multipliers are not unique.
    multipliers: Vec<&'static str>,
    /// The outputs that are not unique.
    outputs: Vec<&'static str>,
}

impl RedundancyEntry {
    fn from_outcome(outcome: &Outcome, description: &Description) -> Option<Self> {
        let Redundancy { rank, multipliers, outputs } = outcome.redundancy.as_ref()?;
        Some(Self {
            constraints: description.constraints.len(),
            rank: *rank,
            degrees_of_freedom: description.coordinates.len() - rank,
            multipliers: multipliers.iter().map(|&k| description.constraints[k].name).collect(),
            outputs: outputs.iter().map(|&i| description.outputs[i].name).collect(),
        })
    }
}

impl RunReport {
    /// Creates the report of a run, before its files are written.
    pub(crate) fn new(setup: &Setup, outcome: &Outcome, recording: &Recording) -> Self {
        let description = setup.description;
        let tolerance = setup.settings.tolerance();
        let mut distrust = rejection_reasons(setup, outcome);
        distrust.extend(setup.passed_over(outcome.end_time));
        let parameters = description.parameters.iter().map(|p| p.name.to_owned());
        let end_time_error = outcome.errors.as_ref().and_then(ErrorEstimates::end_time);
        Self {
            description,
            scene: description.name,
            is_interpreted: setup.model.is_interpreted(),
            method: setup.settings.method.name,
            projection: setup.settings.projection.name(),
            tolerance,
            closure_tolerance: setup.settings.projection_tolerance.residual,
            step: outcome.step,
            steps: outcome.counts.accepted,
            rejected_steps: outcome.counts.rejected,
            implicit_steps: outcome.counts.implicit,
            fallback_steps: outcome.counts.fallback,
            evaluations: outcome.counts.evaluations,
            rows: 0,
            status: status(outcome),
            is_done: outcome.status.is_done(),
            message: setup.status(&outcome.status, (outcome.end_time, end_time_error)),
            start: Named(setup.start().given_values(description)),
            end_time: outcome.end_time,
            end_time_error,
            end_state: end_state(outcome, recording),
            end_state_errors: errors(outcome, recording, |error, kind| {
                matches!(kind, Kind::Coordinate(_) | Kind::Rate(_)).then_some(error.at_end)
            }),
            run_seconds: outcome.integration.as_secs_f64(),
            other_time: None,
            estimated_error: outcome.estimated_error(),
            estimated_errors: errors(outcome, recording, |error, _| Some(error.largest)),
            max_residual_position: outcome.residual_position.1,
            max_residual_velocity: outcome.residual_velocity.1,
            max_residual_before_correction: outcome.stats.residual_before_correction,
            max_correction: outcome.corrections.iter().fold(0.0_f64, |most, correction| most.max(*correction)),
            smallest_singular_value: outcome.nearest_singular.map(|nearest| SingularEntry {
                value: nearest.value,
                largest: nearest.most,
                row: nearest.row,
                time: nearest.t,
                constraint: description.constraints[nearest.constraint].name,
                is_alone: nearest.is_alone,
            }),
            careful_solves: outcome.stats.singular_mass + outcome.stats.suspicious_constraints,
            redundancy: RedundancyEntry::from_outcome(outcome, description),
            energy_drift: outcome.energy_drift,
            energy_imbalance: outcome.energy_imbalance,
            extremes: extremes(outcome, recording),
            parameters: Named(parameters.zip(setup.model.parameter_values(&setup.replace())).collect()),
            figures: Vec::new(),
            has_jumps: setup.scene.has_jumps(),
            has_links: setup.scene.has_links,
            has_uncertain_start: outcome.start_uncertainty.is_some(),
            warnings: [
                setup.notes.clone(),
                judgement::warnings(setup, outcome, &distrust),
                judgement::open_joints(setup, recording),
            ]
            .concat(),
            distrust,
        }
    }

    /// Returns an error if the run failed.
    pub(crate) fn problem(&self) -> Option<Error> {
        if self.is_done { self.distrusted() } else { Some(self.message.clone().into()) }
    }

    /// Returns an error if the results of the run cannot be trusted.
    pub(crate) fn distrusted(&self) -> Option<Error> {
        if self.distrust.is_empty() {
            return None;
        }
        let singular = self.smallest_singular_value.as_ref();
        let near = singular.filter(|entry| entry.value < judgement::EXPLAINS_FAILURE * entry.largest);
        let help = if let Some(entry) = near {
            if entry.is_alone && !self.has_links {
                "write that constraint in another form, pass the position with other steps or another method, or \
                 change the dimensions"
            } else {
                "branches meet at that position: pass it with other steps or another method, begin elsewhere, or \
                 change the dimensions"
            }
        } else if self.has_uncertain_start {
            "begin elsewhere, or give other coordinates at the start: those that are given hardly determine the others"
        } else if self.has_jumps {
            WITHOUT_JUMPS
        } else if self.tolerance.is_some() {
            "use a smaller --tolerance; chaotic motions cannot be predicted indefinitely"
        } else {
            "use a shorter --step, or `--method auto`"
        };
        Some(Error::run(format!("do not trust the numbers: {}", self.distrust.join("; and "))).help(help))
    }

    /// The figures listed in the summary of an earlier run in a folder; empty without such a summary.
    pub(crate) fn figures_in(folder: &Path) -> Vec<String> {
        let text = read_at_most(&folder.join("summary.json"), MAX_SUMMARY).unwrap_or_default();
        let summary: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
        let listed = summary["figures"].as_array().cloned().unwrap_or_default();
        let names = listed.iter().filter_map(|figure| figure.as_str());
        // The file may have any content; only figures are removed.
        let is_figure = |name: &&str| {
            name.strip_prefix("figures/").is_some_and(|name| name.ends_with(".svg") && !name.contains(['/', '\\']))
        };
        names.filter(is_figure).map(str::to_owned).collect()
    }
}

fn status(outcome: &Outcome) -> &'static str {
    match outcome.status {
        Status::Completed => "completed",
        Status::Stopped => "stopped",
        Status::StopNotReached { .. } => "stop_not_reached",
        Status::Interrupted => "interrupted",
        Status::StopUndecided { .. } | Status::Failed(_) | Status::NotFinite { .. } | Status::Unwritable(_) => "failed",
    }
}

/// Coordinates and rates at the end.
fn end_state(outcome: &Outcome, recording: &Recording) -> Named<f64> {
    let value = |kind: Kind| match kind {
        Kind::Coordinate(i) => Some(outcome.q[i]),
        Kind::Rate(i) => Some(outcome.qd[i]),
        _ => None,
    };
    let columns = recording.columns();
    Named(columns.filter_map(|column| Some((column.name.clone(), value(column.kind)?))).collect())
}

/// The errors of the columns with error estimates.
fn errors(outcome: &Outcome, recording: &Recording, part: impl Fn(ErrorEstimate, Kind) -> Option<f64>) -> Named<f64> {
    let Some(estimates) = &outcome.errors else { return Named(Vec::new()) };
    let error = |column: &Column| Some((column.name.clone(), part(estimates.column(column.kind)?, column.kind)?));
    Named(recording.columns().filter_map(error).collect())
}

/// The extremes of every column that describes the motion.
fn extremes(outcome: &Outcome, recording: &Recording) -> Named<ExtremesEntry> {
    let described = recording.columns().filter(|column| column.kind != Kind::Time && !column.kind.is_check());
    let entries = described.filter_map(|column| {
        let e = recording.extremes(column.kind)?;
        let ((min, min_time), (max, max_time)) = (e.minimum, e.maximum);
        let errors = outcome.errors.as_ref().and_then(|errors| errors.extremes(column.kind, &e));
        let known = |value: f64, end: usize| errors.map(|errors| errors[end]).filter(|_| value.is_finite());
        let [min_error, max_error] = [known(min, 0), known(max, 1)];
        Some((column.name.clone(), ExtremesEntry { min, min_time, min_error, max, max_time, max_error }))
    });
    Named(entries.collect())
}
