//! A run from start to end: steps until a time, an event or a full buffer, rows for an observer, estimates of the
//! errors.

use std::time::Duration;

use qrm_core::{Mechanism, RowLayout, RowRequest};

use super::companion::Companion;
use super::companion_thread::{Follower, ThreadScope, with_threads};
use super::continuation::Branch;
use super::extremes::Vertex;
use super::monitor::RunMonitor;
use super::observer::Observer;
use super::outcome::{Outcome, StartError, Status, Undefined};
use super::redundancy::Redundancy;
use super::sampler::Sampler;
use crate::columns::number;
use crate::event::{locate, touched};
use crate::integrate::{BlockEnd, InnerRows, Integrator, MethodSettings, StepError};
use crate::peak::peak_between;
use crate::solve::{Solver, constraint_rank};
use crate::start::Start;
use crate::state::State;
use crate::stopwatch::Stopwatch;

/// Rows between two calls of the observer.
const CHUNK: usize = 1024;

/// Where it is looked at whether a column rises from a row, against the distance of rows.
const BESIDE: f64 = 1e-3;

/// Rows that a polynomial for an extreme goes through.
const TAIL: usize = 5;

/// A condition may be met between two rows where its distance from true is less than so many of its changes from row to
/// row.
const NEAR: f64 = 8.0;

/// A run to make.
#[derive(Default)]
pub struct Request<'a> {
    /// The method.
    pub settings: MethodSettings,
    /// The start; the scene's if `None`.
    pub start: Option<Start>,
    /// The scene's own values of the parameters, whose branch the start is on; those of the model if `None`.
    pub scene_parameters: Option<Vec<f64>>,
    /// Length of the steps, or the time between rows of a method that chooses its steps; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<End<'a>>,
    /// Whether a long run stays in one thread, though a companion run estimates its error.
    pub is_single_threaded: bool,
    /// Whether a companion run estimates the error.
    pub estimate_error: bool,
}

/// The end of a run.
pub enum End<'a> {
    /// At a time.
    Time(f64),
    /// When a function rises through zero.
    Condition(&'a StopFunction<'a>),
}

/// A function of time, coordinates and rates.
pub type StopFunction<'a> = dyn Fn(f64, &[f64], &[f64]) -> f64 + 'a;

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
    let start = request.start.clone().unwrap_or_else(|| Start::of(mechanism));
    let branch = Branch::with_parameters(mechanism, request.scene_parameters.clone());
    let first = first_state(mechanism, &branch, start)?;
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
            Companion::new(mechanism, &settings, &first, end_time, observer.wants_outputs())
        } else {
            None
        },
        redundancy: Redundancy::at(mechanism, &first),
        monitor: RunMonitor::new(mechanism, &first, [observer.wants_outputs(), observer.wants_extremes()]),
        buffer: Vec::new(),
        first: Vec::new(),
        tail: Vec::new(),
        nearest: (0.0, f64::NEG_INFINITY),
    };
    let condition = run.condition(&first);
    check_condition(condition)?;
    let is_sampled = condition.is_some() || observer.wants_extremes();
    run.integrator.keep_inner_rows(if is_sampled { InnerRows::Samples } else { InnerRows::StepEnds });
    run.nearest.1 = condition.unwrap_or(0.0);
    let is_parallel = request.estimate_error && !request.is_single_threaded;
    Ok(with_threads(is_parallel, |scope| run.run(scope, &first, observer)))
}

/// An error for a step so short that time would stand still.
pub(crate) fn check_step(step: f64, end_time: f64) -> Result<(), StartError> {
    if step > end_time * f64::EPSILON { Ok(()) } else { Err(StartError::StepTooShort { step, end_time }) }
}

/// An error for a stop condition that is true or undefined at the start.
pub(crate) fn check_condition(value: Option<f64>) -> Result<(), StartError> {
    match value {
        Some(value) if !value.is_finite() => Err(StartError::ConditionNotFinite),
        Some(value) if value >= 0.0 => Err(StartError::ConditionHolds),
        _ => Ok(()),
    }
}

/// The consistent state at the start of a mechanism's motion.
///
/// # Errors
/// The constraints cannot be met, or the accelerations are not determined.
pub(crate) fn first_state(mechanism: &dyn Mechanism, branch: &Branch, start: Start) -> Result<State, StartError> {
    let mut first = first_position(mechanism, branch, start)?;
    Solver::at(mechanism, first.t, &first.q).complete(mechanism, &mut first).map_err(StartError::Step)?;
    Ok(first)
}

