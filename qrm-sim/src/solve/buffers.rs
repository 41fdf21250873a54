//! Buffers for the results of a mechanism's functions.

use qrm_core::{Dual, DynamicsMut, LinearizationMut, LoopConstraintsMut, Mechanism};

use super::matrix::{Matrix, dot};
use super::tree_linearization::{has_momenta, linearization_of_tree};

/// The parts of the equations of motion at one state: see [`qrm_core::Dynamics`].
#[derive(Clone, Debug)]
pub struct Dynamics {
    /// Mbar, `n` by `n`.
    pub mass_matrix: Matrix,
    /// fbar, `n`.
    pub generalized_forces: Vec<f64>,
    /// C_q, `m` by `n`.
    pub constraint_jacobian: Matrix,
    /// `(C_q qd)_q qd + 2 C_qt qd + C_tt`, `m`.
    pub constraint_bias: Vec<f64>,
}

impl Dynamics {
    /// Creates buffers for a mechanism of `n` coordinates and `m` constraints.
    pub fn zero(n: usize, m: usize) -> Self {
        Self {
            mass_matrix: Matrix::zero(n, n),
            generalized_forces: vec![0.0; n],
            constraint_jacobian: Matrix::zero(m, n),
            constraint_bias: vec![0.0; m],
        }
    }

    /// Evaluates the equations of motion of a mechanism at a state, in new buffers.
    pub fn at(mechanism: &dyn Mechanism, t: f64, q: &[f64], qd: &[f64]) -> Self {
        let mut dynamics = Self::zero(q.len(), mechanism.description().constraints.len());
        dynamics.evaluate(mechanism, t, q, qd);
        dynamics
    }

    /// Evaluates the equations of motion at a state.
    pub fn evaluate(&mut self, mechanism: &dyn Mechanism, t: f64, q: &[f64], qd: &[f64]) {
        let dynamics = DynamicsMut {
            mass_matrix: self.mass_matrix.entries_mut(),
            generalized_forces: &mut self.generalized_forces,
            constraint_jacobian: self.constraint_jacobian.entries_mut(),
            constraint_bias: &mut self.constraint_bias,
        };
        mechanism.dynamics(t, q, qd, dynamics);
    }
}

/// The loop constraints at one position and time: see [`qrm_core::LoopConstraints`].
#[derive(Clone, Debug)]
pub struct LoopConstraints {
    /// C, `m`.
    pub residuals: Vec<f64>,
    /// C_q, `m` by `n`.
    pub constraint_jacobian: Matrix,
    /// C_t, `m`.
    pub constraint_rate: Vec<f64>,
}

impl LoopConstraints {
    /// Creates buffers for a mechanism of `n` coordinates and `m` constraints.
    pub fn zero(n: usize, m: usize) -> Self {
        Self { residuals: vec![0.0; m], constraint_jacobian: Matrix::zero(m, n), constraint_rate: vec![0.0; m] }
    }

    /// Evaluates the constraints of a mechanism at a position, in new buffers.
    pub fn at(mechanism: &dyn Mechanism, t: f64, q: &[f64]) -> Self {
        let mut constraints = Self::zero(q.len(), mechanism.description().constraints.len());
        constraints.evaluate(mechanism, t, q);
        constraints
    }

    /// Evaluates the constraints at a position.
    pub fn evaluate(&mut self, mechanism: &dyn Mechanism, t: f64, q: &[f64]) {
        mechanism.loop_constraints(t, q, self.as_mut());
    }

    /// The buffers as arguments of a mechanism's functions.
    pub(crate) fn as_mut(&mut self) -> LoopConstraintsMut<'_> {
        LoopConstraintsMut {
            residuals: &mut self.residuals,
            constraint_jacobian: self.constraint_jacobian.entries_mut(),
            constraint_rate: &mut self.constraint_rate,
        }
    }

    /// The rates of the residuals, `C_q qd + C_t`.
    pub fn velocity_residual(&self, qd: &[f64]) -> Vec<f64> {
        let mut rates = vec![0.0; self.residuals.len()];
        self.velocity_residual_into(qd, &mut rates);
        rates
    }

    /// The rates of the residuals, `C_q qd + C_t`, written to `rates`.
    pub fn velocity_residual_into(&self, qd: &[f64], rates: &mut [f64]) {
        for ((rate, row), own) in rates.iter_mut().zip(self.constraint_jacobian.iter()).zip(&self.constraint_rate) {
            *rate = dot(row, qd) + own;
        }
    }
}

/// The derivatives of the equations of motion with respect to the state: see [`qrm_core::Linearization`].
#[derive(Clone, Debug)]
pub struct Linearization {
    /// Stiffness, `n` by `n`.
    pub stiffness: Matrix,
    /// Damping, `n` by `n`.
    pub damping: Matrix,
    /// Stiffness of the constraints, `m` by `n`.
    pub constraint_stiffness: Matrix,
    /// Damping of the constraints, `m` by `n`.
    pub constraint_damping: Matrix,
    /// Forcing, `n`.
    pub forcing: Vec<f64>,
    /// Forcing of the constraints, `m`.
    pub constraint_forcing: Vec<f64>,
}

impl Linearization {
    /// Creates buffers for a mechanism of `n` coordinates and `m` constraints.
    pub fn zero(n: usize, m: usize) -> Self {
        Self {
            stiffness: Matrix::zero(n, n),
            damping: Matrix::zero(n, n),
            constraint_stiffness: Matrix::zero(m, n),
            constraint_damping: Matrix::zero(m, n),
            forcing: vec![0.0; n],
            constraint_forcing: vec![0.0; m],
        }
    }

    /// Whether a mechanism has derivatives: generated ones if its scene requests them, those of large trees always.
    pub fn is_known(mechanism: &dyn Mechanism) -> bool {
        mechanism.has_linearization() || has_momenta(mechanism.tape())
    }

    /// Evaluates the derivatives; false if they are not known.
    pub fn evaluate(&mut self, mechanism: &dyn Mechanism, at: &crate::state::State) -> bool {
        let linearization = LinearizationMut {
            stiffness: self.stiffness.entries_mut(),
            damping: self.damping.entries_mut(),
            constraint_stiffness: self.constraint_stiffness.entries_mut(),
            constraint_damping: self.constraint_damping.entries_mut(),
            forcing: &mut self.forcing,
            constraint_forcing: &mut self.constraint_forcing,
        };
        if mechanism.linearization(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, linearization) {
            return true;
        }
        let Some(tape) = mechanism.tape().filter(|tape| has_momenta(Some(tape))) else { return false };
        let plain = |values: &[f64]| values.iter().map(|value| Dual(*value)).collect::<Vec<_>>();
        let [parameters, q, qd, qdd] = [mechanism.parameters(), &at.q, &at.qd, &at.qdd].map(plain);
        let parts = linearization_of_tree(tape, &parameters, Dual(at.t), [&q, &qd, &qdd]);
        let own = [self.stiffness.entries_mut(), self.damping.entries_mut(), &mut self.forcing];
        for (own, part) in own.into_iter().zip(&parts) {
            own.iter_mut().zip(part).for_each(|(entry, value)| *entry = value.0);
        }
        true
    }
}
