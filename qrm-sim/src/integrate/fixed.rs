//! Steps of fixed length, by the generated kernel where it is valid, between corners of the equations of motion.

use qrm_core::{Mechanism, RowLayout, RowRequest};

use super::adaptive::KeepState;
use super::classical::CLASSICAL;
use super::corner::Corner;
use super::corners::{Corners, JUMP_MARGIN, MOST_PARTS};
use super::explicit::Explicit;
use super::methods::MethodSettings;
use super::step_error::StepError;
use crate::solve::{Projection, ProjectionTolerance, Solver, largest};
use crate::state::State;

/// The distance, relative to the step, within which a jump is crossed.
const CROSSED: f64 = 1e-12;
/// The number of steps for the part of a step behind a corner. That part may end at the next corner, so its length need
/// not depend on the step length: a companion run uses fewer steps.
const STEPS_BEHIND_CORNERS: u32 = 3;
/// Accelerations jump if they change by more than `CONTINUOUS` within this fraction of the way to a corner.
const NEIGHBOUR_DISTANCE: f64 = 1e-6;
const CONTINUOUS: f64 = 1e-5;

/// The largest difference, relative to their change, between the velocities in the middle of a smooth step and those
/// extrapolated from its ends. A larger one means that the last stages saw the motion behind a corner.
const SMOOTH: f64 = 1e-6;

/// The classical Runge-Kutta method and its data between steps.
#[derive(Clone, Debug)]
pub(super) struct Fixed {
    formula: Explicit,
    /// The corners of the equations of motion; `None` if there are none.
    pub(super) corners: Option<Corners>,
    /// The number of steps for the part of a step behind a corner.
    pub(super) steps_behind_corners: u32,
    /// A buffer for the two rows of a step.
    rows: Vec<f64>,
    /// A buffer for the beginning of a part of a step.
    now: State,
}

/// The kind of corner at which a part of a step ends.
enum FoundCorner {
    /// A corner from which the motion continues.
    Corner,
    /// A jump, behind which no stage may lie.
    Jump,
    /// A corner that may lie earlier, since stages have seen the motion behind it: the part should end in its middle.
    Unclear(f64),
}

/// The mechanism, the settings and the solver of a step.
pub(super) struct StepContext<'a> {
    pub(super) mechanism: &'a dyn Mechanism,
    pub(super) settings: &'a MethodSettings,
    pub(super) solver: &'a mut Solver,
    /// Whether the kernel is tried first.
    pub(super) asks_kernel: bool,
}

impl StepContext<'_> {
    fn projection(&self) -> (Projection, ProjectionTolerance) {
        (self.settings.projection, self.settings.projection_tolerance)
    }
}

impl Fixed {
    pub(super) fn new(mechanism: &dyn Mechanism, first: &State) -> Self {
        let width = RowLayout { n: first.q.len(), m: first.multipliers.len() }.width();
        Self {
            formula: Explicit::new(&CLASSICAL, first.q.len()),
            corners: Corners::new(mechanism),
            steps_behind_corners: STEPS_BEHIND_CORNERS,
            rows: vec![0.0; 2 * width],
            now: first.clone(),
        }
    }

    /// Advances to a time by one step, or by several steps that end at corners of the equations of motion; `inner`
    /// receives the states between them.
    ///
    /// # Errors
    /// The motion cannot be continued to that time.
    pub(super) fn advance(
        &mut self,
        by: &mut StepContext,
        from: &State,
        t: f64,
        to: &mut State,
        inner: &mut KeepState,
    ) -> Result<(), StepError> {
        let Some(mut corners) = self.corners.take() else { return self.step(by, from, t, to) };
        let mut now = std::mem::replace(&mut self.now, State::zero(0, 0));
        now.clone_from(from);
        let result = self.advance_split_at_corners(by, &mut corners, &mut now, t, to, inner);
        (self.corners, self.now) = (Some(corners), now);
        result
    }

    fn advance_split_at_corners(
        &mut self,
        by: &mut StepContext,
        corners: &mut Corners,
        now: &mut State,
        t: f64,
        to: &mut State,
        inner: &mut KeepState,
    ) -> Result<(), StepError> {
        let begin = now.t;
        let whole = t - begin;
        let (mut last, mut limit) = (begin, t);
        for _ in 0..MOST_PARTS {
            if let Some(corner) = corners.at(now.t).filter(|corner| corner.just_after() < t) {
                by.solver.cross(by.mechanism, by.projection(), corner.just_after(), now)?;
            }
            corners.move_off_zero(by.mechanism, (by.projection(), by.solver), CROSSED * whole, now)?;
            let mut count = 1;
            if now.t > last {
                inner(now);
                (last, limit) = (now.t, t);
            }
            if now.t > begin {
                count = self.steps_behind_corners;
            }
            let end = corners.next_time(now.t).map_or(limit, |corner| corner.just_before().min(limit));
            self.steps(by, (now, count), end, to)?;
            if let Some(behind) = self.corner_inside(by, corners, (now, count), to)? {
                match self.found_corner(by, (now, count), &behind)? {
                    FoundCorner::Corner => *now = behind,
                    FoundCorner::Jump => self.step_to_jump(by, corners, behind.t, whole, (now, count))?,
                    FoundCorner::Unclear(middle) => limit = middle,
                }
                corners.forget();
                corners.forget_found();
            } else if corners.stages_may_pass_corner() {
                self.step_to_jump(by, corners, to.t, whole, (now, count))?;
                corners.forget();
            } else if end >= t || corners.at(end).is_some_and(|corner| corner.just_after() >= t) {
                to.t = t;
                return Ok(());
            } else {
                inner(to);
                std::mem::swap(now, to);
            }
            if now.t >= t {
                to.clone_from(now);
                return Ok(());
            }
        }
        self.step(by, now, t, to)
    }

