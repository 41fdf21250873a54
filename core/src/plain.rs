//! A mechanism without its kernel.

use crate::scalar::Scalar;
use crate::{Closure, Description, Dynamics, Mechanism, NoKernel, Schedule, Start};

/// The same mechanism, stepped by its plain functions alone: for comparison.
#[derive(Clone, Copy, Debug)]
pub struct Plain<X>(pub X);

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Mechanism<N, M> for Plain<X> {
    type Kernel<R: Scalar> = NoKernel;

    const DESCRIPTION: Description = X::DESCRIPTION;
    const IS_DRIVEN: bool = X::IS_DRIVEN;

    fn with_parameters(replace: &dyn Fn(&str) -> Option<f64>) -> Self {
        Self(X::with_parameters(replace))
    }

    fn visit_parameters(&self, visit: &mut dyn FnMut(f64)) {
        self.0.visit_parameters(visit);
    }

    fn start(&self) -> Start<f64, N> {
        self.0.start()
    }

    fn schedule(&self) -> Schedule<f64> {
        self.0.schedule()
    }

    fn stop(&self, t: f64, q: &[f64; N], qd: &[f64; N]) -> Option<f64> {
        self.0.stop(t, q, qd)
    }

    #[inline(always)]
    fn dynamics(&self, t: f64, q: &[f64; N], qd: &[f64; N]) -> Dynamics<f64, N, M> {
        self.0.dynamics(t, q, qd)
    }

    #[inline(always)]
    fn closure(&self, t: f64, q: &[f64; N]) -> Closure<f64, N, M> {
        self.0.closure(t, q)
    }

    fn mass_matrix(&self, q: &[f64; N]) -> [[f64; N]; N] {
        self.0.mass_matrix(q)
    }

    fn energy(&self, q: &[f64; N], qd: &[f64; N]) -> [f64; 2] {
        self.0.energy(q, qd)
    }

    fn power(&self, t: f64, q: &[f64; N], qd: &[f64; N], multipliers: &[f64; M]) -> f64 {
        self.0.power(t, q, qd, multipliers)
    }

    fn outputs(
        &self,
        t: f64,
        q: &[f64; N],
        qd: &[f64; N],
        qdd: &[f64; N],
        multipliers: &[f64; M],
        outputs: &mut [f64],
    ) {
        self.0.outputs(t, q, qd, qdd, multipliers, outputs);
    }
}
