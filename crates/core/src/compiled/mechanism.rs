//! A compiled mechanism as plain functions over slices.

#[cfg(feature = "std")]
extern crate alloc;

#[cfg(feature = "std")]
use alloc::{boxed::Box, vec::Vec};

use super::{Compiled, Generated};
use crate::buffers::{DynamicsMut, LinearizationMut, LoopConstraintsMut, RowQuantities, StartMut, StateRef};
use crate::description::Description;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::gauss::{GaussSteps, Steps};
use crate::kernel::{Equations, Kernel, Schedule};
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::lane_steps::suits;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::lanes::Lanes;
use crate::mechanism::{Mechanism, row_quantities};
use crate::projection::{ProjectionResult, StateMut, complete};
use crate::rows::{RowRequest, RowResult, integrate_rk4};
#[cfg(feature = "simd")]
use crate::scalar::{Fused, Scalar};
#[cfg(feature = "simd")]
use crate::single_step::{StepEstimate, StepMut, StepRequest, fused};
#[cfg(feature = "std")]
use crate::tape::Tape;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::width::Width;

/// A slice as an array.
#[inline(always)]
fn array<const K: usize>(x: &[f64]) -> &[f64; K] {
    match x.as_array() {
        Some(array) => array,
        None => wrong_length(x.len(), K),
    }
}

#[cold]
#[inline(never)]
fn wrong_length(length: usize, expected: usize) -> ! {
    panic!("a vector of the mechanism has {length} entries instead of {expected}")
}

impl<X: Generated<N, M>, const N: usize, const M: usize, V> Mechanism for Compiled<X, N, M, V>
where
    V: AsRef<[f64]> + Send + Sync,
{
    #[inline]
    fn description(&self) -> &'static Description {
        X::DESCRIPTION
    }

    #[inline]
    fn parameters(&self) -> &[f64] {
        self.values.as_ref()
    }

    #[cfg(feature = "std")]
    #[inline]
    fn tape(&self) -> Option<&'static Tape> {
        Some(X::TAPE.tape())
    }

    #[cfg(feature = "std")]
    #[inline]
    fn with_parameters(&self, values: Vec<f64>) -> Option<Box<dyn Mechanism>> {
        Some(X::mechanism(values))
    }

    #[inline]
    fn is_driven(&self) -> bool {
        X::IS_DRIVEN
    }

    #[inline]
    fn has_linearization(&self) -> bool {
        X::HAS_LINEARIZATION
    }

    #[inline]
    fn operations(&self) -> usize {
        X::Kernel::<f64>::OPERATIONS
    }

    #[inline]
    fn start(&self, start: StartMut) {
        let own = self.kernel.start();
        start.q.copy_from_slice(&own.q);
        start.given.copy_from_slice(&own.given);
        start.qd.copy_from_slice(&own.qd);
        start.given_rates.copy_from_slice(&own.given_rates);
    }

    #[inline]
    fn schedule(&self) -> Schedule<f64> {
        self.kernel.schedule()
    }

    #[inline]
    fn event(&self, at: &StateRef) -> Option<f64> {
        self.kernel.event(at.t, array(at.q), array(at.qd), array(at.qdd), array(at.multipliers))
    }

    #[inline]
    fn dynamics(&self, t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut) {
        let own = self.kernel.dynamics(t, array(q), array(qd));
        dynamics.mass_matrix.copy_from_slice(own.mass_matrix.as_flattened());
        dynamics.generalized_forces.copy_from_slice(&own.generalized_forces);
        dynamics.constraint_jacobian.copy_from_slice(own.constraint_jacobian.as_flattened());
        dynamics.constraint_bias.copy_from_slice(&own.constraint_bias);
    }

    #[inline(always)]
    fn loop_constraints(&self, t: f64, q: &[f64], constraints: LoopConstraintsMut) {
        let own = self.kernel.loop_constraints(t, array(q));
        constraints.residuals.copy_from_slice(&own.residuals);
        constraints.constraint_jacobian.copy_from_slice(own.constraint_jacobian.as_flattened());
        constraints.constraint_rate.copy_from_slice(&own.constraint_rate);
    }

    #[inline]
    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]) {
        mass_matrix.copy_from_slice(self.kernel.mass_matrix(array(q)).as_flattened());
    }

    #[inline(always)]
    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        self.kernel.energy(array(q), array(qd))
    }

    #[inline(always)]
    fn power(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64 {
        self.kernel.power(t, array(q), array(qd), array(qdd), array(multipliers))
    }

    #[inline(always)]
    fn outputs(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]) {
        self.kernel.outputs(t, array(q), array(qd), array(qdd), array(multipliers), outputs);
    }

    #[inline]
    fn row_quantities(&self, at: &StateRef, outputs: &mut [f64], constraints: LoopConstraintsMut) -> RowQuantities {
        // Local copies: where sines and cosines are shared, the compiler must see that the writes below do not change
        // the state.
        let (q, qd): ([f64; N], [f64; N]) = (*array(at.q), *array(at.qd));
        let (qdd, multipliers): ([f64; N], [f64; M]) = (*array(at.qdd), *array(at.multipliers));
        let at = StateRef { t: at.t, q: &q, qd: &qd, qdd: &qdd, multipliers: &multipliers };
        row_quantities(self, &at, outputs, constraints)
    }

    #[inline]
    fn linearization(
        &self,
        t: f64,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        multipliers: &[f64],
        linearization: LinearizationMut,
    ) -> bool {
        let own = self.kernel.linearization(t, array(q), array(qd), array(qdd), array(multipliers));
        let Some(own) = own else { return false };
        linearization.stiffness.copy_from_slice(own.stiffness.as_flattened());
        linearization.damping.copy_from_slice(own.damping.as_flattened());
        linearization.constraint_stiffness.copy_from_slice(own.constraint_stiffness.as_flattened());
        linearization.constraint_damping.copy_from_slice(own.constraint_damping.as_flattened());
        linearization.forcing.copy_from_slice(&own.forcing);
        linearization.constraint_forcing.copy_from_slice(&own.constraint_forcing);
        true
    }

    #[inline]
    fn accelerations(&self, t: f64, q: &[f64], qd: &[f64], qdd: &mut [f64], multipliers: &mut [f64]) -> bool {
        let (mut q, mut qd) = (*array::<N>(q), *array::<N>(qd));
        let state = StateMut { q: &mut q, qd: &mut qd, qdd, multipliers };
        complete(&self.kernel, t, None, state).is_some()
    }

    #[inline]
    fn project(&self, t: f64, residual: f64, state: StateMut) -> Option<ProjectionResult> {
        complete(&self.kernel, t, Some(residual), state)
    }

    #[cfg(feature = "simd")]
    #[inline]
    fn dop853_step(&self, request: &StepRequest, from: &StateRef, step: StepMut) -> Option<StepEstimate> {
        Fused::vectorize(
            #[inline(always)]
            || fused::dop853(self.fused(), request, from, step),
        )?
    }

    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    #[inline]
    fn gauss_steps(&self, width: Width) -> Option<Box<dyn GaussSteps>> {
        gauss_steps::<X, N, M>(self.values.as_ref(), width)
    }

    #[inline]
    fn integrate_rk4(&self, request: &RowRequest, rows: &mut [f64]) -> RowResult {
        #[cfg(feature = "simd")]
        if let Some(result) = self.integrate_rk4_fused(request, rows) {
            return result;
        }
        integrate_rk4(&self.kernel, request, rows)
    }
}

