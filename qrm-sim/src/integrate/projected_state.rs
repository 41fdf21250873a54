//! Projection of states onto the constraints, and computation of their accelerations and multipliers.

use qrm_core::Mechanism;

use super::methods::MethodSettings;
use super::step_error::StepError;
use crate::solve::{IRREGULAR, NEAR, Projection, ProjectionTolerance, Solver};
use crate::state::State;

impl Solver {
    /// Moves a state along its rates and accelerations to a time so close that nothing else changes.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn cross(
        &mut self,
        mechanism: &dyn Mechanism,
        projection: (Projection, ProjectionTolerance),
        t: f64,
        state: &mut State,
    ) -> Result<(), StepError> {
        state.move_along(t - state.t);
        state.t = t;
        self.projected(mechanism, projection, state)
    }

    /// Computes the accelerations and multipliers of a state.
    ///
    /// # Errors
    /// The accelerations are not determined, or not finite.
    pub fn complete(&mut self, mechanism: &dyn Mechanism, state: &mut State) -> Result<(), StepError> {
        let State { t, q, qd, qdd, multipliers, .. } = state;
        self.accelerations(mechanism, *t, (q, qd), (qdd, multipliers))?;
        if let Some(precise) = self.precise_state(mechanism, IRREGULAR, *t, (q, qd)) {
            precise.write_dynamics(qdd, multipliers);
        }
        if state.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }

    /// Replaces a state by that with all digits on the constraints, where the smallest singular value of `C_q` is below
    /// `limit` of that at regular positions; false elsewhere, and if the state is not determined.
    pub(crate) fn refine(&mut self, mechanism: &dyn Mechanism, limit: f64, state: &mut State) -> bool {
        let State { t, q, qd, qdd, multipliers, .. } = state;
        let precise = self.precise_state(mechanism, limit, *t, (q, qd));
        if let Some(precise) = &precise {
            precise.write_motion(q, qd);
            precise.write_dynamics(qdd, multipliers);
        }
        precise.is_some()
    }

    /// Closes the loops of a state under other parameters, if requested, and computes accelerations and multipliers.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(crate) fn make_consistent(
        &mut self,
        mechanism: &dyn Mechanism,
        settings: &MethodSettings,
        state: &mut State,
    ) -> Result<(), StepError> {
        if settings.projection != Projection::None {
            let projection = (settings.projection, settings.projection_tolerance);
            self.project(mechanism, projection, state.t, &mut state.q, &mut state.qd)?;
        }
        state.corrections = 0;
        self.complete(mechanism, state)
    }

    /// Projects a state and computes its accelerations and multipliers, by the kernel if the projection allows it.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn projected(
        &mut self,
        mechanism: &dyn Mechanism,
        (projection, tolerance): (Projection, ProjectionTolerance),
        state: &mut State,
    ) -> Result<(), StepError> {
        if self.projects_by_kernel((projection, tolerance))
            && self.project_by_kernel(mechanism, tolerance.residual, state)
        {
            return Ok(());
        }
        if projection == Projection::Mass {
            self.factor_mass(mechanism, &state.q);
        }
        self.projected_by_functions(mechanism, (projection, tolerance), state)
    }

    /// Whether kernels support this projection, and steps with it; not if constraints are redundant.
    pub(super) fn projects_by_kernel(&self, (projection, tolerance): (Projection, ProjectionTolerance)) -> bool {
        projection.is_by_kernel(&tolerance) && !self.is_redundant() && !self.avoids_kernels
    }

    /// Projects a state by the plain functions, in the known metric, and computes its accelerations and multipliers; in
    /// all digits near a singular position.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn projected_by_functions(
        &mut self,
        mechanism: &dyn Mechanism,
        projection: (Projection, ProjectionTolerance),
        state: &mut State,
    ) -> Result<(), StepError> {
        self.begin_correction(&state.q);
        if projection.0 != Projection::None && self.refine(mechanism, NEAR, state) {
            self.take_precise_correction(&state.q);
            state.corrections = 1;
            return Ok(());
        }
        let State { t, q, qd, qdd, multipliers, .. } = state;
        state.corrections = self.project(mechanism, projection, *t, q, qd)?;
        self.accelerations(mechanism, *t, (q, qd), (qdd, multipliers))?;
        if state.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }
}
