//! A mechanism without its kernel.

#[macro_use]
#[path = "delegate.rs"]
mod delegate;

use qrm_core::{DynamicsMut, LoopConstraintsMut, Mechanism};

/// A mechanism without its kernel: every step is made by the plain functions.
pub(crate) struct Plain(pub(crate) Box<dyn Mechanism>);

impl Mechanism for Plain {
    delegate_without_kernel!(0);

    fn dynamics(&self, t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut) {
        self.0.dynamics(t, q, qd, dynamics);
    }

    fn loop_constraints(&self, t: f64, q: &[f64], constraints: LoopConstraintsMut) {
        self.0.loop_constraints(t, q, constraints);
    }

    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]) {
        self.0.mass_matrix(q, mass_matrix);
    }
}
