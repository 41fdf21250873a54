//! The response of the accelerations to small changes of the state.

use qrm_core::Mechanism;

use super::buffers::{Dynamics, Linearization};
use super::matrix::dot;
use super::saddle_point::SaddlePoint;
use super::stats::SolverStats;
use crate::state::State;

/// The linearized equations of motion at one state: the changes of `qdd` and `lambda` for changes of coordinates and
/// rates solve the same system with another right-hand side.
#[derive(Clone, Debug)]
pub(crate) struct Response {
    pub(crate) dynamics: Dynamics,
    linearization: Linearization,
}

impl Response {
    /// Computes the response from exact derivatives; `None` if they are not known.
    pub(crate) fn exact(mechanism: &dyn Mechanism, at: &State) -> Option<Self> {
        let mut linearization = Linearization::zero(at.q.len(), at.multipliers.len());
        linearization
            .evaluate(mechanism, at)
            .then(|| Self { dynamics: Dynamics::at(mechanism, at.t, &at.q, &at.qd), linearization })
    }

    /// Computes the response from exact derivatives, or from differences if there are none.
    pub(crate) fn new(mechanism: &dyn Mechanism, at: &State) -> Self {
        Self::exact(mechanism, at).unwrap_or_else(|| Self {
            dynamics: Dynamics::at(mechanism, at.t, &at.q, &at.qd),
            linearization: differences(mechanism, at),
        })
    }

    /// The change of the accelerations for a change `u` of the coordinates and `w` of the rates; `None` if it is not
    /// determined.
    pub(crate) fn accelerations(&self, u: &[f64], w: &[f64]) -> Option<Vec<f64>> {
        let linearization = &self.linearization;
        let (n, m) = (u.len(), linearization.constraint_forcing.len());
        let mut changed = SaddlePoint::zero(n, m);
        changed.dynamics.mass_matrix.copy_from(&self.dynamics.mass_matrix);
        changed.dynamics.constraint_jacobian.copy_from(&self.dynamics.constraint_jacobian);
        for (i, force) in changed.dynamics.generalized_forces.iter_mut().enumerate() {
            *force = -dot(&linearization.stiffness[i], u) - dot(&linearization.damping[i], w);
        }
        for (k, bias) in changed.dynamics.constraint_bias.iter_mut().enumerate() {
            *bias = dot(&linearization.constraint_stiffness[k], u) + dot(&linearization.constraint_damping[k], w);
        }
        let (mut qdd, mut multipliers) = (vec![0.0; n], vec![0.0; m]);
        changed.solve(&mut qdd, &mut multipliers, &mut SolverStats::default()).ok()?;
        Some(qdd)
    }
}

/// Relative step of central differences, about the cube root of the rounding error.
const STEP: f64 = 6e-6;

/// Derivatives by central differences of the equations of motion, with accelerations and multipliers fixed.
fn differences(mechanism: &dyn Mechanism, at: &State) -> Linearization {
    let (n, m) = (at.q.len(), at.multipliers.len());
    let residuals = |q: &[f64], qd: &[f64]| -> (Vec<f64>, Vec<f64>) {
        let d = Dynamics::at(mechanism, at.t, q, qd);
        let force = |i: usize| (0..m).map(|k| d.constraint_jacobian[k][i] * at.multipliers[k]).sum::<f64>();
        let of_motion = |i: usize| dot(&d.mass_matrix[i], &at.qdd) + force(i) - d.generalized_forces[i];
        let of_constraints = |k: usize| dot(&d.constraint_jacobian[k], &at.qdd) + d.constraint_bias[k];
        ((0..n).map(of_motion).collect(), (0..m).map(of_constraints).collect())
    };
    let mut found = Linearization::zero(n, m);
    for j in 0..n {
        let moved = |x: &[f64], by: f64| -> Vec<f64> {
            let mut moved = x.to_vec();
            moved[j] += by;
            moved
        };
        let (of_q, of_qd) = (STEP * (1.0 + at.q[j].abs()), STEP * (1.0 + at.qd[j].abs()));
        let (low, high) = (residuals(&moved(&at.q, -of_q), &at.qd), residuals(&moved(&at.q, of_q), &at.qd));
        let (slow, fast) = (residuals(&at.q, &moved(&at.qd, -of_qd)), residuals(&at.q, &moved(&at.qd, of_qd)));
        for i in 0..n {
            found.stiffness[i][j] = (high.0[i] - low.0[i]) / (2.0 * of_q);
            found.damping[i][j] = (fast.0[i] - slow.0[i]) / (2.0 * of_qd);
        }
        for k in 0..m {
            found.constraint_stiffness[k][j] = (high.1[k] - low.1[k]) / (2.0 * of_q);
            found.constraint_damping[k][j] = (fast.1[k] - slow.1[k]) / (2.0 * of_qd);
        }
    }
    found
}
