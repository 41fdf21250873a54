//! Steps whose length is chosen by a tolerance, each followed by a projection, with rows at any time.

use std::collections::VecDeque;

use qrm_core::Mechanism;

use super::corners::{Corner, Corners};
use super::dense_output::DenseOutput;
use super::method::{MethodSettings, StepError};
use super::step_bounds::StepBounds;
use super::transitions::Transitions;
use crate::quadrature::GAUSS_3;
use crate::solve::{Projection, ProjectionTolerance, Solver};
use crate::state::State;

/// The formula of a step.
pub(super) trait StepFormula: std::fmt::Debug + Send {
    /// Order of the step.
    fn order(&self) -> i32;

    /// The exponent of the error before the last one in the PI control of the step length.
    fn beta(&self) -> f64;

    /// Makes a step of length `h` from a state, projects its end, and returns its error: 1 is just accepted, and the
    /// end is of no use beyond.
    ///
    /// # Errors
    /// The step could not be made.
    fn attempt(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        h: f64,
        task: &Task,
        work: &mut Work,
        to: &mut State,
    ) -> Result<f64, StepError>;

    /// Takes note of an accepted step.
    fn accepted(&mut self, mechanism: &dyn Mechanism, from: &State, to: &State) -> Accepted;

    /// Computes the higher coefficients of the dense output of the last step, where a polynomial of degree 5 does not
    /// suffice.
    ///
    /// # Errors
    /// They could not be computed.
    fn complete_dense_output(
        &mut self,
        _mechanism: &dyn Mechanism,
        _step: &mut DenseOutput,
        _task: &Task,
        _work: &mut Work,
    ) -> Result<(), StepError> {
        Ok(())
    }

    /// Makes the projected state at the time of `to` inside the last step.
    ///
    /// # Errors
    /// It could not be computed.
    fn state_inside(
        &mut self,
        mechanism: &dyn Mechanism,
        step: &mut DenseOutput,
        task: &Task,
        work: &mut Work,
        to: &mut State,
    ) -> Result<(), StepError> {
        self.complete_dense_output(mechanism, step, task, work)?;
        step.at(to.t, &mut to.q, &mut to.qd);
        *work.evaluations += 1;
        work.solver.projected(mechanism, task.projection, to)
    }

    /// The work of the loads without potential in the last step; there is `room` for a state.
    ///
    /// # Errors
    /// A state inside it could not be computed.
    fn load_work(
        &mut self,
        mechanism: &dyn Mechanism,
        step: &mut DenseOutput,
        task: &Task,
        work: &mut Work,
        room: &mut State,
    ) -> Result<f64, StepError> {
        self.complete_dense_output(mechanism, step, task, work)?;
        let mut power = |t: f64| -> Result<f64, StepError> {
            let State { q, qd, qdd, multipliers, .. } = &mut *room;
            step.at(t, q, qd);
            // They matter where constraints do work, and to friction that depends on forces in joints.
            qdd.fill(0.0);
            multipliers.fill(0.0);
            if mechanism.is_driven() || !mechanism.description().friction.is_empty() {
                let stats = work.solver.stats;
                work.solver.accelerations(mechanism, t, (q, qd), (qdd, multipliers))?;
                work.solver.stats = stats;
            }
            Ok(mechanism.power(t, q, qd, qdd, multipliers))
        };
        let (from, length) = (step.from.t, step.to.t - step.from.t);
        let mut panels = 1_u32;
        loop {
            let half = 0.5 * length / f64::from(panels);
            let (mut sum, mut size, mut coarse) = (0.0, 0.0, 0.0);
            for panel in 0..panels {
                let middle = from + half * f64::from(2 * panel + 1);
                let mut powers = [0.0; 3];
                for (found, (place, weight)) in powers.iter_mut().zip(GAUSS_3) {
                    *found = power(middle + half * place)?;
                    sum += half * weight * *found;
                    size += (half * weight * *found).abs();
                }
                coarse += half * (powers[0] + powers[2]);
            }
            // The mean of the outer places differs from that of all where the power bends.
            if (sum - coarse).abs() <= BEND * size || panels == MOST_PANELS {
                return Ok(sum);
            }
            panels *= 4;
        }
    }