#[cfg(feature = "simd")]
impl<X: Generated<N, M>, const N: usize, const M: usize, V: AsRef<[f64]>> Compiled<X, N, M, V> {
    /// Rows with fused products; `None` if the processor has none.
    #[inline(always)]
    fn integrate_rk4_fused(&self, request: &RowRequest, rows: &mut [f64]) -> Option<RowResult> {
        // Steps of a large kernel are compiled once for all numbers of registers.
        if const { X::Kernel::<f64>::OPERATIONS > Fused::INLINE_LIMIT } {
            return Fused::vectorize(
                #[inline(always)]
                || integrate_rk4(self.fused(), request, rows),
            );
        }
        Fused::vectorize_widest(
            #[inline(always)]
            || integrate_rk4(self.fused(), request, rows),
        )
    }
}

/// The steps of a generated mechanism; `None` where the processor has no vectors of that width, or the kernel is too
/// large for them.
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
#[inline]
fn gauss_steps<X: Generated<N, M>, const N: usize, const M: usize>(
    values: &[f64],
    width: Width,
) -> Option<Box<dyn GaussSteps>> {
    // Constants, so that unused code is not compiled.
    type Make = fn(&[f64]) -> Option<Box<dyn GaussSteps>>;
    let four: Option<Make> =
        const { if suits(Width::Four, X::Kernel::<f64>::OPERATIONS) { Some(make_four::<X, N, M>) } else { None } };
    let eight: Option<Make> =
        const { if suits(Width::Eight, X::Kernel::<f64>::OPERATIONS) { Some(make_eight::<X, N, M>) } else { None } };
    match width {
        Width::Eight => eight?(values),
        Width::Four => four?(values),
    }
}

#[cfg(all(feature = "simd", target_arch = "x86_64"))]
#[inline]
fn make_four<X: Generated<N, M>, const N: usize, const M: usize>(values: &[f64]) -> Option<Box<dyn GaussSteps>> {
    let token = pulp::x86::V3::try_new()?;
    let kernel = X::Kernel::<Lanes<pulp::x86::V3>>::with_values(&|i| Lanes::from_f64(values[i]));
    Some(Box::new(Steps::new(token, kernel)))
}

#[cfg(all(feature = "simd", target_arch = "x86_64"))]
#[inline]
fn make_eight<X: Generated<N, M>, const N: usize, const M: usize>(values: &[f64]) -> Option<Box<dyn GaussSteps>> {
    let token = pulp::x86::V4::try_new()?;
    let kernel = X::Kernel::<Lanes<pulp::x86::V4>>::with_values(&|i| Lanes::from_f64(values[i]));
    Some(Box::new(Steps::new(token, kernel)))
}
