//! Gauss-Newton projection of coordinates and rates onto the constraints.

use qrm_core::{Mechanism, StateMut};

use super::matrix::{largest, subtract_combination};
use super::projection_settings::{NotConverged, Projection, ProjectionTolerance};
use super::saddle_point::{SaddlePoint, minv_ct, schur_complement};
use super::solver::Solver;
use super::stats::SolverStats;
use crate::state::State;

/// Residuals up to this size, in m or rad, are rounding errors: near a singular position a correction would amplify
/// them.
const ROUNDING: f64 = 4e-16;
/// Residuals up to this size, in m or rad, may be rounding errors amplified near a singular position. A run reports if
/// it had to accept one.
const SETTLED: f64 = 1e-9;

impl Solver {
    /// Projects `q` onto the constraints at time `t` and `qd` onto their tangent space, and returns the number of
    /// corrections of `q`. The mass metric of `q` is the last one factored; if the mass matrix is singular, the
    /// Euclidean metric replaces it.
    ///
    /// # Errors
    /// The residual is still above the tolerance after the allowed iterations.
    pub fn project(
        &mut self,
        mechanism: &dyn Mechanism,
        (projection, tolerance): (Projection, ProjectionTolerance),
        t: f64,
        q: &mut [f64],
        qd: &mut [f64],
    ) -> Result<u32, NotConverged> {
        if self.weights.is_empty() || projection == Projection::None {
            return Ok(0);
        }
        let has_metric = self.has_metric && projection == Projection::Mass;
        self.start.copy_from_slice(q);
        let (mut first, mut before) = (0.0, f64::INFINITY);
        let mut iterations = 0;
        loop {
            self.constraints.evaluate(mechanism, t, q);
            let (constraint, residual) = largest(&self.constraints.residuals);
            let is_closed = residual <= tolerance.residual;
            // A residual of the size of rounding errors that corrections no longer reduce cannot be improved.
            let is_settled = !is_closed && residual > 0.5 * before && residual <= SETTLED;
            if !is_closed && !is_settled && (iterations == tolerance.iterations || !residual.is_finite()) {
                return Err(NotConverged { constraint, residual, iterations });
            }
            let is_regular = self.factor_constraints(has_metric);
            if is_settled {
                self.stats.count_stalled(constraint, residual);
            } else if residual > ROUNDING {
                // The Jacobian is known: one more correction is cheap and reduces the residual far below the tolerance.
                self.weights.copy_from_slice(&self.constraints.residuals);
                self.correct(is_regular, q);
            }
            if iterations == 0 {
                first = residual;
            }
            if is_closed || is_settled {
                self.take_correction(first, q);
                let mut is_regular = is_regular;
                if has_metric {
                    // Rates belong to the final position, in its own metric.
                    self.constraints.evaluate(mechanism, t, q);
                    self.factor_mass(mechanism, q);
                    is_regular = self.factor_constraints(self.has_metric);
                }
                self.constraints.velocity_residual_into(qd, &mut self.weights);
                self.correct(is_regular, qd);
                return Ok(iterations + u32::from(is_closed));
            }
            before = residual;
            iterations += 1;
        }
    }

    /// Projects a state by the kernel and completes it; returns false and changes nothing if that fails.
    pub(crate) fn project_by_kernel(&mut self, mechanism: &dyn Mechanism, residual: f64, state: &mut State) -> bool {
        let State { t, q, qd, qdd, multipliers, .. } = state;
        self.start.copy_from_slice(q);
        let Some(projected) = mechanism.project(*t, residual, StateMut { q, qd, qdd, multipliers }) else {
            return false;
        };
        self.take_correction(projected.residual, q);
        state.corrections = projected.corrections;
        true
    }

    /// Records the residual before a correction of the coordinates, and the size of the correction.
    fn take_correction(&mut self, residual: f64, to: &[f64]) {
        self.stats.take_residual(residual);
        for ((correction, from), to) in self.corrections.iter_mut().zip(&self.start).zip(to) {
            *correction = correction.max((to - from).abs());
        }
    }

    /// Keeps the coordinates before a correction by [`precise_state`](Self::precise_state).
    pub(crate) fn begin_correction(&mut self, from: &[f64]) {
        self.start.copy_from_slice(from);
    }

    /// Records a correction by [`precise_state`](Self::precise_state), which evaluated the residuals before.
    pub(crate) fn take_precise_correction(&mut self, to: &[f64]) {
        let residual = largest(&self.constraints.residuals).1;
        self.take_correction(residual, to);
    }

    /// Records the corrections of another solver, where they are larger.
    pub(crate) fn take_corrections_of(&mut self, other: &Self) {
        self.stats.take_residual(other.stats.residual_before_correction);
        for (correction, other) in self.corrections.iter_mut().zip(&other.corrections) {
            *correction = correction.max(*other);
        }
    }

    /// Factors the constraint Jacobian for corrections; false if the fast factorization fails.
    fn factor_constraints(&mut self, has_metric: bool) -> bool {
        let jacobian = &self.constraints.constraint_jacobian;
        let saddle = &mut self.saddle;
        if has_metric {
            minv_ct(&self.metric, jacobian, &mut saddle.minv_ct);
        } else {
            saddle.minv_ct.copy_from(jacobian);
        }
        schur_complement(jacobian, &saddle.minv_ct, &mut saddle.schur);
        !saddle.is_redundant() && saddle.schur_factors.factor_products(&saddle.schur)
    }

    /// Moves `x` by the smallest `dx` with `C_q dx = -residual`; the residuals are in `weights`.
    fn correct(&mut self, is_regular: bool, x: &mut [f64]) {
        if is_regular {
            self.saddle.schur_factors.solve(&mut self.weights);
        } else {
            solve_dependent(&self.saddle, &mut self.weights, &mut self.stats);
        }
        subtract_combination(x, &self.saddle.minv_ct, &self.weights);
    }
}

#[cold]
fn solve_dependent(saddle: &SaddlePoint, weights: &mut [f64], stats: &mut SolverStats) {
    let factors = saddle.robust_factors();
    stats.count_rank(&factors, saddle.rank);
    factors.solve(weights);
}