    /// A copy.
    fn boxed_clone(&self) -> Box<dyn StepFormula>;
}

impl Clone for Box<dyn StepFormula> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// The settings of every step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    /// Largest error of a step, in the unit of each coordinate and rate.
    pub(super) tolerance: f64,
    /// Steps that reach this time end there exactly.
    pub(super) end_time: f64,
    /// Steps that end after this time have their dense output computed at once.
    pub(super) dense_from: f64,
    /// The projection after each step.
    pub(super) projection: (Projection, ProjectionTolerance),
    /// Bounds of the steps.
    pub(super) bounds: StepBounds,
}

impl Task {
    /// Steps up to a time.
    pub(super) fn new(settings: &MethodSettings, end_time: f64) -> Self {
        Self {
            tolerance: settings.tolerance,
            end_time,
            dense_from: end_time,
            projection: (settings.projection, settings.projection_tolerance),
            bounds: settings.step_bounds,
        }
    }

    /// The end of a step that begins at `t`.
    pub(super) fn end_of_step(&self, t: f64, h: f64) -> f64 {
        if t + h >= self.end_time { self.end_time } else { t + h }
    }
}

/// Solver and counter of a step.
pub(super) struct Work<'a> {
    /// Evaluations of the accelerations.
    pub(super) evaluations: &'a mut u64,
    pub(super) solver: &'a mut Solver,
}

/// The kind of an accepted step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Accepted {
    /// Whether it was made by an implicit method.
    pub(super) is_implicit: bool,
    /// Whether stability bound its length.
    pub(super) is_stability_bound: bool,
    /// Whether it was made by `auto` in place of the chosen method.
    pub(super) is_fallback: bool,
}

/// Keeps a state between rows.
pub(super) type KeepState<'a> = dyn FnMut(&State) + 'a;

/// The states between rows that are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InnerRows {
    /// The states at the ends of steps.
    StepEnds,
    /// The states at the ends of steps, and some inside steps that are long against the time between rows.
    Samples,
}

/// A motion under way with steps of its own choice.
#[derive(Clone, Debug)]
pub struct Adaptive {
    formula: Box<dyn StepFormula>,
    task: Task,
    /// The corners of the equations of motion; `None` if there are none.
    corners: Option<Corners>,
    /// More attempts than this are too many.
    most_attempts: u64,
    /// The corner that the last step ended at.
    corner: Option<Corner>,
    /// Smooth transitions of forces; `None` if there are none.
    transitions: Option<Box<Transitions>>,
    /// The last step.
    dense_output: DenseOutput,
    /// The end of the step under way.
    next: State,
    /// Length of the next step.
    h: f64,
    last_error: f64,
    /// Whether the last attempt was rejected.
    was_rejected: bool,
    counts: Counts,
    /// Rows that were asked for.
    rows: u64,
    /// The time of the last of them.
    asked: f64,
    /// Energy at the start, and work of the loads without potential since.
    energy: f64,
    work: f64,
    imbalance: f64,
    /// Whether such a load had power in any step.
    has_power: bool,
    /// Begin and end of the accepted steps since they were last forgotten, and their kinds.
    steps: Vec<[f64; 2]>,
    kinds: Vec<Accepted>,
    /// Steps of another run that those of this one stay below, the first of them under way.
    run_steps: VecDeque<[f64; 2]>,
}

/// The numbers of steps and evaluations of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Accepted steps.
    pub accepted: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the accelerations.
    pub evaluations: u64,
    /// Steps by an implicit method.
    pub implicit: u64,
    /// Explicit steps whose length stability bound, though accuracy would have allowed more.
    pub stability_bound: u64,
    /// Steps by `auto`, where the chosen method does not suit.
    pub fallback: u64,
}

