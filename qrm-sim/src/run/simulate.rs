//! A run from start to end: steps until a time, an event or a full buffer, rows for an observer, and error estimates.

use std::time::Duration;

use qrm_core::{Mechanism, RowLayout, RowRequest, StopReason, Tape};

use super::companion::Companion;
use super::companion_thread::{Follower, ThreadScope, with_threads};
use super::extreme_search::ExtremeSearch;
use super::first_state::first_state;
use super::monitor::RunMonitor;
use super::observer::Observer;
use super::outcome::{NonFiniteQuantity, Outcome, StartError, Status};
use super::redundancy::Redundancy;
use super::request::{Request, check_step};
use super::sampler::Sampler;
use super::stop_condition::StopCondition;
use crate::event::{End, Reached};
use crate::integrate::{Integrator, IntermediateRows};
#[cfg(feature = "events")]
use crate::position::start_uncertainty;
use crate::position::{AssemblyBranch, Start, StartUncertainty};
use crate::solve::SolverStats;
use crate::state::State;
use crate::stopwatch::Stopwatch;

/// The number of rows between two calls of the observer.
const CHUNK: usize = 1024;

/// Runs a mechanism.
///
/// # Errors
/// The run could not begin. A run that began always has an [`Outcome`].
pub fn simulate(
    mechanism: &dyn Mechanism,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Outcome, StartError> {
    let schedule = mechanism.schedule();
    let step = request.step.unwrap_or(schedule.step);
    let end_time = match request.end {
        Some(End::Time(t)) => t,
        _ => schedule.end_time,
    };
    check_step(step, end_time)?;
    let start = request.start.clone().unwrap_or_else(|| Start::new(mechanism));
    let branch = AssemblyBranch::with_parameters(mechanism, request.scene_parameters.clone());
    let first = first_state(mechanism, &branch, start.clone())?;
    // A page has no room for it.
    #[cfg(not(feature = "events"))]
    let uncertainty: Option<StartUncertainty> = None;
    #[cfg(feature = "events")]
    let uncertainty = match &request.other_start {
        Some(other) => Some(StartUncertainty::known(other)),
        None => start_uncertainty(mechanism, &start, &first.q),
    };
    if let Some(coordinate) = uncertainty.as_ref().and_then(|uncertainty| uncertainty.undetermined_rate(&first.qd)) {
        return Err(StartError::RateNotDetermined(coordinate));
    }
    let settings = request.settings;
    let mut run = Run {
        mechanism,
        request,
        layout: RowLayout { n: first.q.len(), m: first.multipliers.len() },
        rows: RowRequest {
            origin: 0.0,
            step,
            end_time,
            first: 0,
            residual: settings.projection_tolerance.residual,
            watches_event: request.end.is_none(),
        },
        integrator: Integrator::new(mechanism, settings, &first, end_time).map_err(StartError::Step)?,
        sampler: Sampler::new(mechanism, &settings, &first, end_time),
        companion: if request.estimate_error {
            let start = (&first, uncertainty.as_ref());
            Companion::new(mechanism, &settings, start, end_time, observer.needs_outputs())
        } else {
            None
        },
        uncertainty: uncertainty.as_ref().and_then(StartUncertainty::warning),
        redundancy: Redundancy::at(mechanism, &first),
        monitor: RunMonitor::new(mechanism, &first, [observer.needs_outputs(), observer.wants_extremes()]),
        condition: StopCondition::new(mechanism, request.end, &first)?,
        buffer: Vec::new(),
    };
    let is_sampled = run.condition.is_some() || observer.wants_extremes();
    run.integrator.keep_inner_rows(if is_sampled { IntermediateRows::Samples } else { IntermediateRows::StepEnds });
    let is_parallel = request.estimate_error && !request.is_single_threaded;
    Ok(with_threads(is_parallel, |scope| run.run(scope, &first, observer)))
}

struct Run<'a> {
    mechanism: &'a dyn Mechanism,
    request: &'a Request<'a>,
    layout: RowLayout,
    rows: RowRequest,
    integrator: Integrator,
    /// Repeats some of the kernel's steps.
    sampler: Option<Sampler>,
    companion: Option<Companion>,
    /// The coordinate that is known least at the start, with its possible error.
    uncertainty: Option<(usize, f64)>,
    redundancy: Option<Redundancy>,
    monitor: RunMonitor,
    condition: Option<StopCondition<'a>>,
    /// The last row passed on, and those after it.
    buffer: Vec<f64>,
}

