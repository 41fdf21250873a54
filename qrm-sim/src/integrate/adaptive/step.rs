//! A step whose length is chosen, up to the next corner of the equations of motion.

use qrm_core::Mechanism;

use super::super::corner::Corner;
use super::super::dense_output::DenseOutput;
use super::super::step_control::{shorter_for_change, shorter_for_error, shorter_for_failure};
use super::super::step_error::StepError;
use super::super::step_formula::{Evaluator, Task};
use super::Adaptive;
use crate::solve::Solver;
use crate::state::State;

/// The shortest step, relative to the time, that is shortened after a failure.
const SHORTEST: f64 = 1e-10;
/// The distance from the ends of a step, relative to its length, within which corners do not end it; a corner just
/// after the beginning is crossed.
const SHORTEST_TO_CORNER: f64 = 1e-6;
/// The longest step, relative to the time, that may be rejected because of a jump just after its beginning.
const SHORT: f64 = 1e-8;
/// The longest step, relative to the time, that may be that short because a kernel does not see a singular position.
const NEAR_SINGULAR: f64 = 1e-7;
/// The distance from the beginning of a step, relative to the time, within which a jump is just after it.
const NEAR_CORNER: f64 = 1e-12;

impl Adaptive {
    /// Makes one accepted step, which ends at the first corner of the equations of motion. `meets_corner_at_once` is
    /// true if there may be a corner just after its beginning, which is then crossed first.
    pub(super) fn step(
        &mut self,
        mechanism: &dyn Mechanism,
        solver: &mut Solver,
        meets_corner_at_once: bool,
    ) -> Result<(), StepError> {
        self.cross_corner(mechanism, solver)?;
        let t = self.dense_output.to.t;
        // The corner at which the step ends.
        let mut corner = self.corners.as_ref().and_then(|corners| corners.next_time(t));
        let end = corner.map_or(f64::INFINITY, Corner::just_before);
        let end_time = self.task.end_time.min(self.task.bounds.next_end(t)).min(end);
        let mut task = Task { end_time, ..self.task };
        let longest = self.companion_limit.longest(t, self.task.bounds.longest);
        self.control.h = self.control.h.min(longest);
        let wanted = self.control.h;
        loop {
            let left = task.end_time - t;
            // Two equal steps to the end are better than a long and a very short one.
            let h = match self.control.h {
                h if h >= left => left,
                h if h > 0.5 * left => 0.5 * left,
                h => h,
            };
            if !(h > 4.0 * f64::EPSILON * t.abs()) {
                return Err(StepError::StepTooShort { h });
            }
            let from = &self.dense_output.to;
            let avoids_kernels = solver.avoids_kernels || h < NEAR_SINGULAR * (1.0 + t.abs());
            let before = std::mem::replace(&mut solver.avoids_kernels, avoids_kernels);
            let mut evaluator = Evaluator { evaluations: &mut self.counts.evaluations, solver };
            let attempted = self.formula.attempt(mechanism, from, h, &task, &mut evaluator, &mut self.next);
            solver.avoids_kernels = before;
            let error = match attempted {
                Ok(error) if error <= 1.0 => error,
                Ok(error) => {
                    self.reject(shorter_for_error(h, error, self.formula.order()));
                    if meets_corner_at_once && self.jump_at_step_start(h) {
                        return self.step(mechanism, solver, false);
                    }
                    continue;
                }
                // A formula may leave its domain, or a projection its branch, where the step is too long.
                Err(reason) if h < SHORTEST * (1.0 + t.abs()) => return Err(reason),
                Err(_) => {
                    self.reject(shorter_for_failure(h));
                    continue;
                }
            };
            let change = self.transition();
            if change > 1.0 {
                self.reject(shorter_for_change(h, change));
                continue;
            }
            let shortest = (SHORTEST_TO_CORNER * h).max(Corner::resolution(t));
            let behind = if meets_corner_at_once { 0.0 } else { shortest };
            if let Some(met) = self.corner_inside(mechanism, &task, solver, behind)? {
                if met.0 - t <= shortest {
                    self.corner = Some(met);
                    return self.step(mechanism, solver, false);
                }
                task.end_time = met.just_before();
                corner = Some(met);
                continue;
            }
            self.accept(mechanism, t, h, error);
            self.corner = corner.filter(|corner| self.dense_output.to.t == corner.just_before());
            if self.corner.is_some() {
                // The step was shortened to end at the corner, which says little about the next one.
                self.control.h = self.control.h.max(wanted);
            }
            // The end of the next step is not known yet: its buffer can be used.
            let Self { formula, task, dense_output, next, balance, .. } = self;
            balance.add(mechanism, &mut **formula, (task, solver), dense_output, next);
            return Ok(());
        }
    }

    /// Repeats the attempted step with length `h`.
    fn reject(&mut self, h: f64) {
        self.counts.rejected += 1;
        self.control.reject(h);
    }

    /// Whether a rejected step of length `h` met a jump just after its beginning, which must be crossed there.
    fn jump_at_step_start(&mut self, h: f64) -> bool {
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

    /// The change of the last step relative to the largest allowed change in a transition; above 1 is too much.
    fn transition(&mut self) -> f64 {
        let (from, to) = (self.dense_output.to.as_ref(), self.next.as_ref());
        self.transitions.as_mut().map_or(0.0, |transitions| transitions.change(&from, &to))
    }

    /// Records an accepted step of length `h` from `t`, and chooses the length of the next one.
    fn accept(&mut self, mechanism: &dyn Mechanism, t: f64, h: f64, error: f64) {
        self.control.accept(h, error, self.formula.order(), self.formula.beta());
        let accepted = self.formula.accepted(mechanism, &self.dense_output.to, &self.next);
        self.counts.accepted += 1;
        self.steps.push([t, self.next.t]);
        self.kinds.push(accepted);
        self.counts.implicit += u64::from(accepted.is_implicit);
        self.counts.stability_bound += u64::from(accepted.is_stability_bound);
        self.counts.fallback += u64::from(accepted.is_fallback);
        self.dense_output.go_on(&mut self.next);
    }

    /// Moves across the corner at which the last step ended.
    fn cross_corner(&mut self, mechanism: &dyn Mechanism, solver: &mut Solver) -> Result<(), StepError> {
        let Some(corners) = &mut self.corners else { return Ok(()) };
        let now = &mut self.dense_output.to;
        let corner = self.corner.take().or_else(|| corners.at(now.t));
        if let Some(corner) = corner.filter(|corner| corner.just_after() < self.task.end_time) {
            corners.forget();
            self.balance.cross(mechanism, now, corner);
            solver.cross(mechanism, self.task.projection, corner.just_after(), now)?;
        }
        corners.move_off_zero(mechanism, (self.task.projection, solver), SHORTEST_TO_CORNER * self.control.h, now)
    }

    /// The first corner inside the last step, further than `shortest` from its beginning.
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
        // The step may be repeated, and the states inside it are not those of the method.
        let mut formula = formula.clone();
        formula.accepted(mechanism, from, next);
        let mut inside = DenseOutput::new(from.clone(), next.clone());
        let mut evaluator = Evaluator { evaluations: &mut 0, solver };
        let met = corners.first_inside([from, next], shortest, &mut |t| {
            let mut at = State { t, ..inside.to.clone() };
            formula.state_inside(mechanism, &mut inside, task, &mut evaluator, &mut at)?;
            Ok(at)
        })?;
        let met = met.filter(|met| next.t - met.t > SHORTEST_TO_CORNER * h).map(|met| Corner(met.t));
        if met.is_some() {
            corners.forget();
        }
        Ok(met)
    }
}