/// The work inside a step is integrated over more panels where its power bends by more than this part of it, up to so
/// many.
const BEND: f64 = 0.1;
const MOST_PANELS: u32 = 64;
/// Most guesses of the first step, each shorter than the last one by this factor.
const FIRST_GUESSES: usize = 6;
const SHORTER_GUESS: f64 = 0.01;
/// The step is aimed at this part of the tolerance.
const SAFETY: f64 = 0.8;
/// More steps than this, and than so many for each row, mean that the motion cannot be followed.
const MAX_STEPS: u64 = 1_000_000;
const MAX_STEPS_PER_ROW: u64 = 1000;
/// A state between rows may take as many steps as the run did, and so many more.
const FEW: u64 = 100;
/// Progress is checked after so many steps; less than this part of the way to the next row is no progress.
const CHECKED: u64 = 5000;
const MIN_PROGRESS: f64 = 1e-3;
/// The factors by which a step may shrink and grow at once.
const SHRINK: f64 = 0.2;
const GROW: f64 = 6.0;
/// States between rows are this part of a step apart, if rows are not nearer.
const SAMPLES: f64 = 8.0;
/// They are no nearer than this part of the step that the scene states: near singular positions steps are tiny.
const SAMPLES_PER_SCENE_STEP: f64 = 64.0;
/// Corners nearer to the ends of a step than this part of it do not end it; one just behind the beginning is crossed.
const SHORTEST_TO_CORNER: f64 = 1e-6;
/// Steps as short as this against the time may be rejected for a jump that lies as near as that behind their beginning.
const SHORT: f64 = 1e-8;
const NEAR_CORNER: f64 = 1e-12;
/// The part of a step of another run that steps beside it are at most: errors of order 4 fall to an eleventh.
pub(crate) const COMPANION_STEP_RATIO: f64 = 0.55;

impl Adaptive {
    /// Begins at a state; the first step is guessed from the derivatives there.
    ///
    /// # Errors
    /// The accelerations near the start are not determined.
    pub(super) fn new(
        mechanism: &dyn Mechanism,
        formula: Box<dyn StepFormula>,
        task: Task,
        first: &State,
        solver: &mut Solver,
    ) -> Result<Self, StepError> {
        let mut adaptive = Self {
            formula,
            task,
            corners: Corners::of(mechanism),
            most_attempts: u64::MAX,
            corner: None,
            transitions: Transitions::of(mechanism),
            dense_output: DenseOutput::new(first.clone(), first.clone()),
            next: first.clone(),
            h: 0.0,
            last_error: 1e-4,
            was_rejected: false,
            counts: Counts::default(),
            rows: 0,
            asked: first.t,
            energy: mechanism.energy(&first.q, &first.qd).iter().sum(),
            work: 0.0,
            imbalance: 0.0,
            has_power: false,
            steps: Vec::new(),
            kinds: Vec::new(),
            run_steps: VecDeque::new(),
        };
        adaptive.h = adaptive.first_step(mechanism, first, solver)?;
        Ok(adaptive)
    }

    /// A copy that can go back to a state in the last step, or before it.
    #[must_use]
    pub(super) fn restarted(&self, from: &State) -> Self {
        let mut again = self.clone();
        again.asked = from.t;
        if from.t < self.dense_output.from.t {
            again.dense_output = DenseOutput::new(from.clone(), from.clone());
            again.most_attempts = 2 * self.attempts() + FEW;
            again.corner = None;
            if let Some(corners) = &mut again.corners {
                corners.forget();
            }
        }
        again
    }

    /// The numbers of steps and evaluations so far.
    pub(super) fn counts(&self) -> Counts {
        self.counts
    }

    /// Begin and end of the accepted steps since they were last forgotten.
    pub(super) fn steps(&self) -> &[[f64; 2]] {
        &self.steps
    }

    /// The kinds of these steps.
    pub(super) fn kinds(&self) -> &[Accepted] {
        &self.kinds
    }