impl<'a> Run<'a> {
    fn run<'scope, 'env>(
        &mut self,
        scope: Option<ThreadScope<'scope, 'env>>,
        first: &State,
        observer: &mut dyn Observer,
    ) -> Outcome
    where
        'a: 'scope,
    {
        let mut follower = Follower::new(scope, self.mechanism, self.rows, self.companion.take());
        let width = self.layout.width();
        // A method that chooses its steps must not pass a condition that it does not know.
        let knows_condition = self.request.end.as_ref().is_none_or(|end| matches!(end, End::Time(_)));
        let chunk = if knows_condition || self.integrator.is_fixed() { CHUNK } else { 1 };
        self.buffer.resize((chunk + 1) * width, 0.0);
        first.write(&mut self.buffer);
        self.buffer[self.layout.event()] = self.condition.as_ref().map_or(0.0, StopCondition::nearest);
        let mut search = ExtremeSearch::new(self.layout, &self.buffer[..width]);
        let mut integration = Duration::ZERO;
        let mut end = first.clone();
        let mut steps = 0;
        // The first row belongs to the first block.
        let mut begin = 0;
        loop {
            let begun = Stopwatch::start();
            let (made, mut status) = self.block(steps);
            integration += begun.elapsed();
            if let Some(sampler) = &mut self.sampler {
                let rows = &self.buffer[..(made + 1) * width];
                sampler.follow(self.mechanism, rows, steps, self.integrator.solver_mut());
            }
            let rows = &mut self.buffer[begin * width..(made + 1) * width];
            let before = self.monitor.rows;
            let taken = self.monitor.take(self.mechanism, rows, self.integrator.inner_rows(), observer);
            let rows = &self.buffer[begin * width..(made + 1) * width];
            let first = steps + begin as u64;
            steps += made as u64;
            // A run that cannot continue ends with its last valid row, even if further rows were computed.
            let kept = if taken.is_err() { (self.monitor.rows - before) as usize } else { made + 1 - begin };
            if let Some(last) = kept.checked_sub(1) {
                end.read(&rows[last * width..]);
            }
            if taken.is_err() {
                steps = self.monitor.rows.saturating_sub(1);
            }
            let keep_running =
                taken.and_then(|()| observer.keep_running(end.t, self.rows.end_time).map_err(Status::Unwritable));
            match keep_running {
                Err(ending) => status = Some(ending),
                Ok(false) if status.is_none() => status = Some(Status::Interrupted),
                Ok(_) => {}
            }
            let block = &self.buffer[..(made + 1) * width];
            if let Some((extremes, mut bounds)) = self.monitor.extremes() {
                let mut refined =
                    search.refine(self.mechanism, &self.integrator, block, (&mut *extremes, bounds.as_deref_mut()));
                if refined.is_ok() && status.is_some() {
                    extremes.finish();
                    refined = search.refine(self.mechanism, &self.integrator, block, (extremes, bounds));
                }
                if let Err(ending) = refined {
                    status = Some(ending);
                }
            }
            let extremes = self.monitor.extremes().map_or(&[][..], |(extremes, _)| extremes.found());
            follower.follow(&self.integrator, (rows, first), extremes);
            if let Some(status) = status {
                if !extremes.is_empty() {
                    observer.extremes(extremes);
                }
                let is_kept = !matches!(status, Status::Unwritable(_));
                let last = if is_kept { &self.monitor.columns[..] } else { &[] };
                let status = observer.finish(last).map_or_else(Status::Unwritable, |()| status);
                self.companion = follower.finish();
                if let Some(companion) = &mut self.companion {
                    let condition = self.condition.as_ref().filter(|_| matches!(status, Status::Stopped));
                    companion.finish(self.mechanism, &end, condition);
                }
                return self.outcome(status, end, steps, integration, search);
            }
            search.keep(block);
            self.buffer.copy_within(made * width..(made + 1) * width, 0);
            begin = 1;
        }
    }