    /// The state at, or just behind, the first corner in a step.
    fn corner_inside(
        &mut self,
        by: &mut StepContext,
        corners: &mut Corners,
        (from, count): (&State, u32),
        to: &State,
    ) -> Result<Option<State>, StepError> {
        if !corners.may_meet(&from.as_ref(), &to.as_ref()) {
            return Ok(None);
        }
        corners.first_inside([from, to], 0.0, &mut |t| {
            let mut inside = from.clone();
            self.steps(by, (from, count), t, &mut inside)?;
            Ok(inside)
        })
    }

    /// The kind of the corner at which a part of the step ends; `behind` is the state just behind it.
    fn found_corner(
        &mut self,
        by: &mut StepContext,
        (now, count): (&State, u32),
        behind: &State,
    ) -> Result<FoundCorner, StepError> {
        let way = behind.t - now.t;
        if !(NEIGHBOUR_DISTANCE * way > Corner::resolution(now.t)) {
            return Ok(FoundCorner::Jump);
        }
        let mut at = now.clone();
        self.steps(by, (now, count), behind.t - NEIGHBOUR_DISTANCE * way, &mut at)?;
        let size = largest(&behind.qdd).1.max(largest(&at.qdd).1);
        if !behind.qdd.iter().zip(&at.qdd).all(|(b, a)| (b - a).abs() <= CONTINUOUS * size) {
            return Ok(FoundCorner::Jump);
        }
        let middle = now.t + 0.5 * way;
        self.steps(by, (now, count), middle, &mut at)?;
        Ok(if stages_straddle_corner([now, &at, behind]) { FoundCorner::Unclear(middle) } else { FoundCorner::Corner })
    }

    /// Advances towards a jump, so far that no stage lies behind it; crosses the jump if it is near.
    fn step_to_jump(
        &mut self,
        by: &mut StepContext,
        corners: &mut Corners,
        t: f64,
        whole: f64,
        (now, count): (&mut State, u32),
    ) -> Result<(), StepError> {
        let from = now.clone();
        let mut left = t - from.t;
        while left > (CROSSED * whole).max(Corner::resolution(t)) {
            let length = (1.0 - JUMP_MARGIN) * left;
            self.steps(by, (&from, count), from.t + length, now)?;
            corners.forget();
            corners.may_meet(&from.as_ref(), &now.as_ref());
            match corners.part_before() {
                Some(part) => left = length * part,
                None => return Ok(()),
            }
        }
        now.clone_from(&from);
        by.solver.cross(by.mechanism, by.projection(), Corner(from.t + left).just_after() + left, now)
    }

    /// Advances to a time by a number of equal steps.
    ///
    /// # Errors
    /// A step could not be made.
    fn steps(
        &mut self,
        by: &mut StepContext,
        (from, count): (&State, u32),
        t: f64,
        to: &mut State,
    ) -> Result<(), StepError> {
        if count == 1 {
            return self.step(by, from, t, to);
        }
        let mut at = from.clone();
        for i in 1..=count {
            let end = if i == count { t } else { from.t + (t - from.t) * f64::from(i) / f64::from(count) };
            self.step(by, &at, end, to)?;
            at.clone_from(to);
        }
        Ok(())
    }

    /// Makes one step, by the generated kernel where it is valid.
    ///
    /// # Errors
    /// The step could not be made.
    fn step(&mut self, by: &mut StepContext, from: &State, t: f64, to: &mut State) -> Result<(), StepError> {
        if by.asks_kernel && self.step_by_kernel(by, from, t, to) {
            return Ok(());
        }
        self.formula.step(by.mechanism, by.solver, by.projection(), (from, t), to)
    }

    /// Makes a step by the kernel; returns false if it is unreliable.
    fn step_by_kernel(&mut self, by: &StepContext, from: &State, t: f64, to: &mut State) -> bool {
        let residual = by.settings.projection_tolerance.residual;
        let step = t - from.t;
        let request = RowRequest { origin: from.t, step, end_time: t, first: 0, residual, watches_event: false };
        from.write(&mut self.rows);
        let is_made = by.mechanism.integrate_rk4(&request, &mut self.rows).rows_written == 1;
        if is_made {
            to.read(&self.rows[self.rows.len() / 2..]);
        }
        is_made
    }
}

/// Whether the last stages of a step have seen the motion behind the corner at its end, so that the corner may lie
/// earlier: no smooth motion passes through the beginning, middle and end of the step.
fn stages_straddle_corner([begin, middle, end]: [&State; 3]) -> bool {
    let h = end.t - begin.t;
    (0..begin.qd.len()).any(|i| {
        let by_ends = 0.5 * (begin.qd[i] + end.qd[i]) + h / 8.0 * (begin.qdd[i] - end.qdd[i]);
        let change = (end.qd[i] - begin.qd[i]).abs().max(h * begin.qdd[i].abs().max(end.qdd[i].abs()));
        (middle.qd[i] - by_ends).abs() > SMOOTH * change.max(f64::EPSILON / SMOOTH * begin.qd[i].abs())
    })
}