    /// Forgets the steps so far.
    pub(super) fn forget_steps(&mut self) {
        self.steps.clear();
        self.kinds.clear();
    }

    /// Keeps steps from now on below those of another run at the same time, of which more are known.
    pub(super) fn limit_steps_by(&mut self, steps: &[[f64; 2]]) {
        self.run_steps.extend(steps);
    }

    /// The longest step from a time on.
    fn longest(&mut self, t: f64) -> f64 {
        while self.run_steps.len() > 1 && self.run_steps[0][1] <= t {
            self.run_steps.pop_front();
        }
        // A step that begins in a long step of the run may end in shorter ones behind it.
        let mut longest = self.task.bounds.longest;
        for [begin, end] in &self.run_steps {
            if *begin >= t + longest {
                break;
            }
            longest = longest.min((begin - t).max(COMPANION_STEP_RATIO * (end - begin)));
        }
        longest
    }

    /// The largest difference between the change of the energy and the work of the loads without potential, at the end
    /// of any step.
    pub(super) fn imbalance(&self) -> f64 {
        self.imbalance
    }

    /// Whether no load without potential did work so far.
    pub(super) fn is_conservative(&self) -> bool {
        !self.has_power
    }

    /// Moves to the projected state at a time not before the last one that was asked for; `inner` is given states on
    /// the way.
    ///
    /// # Errors
    /// The motion does not get there.
    pub(super) fn advance_to(
        &mut self,
        mechanism: &dyn Mechanism,
        t: f64,
        solver: &mut Solver,
        to: &mut State,
        mut inner: Option<(InnerRows, &mut KeepState)>,
    ) -> Result<(), StepError> {
        self.rows += 1;
        let (mut checked, mut then) = (self.attempts(), self.dense_output.to.t);
        let begin = std::mem::replace(&mut self.asked, t);
        let is_sampled = matches!(inner, Some((InnerRows::Samples, _)));
        self.task.dense_from = if is_sampled || self.has_power { f64::NEG_INFINITY } else { t };
        loop {
            if let Some((which, inner)) = &mut inner {
                if *which == InnerRows::Samples {
                    self.sample(mechanism, [begin, t], solver, *inner)?;
                }
                let end = &self.dense_output.to;
                if begin < end.t && end.t < t {
                    inner(end);
                }
            }
            if self.dense_output.to.t >= t {
                break;
            }
            let (attempts, now) = (self.attempts(), self.dense_output.to.t);
            if attempts > self.most_attempts {
                return Err(StepError::TooManySteps { attempts, h: self.h });
            }
            if attempts > checked + CHECKED {
                let is_stuck = now - then < MIN_PROGRESS * (t - then);
                if is_stuck || attempts > MAX_STEPS + MAX_STEPS_PER_ROW * self.rows {
                    return Err(StepError::TooManySteps { attempts, h: self.h.min(self.task.bounds.longest) });
                }
                (checked, then) = (attempts, now);
            }
            self.step(mechanism, solver)?;
        }
        if self.dense_output.to.t == t {
            to.clone_from(&self.dense_output.to);
            return Ok(());
        }
        let mut work = Work { evaluations: &mut self.counts.evaluations, solver };
        to.t = t;
        self.formula.state_inside(mechanism, &mut self.dense_output, &self.task, &mut work, to)
    }

