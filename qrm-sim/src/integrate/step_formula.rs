//! The formula of a step whose length is chosen by a tolerance.

use qrm_core::Mechanism;

use super::dense_output::DenseOutput;
use super::step_bounds::StepBounds;
use super::step_error::StepError;
use crate::quadrature::GAUSS_3;
use crate::solve::{Projection, ProjectionTolerance, Solver};
use crate::state::State;

/// The largest relative error of the work on a coarse grid for which the number of panels is not increased.
const BEND: f64 = 0.1;
/// The largest number of panels in a step.
const MOST_PANELS: u32 = 64;

/// The formula of a step.
pub(super) trait StepFormula: std::fmt::Debug + Send {
    /// The order of the errors by which steps are controlled.
    fn order(&self) -> i32;

    /// The exponent of the previous error in the PI control of the step length.
    fn beta(&self) -> f64;

    /// Makes a step of length `h` from a state, projects its end, and returns its error. Up to 1 the step is accepted;
    /// above, the end is meaningless.
    ///
    /// # Errors
    /// The step could not be made.
    fn attempt(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        h: f64,
        task: &Task,
        evaluator: &mut Evaluator,
        to: &mut State,
    ) -> Result<f64, StepError>;

    /// Records an accepted step.
    fn accepted(&mut self, mechanism: &dyn Mechanism, from: &State, to: &State) -> Accepted;

    /// Computes the higher coefficients of the dense output of the last step, if a polynomial of degree 5 does not
    /// suffice.
    ///
    /// # Errors
    /// The coefficients could not be computed.
    fn complete_dense_output(
        &mut self,
        _mechanism: &dyn Mechanism,
        _step: &mut DenseOutput,
        _task: &Task,
        _evaluator: &mut Evaluator,
    ) -> Result<(), StepError> {
        Ok(())
    }

    /// Computes the projected state at the time of `to` inside the last step.
    ///
    /// # Errors
    /// The state could not be computed.
    fn state_inside(
        &mut self,
        mechanism: &dyn Mechanism,
        step: &mut DenseOutput,
        task: &Task,
        evaluator: &mut Evaluator,
        to: &mut State,
    ) -> Result<(), StepError> {
        self.complete_dense_output(mechanism, step, task, evaluator)?;
        step.at(to.t, &mut to.q, &mut to.qd);
        *evaluator.evaluations += 1;
        evaluator.solver.projected(mechanism, task.projection, to)
    }

    /// Computes the work of the loads without potential in the last step; `room` is a buffer for a state.
    ///
    /// # Errors
    /// A state inside the step could not be computed.
    fn load_work(
        &mut self,
        mechanism: &dyn Mechanism,
        step: &mut DenseOutput,
        task: &Task,
        evaluator: &mut Evaluator,
        room: &mut State,
    ) -> Result<f64, StepError> {
        self.complete_dense_output(mechanism, step, task, evaluator)?;
        let mut power = |t: f64| -> Result<f64, StepError> {
            let State { q, qd, qdd, multipliers, .. } = &mut *room;
            step.at(t, q, qd);
            // Accelerations and multipliers matter for constraints that do work, and for friction that depends on joint
            // forces.
            qdd.fill(0.0);
            multipliers.fill(0.0);
            if mechanism.is_driven() || !mechanism.description().friction.is_empty() {
                let stats = evaluator.solver.stats;
                evaluator.solver.accelerations(mechanism, t, (q, qd), (qdd, multipliers))?;
                evaluator.solver.stats = stats;
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
            // The mean of the outer points differs from that of all points where the power is curved.
            if (sum - coarse).abs() <= BEND * size || panels == MOST_PANELS {
                return Ok(sum);
            }
            panels *= 4;
        }
    }

    /// Copies the formula into a new box.
    fn boxed_clone(&self) -> Box<dyn StepFormula>;
}

impl Clone for Box<dyn StepFormula> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// The tolerance, the end time, the projection and the bounds of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    /// Largest error of a step, in the unit of each coordinate and rate.
    pub(super) tolerance: f64,
    /// Steps that reach this time end there exactly.
    pub(super) end_time: f64,
    /// The dense output of steps that end after this time is computed immediately.
    pub(super) dense_from: f64,
    /// The projection after each step.
    pub(super) projection: (Projection, ProjectionTolerance),
    /// Bounds of the steps.
    pub(super) bounds: StepBounds,
}

impl Task {
    /// The end of a step of length `h` that begins at `t`.
    pub(super) fn end_of_step(&self, t: f64, h: f64) -> f64 {
        if t + h >= self.end_time { self.end_time } else { t + h }
    }

    /// The largest error of each coordinate and of its rate in a step. The scale of an angle does not grow with its
    /// revolutions.
    pub(super) fn error_scales(
        &self,
        mechanism: &dyn Mechanism,
        i: usize,
        from: &State,
        (q, qd): (&[f64], &[f64]),
    ) -> [f64; 2] {
        let size = if mechanism.description().is_angle(i) { 0.0 } else { from.q[i].abs().max(q[i].abs()) };
        [self.tolerance * (1.0 + size), self.tolerance * (1.0 + from.qd[i].abs().max(qd[i].abs()))]
    }
}

/// The solver of a step, with a counter of its evaluations.
pub(super) struct Evaluator<'a> {
    /// The number of evaluations.
    pub(super) evaluations: &'a mut u64,
    pub(super) solver: &'a mut Solver,
}

/// The kind of an accepted step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Accepted {
    /// Whether the linearly implicit method made it.
    pub(super) is_implicit: bool,
    /// Whether stability limited its length.
    pub(super) is_stability_bound: bool,
    /// Whether `auto` made it instead of the chosen method.
    pub(super) is_fallback: bool,
}