    /// Fills the buffer with rows after its first one; returns their number, and the status if the run ends.
    fn block(&mut self, steps: u64) -> (usize, Option<Status>) {
        let width = self.layout.width();
        self.rows.first = steps;
        let block = self.integrator.fill(self.mechanism, &self.rows, &mut self.buffer);
        let mut made = block.rows_written;
        let mut reason = block.reason;
        if let Some(condition) = &mut self.condition {
            let rows = &mut self.buffer[..(made + 1) * width];
            if let Some(found) = condition.write(&mut self.integrator, rows) {
                (made, reason) = (found, Ok(StopReason::Event));
            }
            let rows = &mut self.buffer[..(made + 1) * width];
            match condition.first_reached(&mut self.integrator, rows) {
                Err(reason) => return (made - 1, Some(Status::Failed(reason))),
                Ok(Some((row, reached))) => {
                    condition.note(&rows[..row * width]);
                    return self.reached(row, reached);
                }
                Ok(None) => condition.note(rows),
            }
        }
        match (reason, &self.condition) {
            (Ok(StopReason::Full), _) => (made, None),
            (Err(reason), _) => (made, Some(Status::Failed(reason))),
            (Ok(StopReason::Event), Some(_)) => {
                // The value is not a number.
                let t = self.buffer[made * width];
                (made - 1, Some(Status::NotFinite { t, what: NonFiniteQuantity::Condition }))
            }
            (Ok(StopReason::End), Some(condition)) => (made, Some(condition.not_reached())),
            (Ok(StopReason::End | StopReason::Event), None) => (made, Some(Status::Completed)),
        }
    }

    /// Ends a block where the condition becomes true, before a row.
    fn reached(&mut self, row: usize, reached: Reached) -> (usize, Option<Status>) {
        let width = self.layout.width();
        match reached {
            Reached::Crossed(at) | Reached::Touched(at, _) => {
                at.write(&mut self.buffer[row * width..]);
                self.buffer[row * width + self.layout.event()] = 0.0;
                (row, Some(Status::Stopped))
            }
            Reached::Undefined(t) => (row - 1, Some(Status::NotFinite { t, what: NonFiniteQuantity::Condition })),
            Reached::Undecided(between) => (row - 1, Some(Status::StopUndecided { between })),
        }
    }

    fn outcome(
        &mut self,
        status: Status,
        end: State,
        steps: u64,
        integration: Duration,
        search: ExtremeSearch,
    ) -> Outcome {
        let counts = self.integrator.counts(steps);
        let monitor = &self.monitor;
        let takes_forces = self.mechanism.tape().is_none_or(Tape::outputs_take_forces);
        let unbounded_at = monitor.unbounded_at.or(search.unbounded_at).filter(|_| takes_forces);
        // A load may be zero in every row, and still do work between them.
        let is_conservative = monitor.is_conservative && self.integrator.is_conservative();
        let mut errors = self.companion.as_ref().and_then(|companion| companion.errors(counts.accepted));
        errors.iter_mut().for_each(|errors| errors.note_open(&search.open));
        Outcome {
            tolerance: self.request.settings.tolerance(),
            condition_undecided: self
                .condition
                .as_ref()
                .and_then(|condition| condition.undecided(errors.as_ref(), &self.request.settings)),
            errors,
            companion_failed: self.companion.as_ref().is_some_and(Companion::failed),
            ranges: monitor.ranges.clone(),
            corrections: self.integrator.corrections().to_vec(),
            status,
            step: self.rows.step,
            counts,
            end_time: end.t,
            q: end.q,
            qd: end.qd,
            integration,
            residual_position: monitor.residual_position,
            residual_velocity: monitor.residual_velocity,
            largest_kinetic_energy: monitor.largest_kinetic_energy,
            largest_energy: monitor.largest_energy,
            extremes_of_rows: search.undecided,
            start_uncertainty: self.uncertainty,
            nearest_singular: monitor.singularity.nearest(),
            redundancy: self.redundancy.take(),
            energy_imbalance: monitor.imbalance(
                self.integrator.imbalance(),
                monitor.balance.finished().excess,
                is_conservative,
            ),
            energy_drift: is_conservative.then_some(monitor.energy_drift),
            stats: SolverStats { unbounded_at, ..*self.integrator.stats() },
        }
    }
}