    /// States inside the last step, between two times.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    fn sample(
        &mut self,
        mechanism: &dyn Mechanism,
        [begin, end]: [f64; 2],
        solver: &mut Solver,
        inner: &mut dyn FnMut(&State),
    ) -> Result<(), StepError> {
        let [from, to] = [self.dense_output.from.t, self.dense_output.to.t];
        let [first, last] = [from.max(begin), to.min(end)];
        let spacing = ((to - from) / SAMPLES).max(mechanism.schedule().step / SAMPLES_PER_SCENE_STEP);
        if last - first > spacing {
            // These are for whoever observes the motion, and not counted as those of the method.
            let mut work = Work { evaluations: &mut 0, solver };
            let parts = ((last - first) / spacing).ceil();
            let mut state = self.dense_output.to.clone();
            for i in 1..parts as u32 {
                state.t = first + (last - first) * f64::from(i) / parts;
                self.formula.state_inside(mechanism, &mut self.dense_output, &self.task, &mut work, &mut state)?;
                inner(&state);
            }
        }
        Ok(())
    }

    /// The number of steps that were tried.
    fn attempts(&self) -> u64 {
        self.counts.accepted + self.counts.rejected
    }

    /// Makes one accepted step, which ends where the equations of motion have a corner.
    fn step(&mut self, mechanism: &dyn Mechanism, solver: &mut Solver) -> Result<(), StepError> {
        self.step_from_corner(mechanism, solver, true)
    }

    /// Makes one accepted step; `crosses` a corner just behind its beginning first.
    fn step_from_corner(
        &mut self,
        mechanism: &dyn Mechanism,
        solver: &mut Solver,
        crosses: bool,
    ) -> Result<(), StepError> {
        self.cross_corner(mechanism, solver)?;
        let t = self.dense_output.to.t;
        // The corner that the step ends at.
        let mut corner = self.corners.as_ref().and_then(|corners| corners.next_time(t));
        let end = corner.map_or(f64::INFINITY, Corner::before);
        let end_time = self.task.end_time.min(self.task.bounds.next_end(t)).min(end);
        let mut task = Task { end_time, ..self.task };
        let longest = self.longest(t);
        let asked = self.h.min(longest);
        loop {
            let left = task.end_time - t;
            self.h = self.h.min(longest);
            // Two even steps to the end are better than a long and a very short one.
            let h = if self.h >= left {
                left
            } else if self.h > 0.5 * left {
                0.5 * left
            } else {
                self.h
            };
            if !(h > 4.0 * f64::EPSILON * t.abs()) {
                return Err(StepError::StepTooShort { h });
            }
            let mut work = Work { evaluations: &mut self.counts.evaluations, solver };
            let from = &self.dense_output.to;
            let error = match self.formula.attempt(mechanism, from, h, &task, &mut work, &mut self.next) {
                Ok(error) if error <= 1.0 => error,
                Ok(error) => {
                    let factor = if error.is_finite() {
                        SAFETY * error.powf(-1.0 / f64::from(self.formula.order()))
                    } else {
                        SHRINK
                    };
                    self.reject(h * factor.clamp(SHRINK, 0.9));
                    if crosses && self.meets_jump_at_once(h) {
                        return self.step_from_corner(mechanism, solver, false);
                    }
                    continue;
                }
                // A formula may leave its domain, or a projection its branch, where the step is too long.
                Err(reason) if h < 1e-10 * (1.0 + t.abs()) => return Err(reason),
                Err(_) => {
                    self.reject(h * SHRINK);
                    continue;
                }
            };
            let change = self.transition();
            if change > 1.0 {
                self.reject(h * (SAFETY / change).max(SHRINK));
                continue;
            }
            let shortest = (SHORTEST_TO_CORNER * h).max(Corner::resolution(t));
            if let Some(met) = self.corner_inside(mechanism, &task, solver, if crosses { 0.0 } else { shortest })? {
                if met.0 - t <= shortest {
                    self.corner = Some(met);
                    return self.step_from_corner(mechanism, solver, false);
                }
                task.end_time = met.before();
                corner = Some(met);
                continue;
            }
            self.accept(mechanism, t, h, error);
            self.corner = corner.filter(|corner| self.dense_output.to.t == corner.before());
            if self.corner.is_some() {
                // The step was short for the sake of the corner, and that says little of the next one.
                self.h = self.h.max(asked);
            }
            self.balance(mechanism, solver);
            return Ok(());
        }
    }

    /// Whether a rejected step of length `h` met a jump just behind its beginning, to be crossed there.
    fn meets_jump_at_once(&mut self, h: f64) -> bool {
        let from = self.dense_output.to.as_ref();
        let size = 1.0 + from.t.abs();
        if h >= SHORT * size {
            return false;
        }
        let met = self.corners.as_mut().and_then(|corners| corners.along_tangent(&from, h));
        let near = met.filter(|met| met.0 - from.t <= NEAR_CORNER * size);
        self.corner = near.or(self.corner);
        near.is_some()
    }

    /// How far the step that was just made passes through a transition; more than 1 is too far.
    fn transition(&mut self) -> f64 {
        let (from, to) = (self.dense_output.to.as_ref(), self.next.as_ref());
        self.transitions.as_mut().map_or(0.0, |transitions| transitions.change(&from, &to))
    }

    /// Takes over an accepted step of length `h` from `t` on, and chooses the length of the next one.
    fn accept(&mut self, mechanism: &dyn Mechanism, t: f64, h: f64, error: f64) {
        let (order, beta) = (f64::from(self.formula.order()), self.formula.beta());
        let error = error.max(1e-10);
        let factor = SAFETY * error.powf(0.75 * beta - 1.0 / order) * self.last_error.powf(beta);
        let most = if self.was_rejected { 1.0 } else { GROW };
        self.h = h * factor.clamp(SHRINK, most);
        self.last_error = error.max(1e-4);
        self.was_rejected = false;
        let accepted = self.formula.accepted(mechanism, &self.dense_output.to, &self.next);
        self.counts.accepted += 1;
        self.steps.push([t, self.next.t]);
        self.kinds.push(accepted);
        self.counts.implicit += u64::from(accepted.is_implicit);
        self.counts.stability_bound += u64::from(accepted.is_stability_bound);
        self.counts.fallback += u64::from(accepted.is_fallback);
        self.dense_output.go_on(&mut self.next);
    }

    /// Begins behind the corner that the last step ended at.
    fn cross_corner(&mut self, mechanism: &dyn Mechanism, solver: &mut Solver) -> Result<(), StepError> {
        let Some(corners) = &mut self.corners else { return Ok(()) };
        let now = &mut self.dense_output.to;
        let corner = self.corner.take().or_else(|| corners.at(now.t));
        if let Some(corner) = corner.filter(|corner| corner.behind() < self.task.end_time) {
            corners.forget();
            let power = mechanism.power(now.t, &now.q, &now.qd, &now.qdd, &now.multipliers);
            self.work += power * (corner.behind() - now.t);
            solver.cross(mechanism, self.task.projection, corner.behind(), now)?;
        }
        corners.leave(mechanism, (self.task.projection, solver), SHORTEST_TO_CORNER * self.h, now)
    }

    /// The first corner inside the step that was just made, further than `shortest` behind its beginning.
    fn corner_inside(
        &mut self,
        mechanism: &dyn Mechanism,
        task: &Task,
        solver: &mut Solver,
        shortest: f64,
    ) -> Result<Option<Corner>, StepError> {
        let Self { corners: Some(corners), dense_output, next, formula, .. } = self else { return Ok(None) };
        let from = &dense_output.to;
        if !corners.may_meet(&from.as_ref(), &next.as_ref()) {
            return Ok(None);
        }
        let h = next.t - from.t;
        // The step may be made again, and its states inside are not those of the method.
        let mut formula = formula.clone();
        formula.accepted(mechanism, from, next);
        let mut inside = DenseOutput::new(from.clone(), next.clone());
        let mut work = Work { evaluations: &mut 0, solver };
        let met = corners.first_inside([from, next], shortest, &mut |t| {
            let mut at = State { t, ..inside.to.clone() };
            formula.state_inside(mechanism, &mut inside, task, &mut work, &mut at)?;
            Ok(at)
        })?;
        let met = met.filter(|met| next.t - met.t > SHORTEST_TO_CORNER * h).map(|met| Corner(met.t));
        if met.is_some() {
            corners.forget();
        }
        Ok(met)
    }

    /// Compares the energy at the end of the last step with the work of its loads, whose power is integrated inside the
    /// step.
    fn balance(&mut self, mechanism: &dyn Mechanism, solver: &mut Solver) {
        let step = &mut self.dense_output;
        let power = |at: &State| mechanism.power(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers);
        if power(&step.from) != 0.0 || power(&step.to) != 0.0 {
            // This is for whoever observes the motion, and the end of the next step is not known yet: its room serves.
            let mut work = Work { evaluations: &mut 0, solver };
            let found = self.formula.load_work(mechanism, step, &self.task, &mut work, &mut self.next);
            // Where the power inside is not known, that at the ends is.
            let by_ends = 0.5 * (step.to.t - step.from.t) * (power(&step.from) + power(&step.to));
            self.work += found.ok().filter(|work| work.is_finite()).unwrap_or(by_ends);
            self.has_power = true;
        }
        let energy: f64 = mechanism.energy(&step.to.q, &step.to.qd).iter().sum();
        self.imbalance = self.imbalance.max((energy - self.energy - self.work).abs());
    }

    fn reject(&mut self, h: f64) {
        self.h = h;
        self.was_rejected = true;
        self.counts.rejected += 1;
    }

    /// A first step from the sizes of state, rates and their change (Hairer, Norsett, Wanner I, II.4).
    fn first_step(&mut self, mechanism: &dyn Mechanism, first: &State, solver: &mut Solver) -> Result<f64, StepError> {
        let n = first.q.len();
        let at_first = (&first.q[..], &first.qd[..]);
        let scales: Vec<[f64; 2]> =
            (0..n).map(|i| error_scales(mechanism, self.task.tolerance, i, first, at_first)).collect();
        let norm = |of_q: &[f64], of_qd: &[f64]| {
            let squares =
                scales.iter().zip(of_q.iter().zip(of_qd)).map(|([q, qd], (x, v))| (x / q).powi(2) + (v / qd).powi(2));
            (squares.sum::<f64>() / (2.0 * n as f64)).sqrt()
        };
        let (size, speed) = (norm(&first.q, &first.qd), norm(&first.qd, &first.qdd));
        let guess = if size < 1e-5 || speed < 1e-5 { 1e-6 } else { 0.01 * size / speed };
        let mut guess = guess.min(self.task.end_time - first.t);
        let mut later = first.clone();
        for left in (0..FIRST_GUESSES).rev() {
            let along = |x: &[f64], v: &[f64]| -> Vec<f64> { x.iter().zip(v).map(|(x, v)| x + guess * v).collect() };
            (later.t, later.q, later.qd) = (first.t + guess, along(&first.q, &first.qd), along(&first.qd, &first.qdd));
            self.counts.evaluations += 1;
            match solver.projected(mechanism, (Projection::None, ProjectionTolerance::default()), &mut later) {
                Ok(_) => break,
                Err(reason) if left == 0 => return Err(reason),
                // Forces may have no solution there.
                Err(_) => guess *= SHORTER_GUESS,
            }
        }
        let change = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| (a - b) / guess).collect() };
        let bend = norm(&change(&later.qd, &first.qd), &change(&later.qdd, &first.qdd));
        let largest = speed.max(bend);
        let second = if largest <= 1e-15 {
            (guess * 1e-3).max(1e-6)
        } else {
            (0.01 / largest).powf(1.0 / f64::from(self.formula.order()))
        };
        Ok((100.0 * guess).min(second).min(self.task.end_time))
    }
}

/// The largest error of a coordinate and of its rate that a step may make. An angle is no less accurate for many
/// revolutions.
pub(super) fn error_scales(
    mechanism: &dyn Mechanism,
    tolerance: f64,
    i: usize,
    from: &State,
    (q, qd): (&[f64], &[f64]),
) -> [f64; 2] {
    let size = if mechanism.description().is_angle(i) { 0.0 } else { from.q[i].abs().max(q[i].abs()) };
    [tolerance * (1.0 + size), tolerance * (1.0 + from.qd[i].abs().max(qd[i].abs()))]
}