/// The first state without accelerations and multipliers.
pub(crate) fn first_position(mechanism: &dyn Mechanism, branch: &Branch, start: Start) -> Result<State, StartError> {
    let (q, qd) = branch.assemble(mechanism, start).map_err(StartError::NotAssembled)?;
    let description = mechanism.description();
    let count = description.constraints.len();
    if !description.friction.is_empty() && constraint_rank(mechanism, 0.0, &q) < count {
        return Err(StartError::Step(StepError::FrictionNotUnique));
    }
    let mut first = State::zero(q.len(), count);
    (first.q, first.qd) = (q, qd);
    Ok(first)
}

/// The last of some rows whose time is not after `t`; the times increase.
fn last_until(rows: &[f64], width: usize, t: f64) -> Option<&[f64]> {
    let (mut begin, mut end) = (0, rows.len() / width);
    while begin < end {
        let middle = (begin + end) / 2;
        if rows[middle * width] <= t {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    let place = begin.checked_sub(1)? * width;
    Some(&rows[place..place + width])
}

struct Run<'a> {
    mechanism: &'a dyn Mechanism,
    request: &'a Request<'a>,
    layout: RowLayout,
    rows: RowRequest,
    integrator: Integrator,
    /// Makes some of the kernel's steps again.
    sampler: Option<Sampler>,
    companion: Option<Companion>,
    redundancy: Option<Redundancy>,
    monitor: RunMonitor,
    /// The last row that was taken, and those after it.
    buffer: Vec<f64>,
    /// The first row.
    first: Vec<f64>,
    /// The rows before those of the buffer between which extremes may still be found.
    tail: Vec<f64>,
    /// The time at which the stop condition was nearest to true, and its value there.
    nearest: (f64, f64),
}

/// A state that the condition is evaluated at.
#[derive(Clone, Copy)]
enum Sample {
    /// A row of the buffer.
    Row(usize),
    /// A state between rows.
    Inner(usize),
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
        // A method that chooses its steps must not go beyond a condition that it does not know.
        let knows_condition = self.request.end.as_ref().is_none_or(|end| matches!(end, End::Time(_)));
        let chunk = if knows_condition || self.integrator.is_fixed() { CHUNK } else { 1 };
        self.buffer.resize((chunk + 1) * width, 0.0);
        first.write(&mut self.buffer);
        self.buffer[self.layout.event()] = self.nearest.1;
        self.first = self.buffer[..width].to_vec();
        self.tail.reserve(2 * TAIL * width);
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
            let rows = &self.buffer[begin * width..(made + 1) * width];
            follower.follow(&self.integrator, (rows, steps + begin as u64));
            let before = self.monitor.rows;
            let taken = self.monitor.take(self.mechanism, rows, self.integrator.inner_rows(), observer);
            steps += made as u64;
            // A run that cannot go on ends with its last row, however much further the computation had come.
            let kept = if taken.is_err() { (self.monitor.rows - before) as usize } else { made + 1 - begin };
            if let Some(last) = kept.checked_sub(1) {
                end.read(&rows[last * width..]);
            }
            if taken.is_err() {
                steps = self.monitor.rows.saturating_sub(1);
            }
            self.refine_extremes(made);
            let goes_on = taken.and_then(|()| observer.goes_on(end.t, self.rows.end_time).map_err(Status::Unwritable));
            match goes_on {
                Err(ending) => status = Some(ending),
                Ok(false) if status.is_none() => status = Some(Status::Interrupted),
                Ok(_) => {}
            }
            if let Some(status) = status {
                if let Some(extremes) = self.monitor.extremes() {
                    extremes.finish();
                    self.refine_extremes(made);
                }
                if let Some(extremes) = self.monitor.extremes() {
                    observer.extremes(extremes.found());
                }
                let is_kept = !matches!(status, Status::Unwritable(_));
                let last = if is_kept { &self.monitor.columns[..] } else { &[] };
                let status = observer.finish(last).map_or_else(Status::Unwritable, |()| status);
                self.companion = follower.finish();
                return self.outcome(status, end, steps, integration);
            }
            if self.monitor.extremes().is_some() {
                self.keep_tail(made);
            }
            self.buffer.copy_within(made * width..(made + 1) * width, 0);
            begin = 1;
        }
    }

    /// Fills the buffer with rows after its first one; their number, and the end of the run, if it comes.
    fn block(&mut self, steps: u64) -> (usize, Option<Status>) {
        let width = self.layout.width();
        self.rows.first = steps;
        let block = self.integrator.fill(self.mechanism, &self.rows, &mut self.buffer);
        let mut made = block.made;
        let mut reason = block.reason;
        if let Some(End::Condition(condition)) = self.request.end {
            let RowLayout { n, .. } = self.layout;
            for (number, row) in self.buffer.chunks_exact_mut(width).enumerate().take(made + 1).skip(1) {
                let value = condition(row[0], &row[1..=n], &row[1 + n..=2 * n]);
                row[self.layout.event()] = value;
                if !(value < 0.0) {
                    (made, reason) = (number, BlockEnd::Event);
                    break;
                }
            }
        }
        let has_condition = !matches!(self.request.end, Some(End::Time(_))) && self.has_condition();
        if has_condition && let Some(row) = self.first_crossing(made) {
            (made, reason) = (row, BlockEnd::Event);
        }
        let last = self.buffer[made * width + self.layout.event()];
        let is_crossed = reason == BlockEnd::Event;
        if has_condition {
            for row in self.buffer.chunks_exact(width).take(made + usize::from(!is_crossed)).skip(1) {
                if row[self.layout.event()] > self.nearest.1 {
                    self.nearest = (row[0], row[self.layout.event()]);
                }
            }
        }
        match reason {
            BlockEnd::Full => (made, None),
            BlockEnd::Failed(reason) => (made, Some(Status::Failed(reason))),
            BlockEnd::Event if last.is_nan() => {
                let t = self.buffer[made * width];
                (made - 1, Some(Status::NotFinite { t, what: Undefined::Condition }))
            }
            BlockEnd::Event => match self.locate(made) {
                Ok(found) => {
                    found.write(&mut self.buffer[made * width..]);
                    (made, Some(Status::Stopped))
                }
                Err(reason) => (made - 1, Some(Status::Failed(reason))),
            },
            BlockEnd::End if has_condition => {
                let (nearest_time, nearest) = self.nearest;
                (made, Some(Status::StopNotReached { nearest_time, missing: -nearest }))
            }
            BlockEnd::End => (made, Some(Status::Completed)),
        }
    }

    /// Looks for each extreme between rows in the motion itself, by steps from the rows.
    fn refine_extremes(&mut self, made: usize) {
        let Some(extremes) = self.monitor.extremes() else { return };
        // Pages draw extremes, and are to be small.
        if cfg!(target_arch = "wasm32") {
            extremes.note_estimates();
            return;
        }
        let vertices = extremes.take_vertices();
        if vertices.is_empty() {
            return;
        }
        let width = self.layout.width();
        // The steps of the run know nothing of these.
        let mut integrator = self.integrator.clone();
        for vertex in vertices {
            let Vertex { column, end, estimate, bracket, .. } = vertex;
            if !self.monitor.extremes().is_some_and(|extremes| extremes.may_be_extreme(&vertex)) {
                continue;
            }
            let t = estimate.1;
            let sign = if end == 0 { -1.0 } else { 1.0 };
            let mut value = |t: f64| {
                let rows = [&self.buffer[..(made + 1) * width], &self.tail, &self.first];
                let from = rows.into_iter().find_map(|rows| last_until(rows, width, t))?;
                let at = integrator.between(self.mechanism, &State::from_row(self.layout, from), t).ok()?;
                Some(sign * number(self.mechanism, &at, column)).filter(|value| value.is_finite())
            };
            // An extreme at an end is one, unless the column rises from there.
            let other = bracket[0] + bracket[1] - t;
            if bracket.contains(&t) && !(value(t + BESIDE * (other - t)) > value(t)) {
                continue;
            }
            let found = peak_between(bracket, t, value).map_or(estimate, |(t, value)| (sign * value, t));
            if let Some(extremes) = self.monitor.extremes() {
                extremes.note(&vertex, found);
            }
        }
    }

    /// Keeps the last rows of the buffer, but for the one that stays in it.
    fn keep_tail(&mut self, made: usize) {
        let width = self.layout.width();
        self.tail.extend_from_slice(&self.buffer[made.saturating_sub(TAIL) * width..made * width]);
        let excess = self.tail.len().saturating_sub(TAIL * width);
        self.tail.drain(..excess);
    }

    /// The first row of the buffer before which the condition was true inside the step, though it is true in no row
    /// before; the row becomes the state where it was found true.
    fn first_crossing(&mut self, made: usize) -> Option<usize> {
        let (width, event) = (self.layout.width(), self.layout.event());
        let (mut row, mut inner) = (1, 0);
        // The last sample, a row of the buffer or a state between rows, with the condition's value there.
        let (mut last, mut before) = (Sample::Row(0), self.buffer[event]);
        let mut last_change = 0.0;
        while row <= made && before < 0.0 {
            let is_inner = self.integrator.inner_row(inner).is_some_and(|at| at[0] < self.buffer[row * width]);
            let sample = if is_inner { Sample::Inner(inner) } else { Sample::Row(row) };
            let value = match sample {
                Sample::Row(row) => self.buffer[row * width + event],
                Sample::Inner(_) => self.condition(&self.state(&sample)).unwrap_or(-1.0),
            };
            let change = (value - before).abs();
            let found = if value >= 0.0 {
                // A row where the condition is true is found without help.
                is_inner.then(|| self.state(&sample))
            } else if -before.max(value) <= NEAR * change.max(last_change) {
                self.touched(&self.state(&last), &self.state(&sample))
            } else {
                None
            };
            if let Some(found) = found {
                found.write(&mut self.buffer[row * width..]);
                self.buffer[row * width + event] = 0.0;
                return Some(row);
            }
            (last, before, last_change) = (sample, value, change);
            if is_inner { inner += 1 } else { row += 1 }
        }
        None
    }

    /// The state at which the condition is true between two states at which it is not.
    fn touched(&mut self, from: &State, to: &State) -> Option<State> {
        let (mechanism, request) = (self.mechanism, self.request);
        let value = |at: &State| condition(mechanism, request, at);
        let found = touched(from, to, &mut { value }, &mut |t| self.integrator.between(mechanism, from, t))?;
        value(&found).is_some_and(|value| value >= 0.0).then_some(found)
    }

    fn state(&self, sample: &Sample) -> State {
        let numbers = match *sample {
            Sample::Row(row) => &self.buffer[row * self.layout.width()..],
            Sample::Inner(inner) => self.integrator.inner_row(inner).unwrap_or_default(),
        };
        State::from_row(self.layout, numbers)
    }

    /// The state in the step to row `made` of the buffer at which the condition becomes true.
    fn locate(&mut self, made: usize) -> Result<State, StepError> {
        let width = self.layout.width();
        let from = State::from_row(self.layout, &self.buffer[(made - 1) * width..]);
        let beyond = State::from_row(self.layout, &self.buffer[made * width..]);
        let (mechanism, request) = (self.mechanism, self.request);
        let value = |at: &State| condition(mechanism, request, at).unwrap_or(0.0);
        locate(&from, &beyond, &mut { value }, &mut |t| self.integrator.between(mechanism, &from, t))
    }

    fn has_condition(&self) -> bool {
        self.request.end.is_some() || !self.mechanism.description().until.is_empty()
    }

    /// The distance of the stop condition from true (negative), if there is one.
    fn condition(&self, at: &State) -> Option<f64> {
        condition(self.mechanism, self.request, at)
    }

    fn outcome(&mut self, status: Status, end: State, steps: u64, integration: Duration) -> Outcome {
        let counts = self.integrator.counts(steps);
        let monitor = &self.monitor;
        // A load may be zero in every row, and work between them.
        let is_conservative = monitor.is_conservative && self.integrator.is_conservative();
        Outcome {
            tolerance: self.request.settings.tolerance(),
            errors: self.companion.as_ref().and_then(|companion| companion.errors(counts.accepted)),
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
            nearest_singular: monitor.singularity.nearest(),
            redundancy: self.redundancy.take(),
            energy_imbalance: monitor.imbalance(
                self.integrator.imbalance(),
                monitor.balance.finished().excess,
                is_conservative,
            ),
            energy_drift: is_conservative.then_some(monitor.energy_drift),
            stats: *self.integrator.stats(),
        }
    }
}

fn condition(mechanism: &dyn Mechanism, request: &Request, at: &State) -> Option<f64> {
    match request.end {
        Some(End::Time(_)) => None,
        Some(End::Condition(condition)) => Some(condition(at.t, &at.q, &at.qd)),
        None => mechanism.event(at.t, &at.q, &at.qd),
    }
}
