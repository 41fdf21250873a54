//! The face of a mechanism to a simulator: plain functions over slices, whatever its size.

#[cfg(feature = "simd")]
extern crate alloc;

#[cfg(feature = "simd")]
use alloc::boxed::Box;
use core::marker::PhantomData;

#[cfg(feature = "simd")]
use crate::batch::Width;
use crate::description::Description;
#[cfg(feature = "simd")]
use crate::gauss::GaussSteps;
use crate::kernel::{Equations, Generated, Kernel, Schedule};
#[cfg(feature = "simd")]
use crate::model::Model;
use crate::projection::{ProjectionResult, StateMut, complete};
use crate::rows::{RowRequest, RowResult, integrate_rk4};
#[cfg(feature = "simd")]
use crate::scalar::{Fused, Scalar};
#[cfg(feature = "simd")]
use crate::single_step::fused;
use crate::single_step::{StepEstimate, StepMut, StepRequest};

/// The equations of motion of a mechanism with `n` coordinates and `m` constraints, its parameters inside.
///
/// Vectors of coordinates have `n` entries, those of constraints `m`; matrices are flat, row after row. A slice of
/// another length is a mistake of the caller and panics. All numbers are in SI units, angles in radians.
pub trait Mechanism: Send + Sync {
    /// Names, units and meanings.
    fn description(&self) -> &'static Description;

    /// The values of the parameters, in the order of the description.
    fn parameters(&self) -> &[f64];

    /// The entry of the generated mechanism, by which it is made with other parameters; `None` if it is not generated.
    #[cfg(feature = "simd")]
    fn model(&self) -> Option<Model> {
        None
    }

    /// Whether constraints depend on time.
    fn is_driven(&self) -> bool;

    /// Whether [`linearization`](Self::linearization) gives derivatives.
    fn has_linearization(&self) -> bool {
        false
    }

    /// The number of operations of accelerations and multipliers by the kernel.
    fn operations(&self) -> usize;

    /// The start of the motion.
    fn start(&self, start: StartMut);

    /// Step and end of the motion.
    fn schedule(&self) -> Schedule<f64>;

    /// A value that rises through zero when the scene's stop condition becomes true; `None` if it has no such
    /// condition.
    fn event(&self, at: &StateRef) -> Option<f64>;

    /// The parts of the equations of motion.
    fn dynamics(&self, t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut);

    /// The constraints, their Jacobian and their derivative by time.
    fn loop_constraints(&self, t: f64, q: &[f64], constraints: LoopConstraintsMut);

    /// The reduced mass matrix `Mbar`, `n` by `n`.
    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]);

    /// The kinetic energy, and the potential of the conservative loads, in J.
    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2];

    /// The power of the loads that have no potential, and of what drives the constraints, in W.
    fn power(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64;

    /// The outputs, in the order of the description; as far as `outputs` has room.
    fn outputs(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]);

    /// The quantities of a row of a trajectory: outputs, constraints, energy and power, with the sines and cosines that
    /// they share.
    fn row_quantities(&self, at: &StateRef, outputs: &mut [f64], constraints: LoopConstraintsMut) -> RowQuantities {
        row_quantities(self, at, outputs, constraints)
    }

    /// Derivatives of the equations of motion by the state; false, and nothing is written, if the scene does not ask
    /// for them.
    fn linearization(
        &self,
        t: f64,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        multipliers: &[f64],
        linearization: LinearizationMut,
    ) -> bool {
        let _ = (t, q, qd, qdd, multipliers, linearization);
        false
    }

    /// Accelerations and multipliers by the kernel; false where it does not suit the position, or a number is not
    /// finite. Without a kernel all steps are made by the plain functions.
    fn accelerations(&self, t: f64, q: &[f64], qd: &[f64], qdd: &mut [f64], multipliers: &mut [f64]) -> bool {
        let _ = (t, q, qd, qdd, multipliers);
        false
    }

    /// Projects coordinates and rates onto the constraints at time `t` in the mass metric by the kernel, up to a
    /// `residual`, and completes the state by its accelerations and multipliers. `None`, and nothing is written, where
    /// the kernel does not suit the position, does not get there, or a number is not finite.
    fn project(&self, t: f64, residual: f64, state: StateMut) -> Option<ProjectionResult> {
        let _ = (t, residual, state);
        None
    }

    /// A step of the Dormand-Prince pair of order 8 from a state on the constraints, its end projected onto them in the
    /// mass metric. `None` where the kernel does not suit a position, or a number is not finite, or the processor has
    /// no fused products.
    fn dop853_step(&self, request: &StepRequest, from: &StateRef, step: StepMut) -> Option<StepEstimate> {
        let _ = (request, from, step);
        None
    }

    /// Steps of the Gauss method by vectors of that width; `None` where there is no kernel for them.
    #[cfg(feature = "simd")]
    fn gauss_steps(&self, width: Width) -> Option<Box<dyn GaussSteps>> {
        let _ = width;
        None
    }

    /// Rows by steps of [`rk4_step`](crate::rk4_step) from the state in the first row of `rows` on, until there is room
    /// for no more, the end comes, the event occurs, or a step cannot be relied on.
    fn integrate_rk4(&self, request: &RowRequest, rows: &mut [f64]) -> RowResult {
        let _ = (request, rows);
        RowResult { rows_written: 0, reason: None }
    }
}

/// A state of a mechanism.
#[derive(Clone, Copy, Debug)]
pub struct StateRef<'a> {
    /// Time.
    pub t: f64,
    /// Coordinates, `n`.
    pub q: &'a [f64],
    /// Rates, `n`.
    pub qd: &'a [f64],
    /// Accelerations, `n`.
    pub qdd: &'a [f64],
    /// Multipliers, `m`.
    pub multipliers: &'a [f64],
}

/// Energy and power in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowQuantities {
    /// See [`Mechanism::energy`].
    pub energy: [f64; 2],
    /// See [`Mechanism::power`].
    pub power: f64,
}

/// The quantities of a row by the functions of a mechanism, one after another.
#[inline(always)]
fn row_quantities<X: Mechanism + ?Sized>(
    mechanism: &X,
    at: &StateRef,
    outputs: &mut [f64],
    constraints: LoopConstraintsMut,
) -> RowQuantities {
    let StateRef { t, q, qd, qdd, multipliers } = *at;
    mechanism.outputs(t, q, qd, qdd, multipliers, outputs);
    mechanism.loop_constraints(t, q, constraints);
    RowQuantities { energy: mechanism.energy(q, qd), power: mechanism.power(t, q, qd, qdd, multipliers) }
}

/// Room for the start of a motion: some values are given, the others are first guesses (rates: unused) until they are
/// solved for.
#[derive(Debug)]
pub struct StartMut<'a> {
    /// Coordinates.
    pub q: &'a mut [f64],
    /// For each coordinate, whether it is given.
    pub given: &'a mut [bool],
    /// Rates.
    pub qd: &'a mut [f64],
    /// For each rate, whether it is given.
    pub given_rates: &'a mut [bool],
}

/// Room for the parts of the equations of motion: see [`Dynamics`](crate::Dynamics).
#[derive(Debug)]
pub struct DynamicsMut<'a> {
    /// Mbar, `n` by `n`.
    pub mass_matrix: &'a mut [f64],
    /// fbar, `n`.
    pub generalized_forces: &'a mut [f64],
    /// C_q, `m` by `n`.
    pub constraint_jacobian: &'a mut [f64],
    /// `m`.
    pub constraint_bias: &'a mut [f64],
}

/// Room for the loop constraints: see [`LoopConstraints`](crate::LoopConstraints).
#[derive(Debug)]
pub struct LoopConstraintsMut<'a> {
    /// C, `m`.
    pub residuals: &'a mut [f64],
    /// C_q, `m` by `n`.
    pub constraint_jacobian: &'a mut [f64],
    /// C_t, `m`.
    pub constraint_rate: &'a mut [f64],
}

/// Room for the derivatives of the equations of motion: see [`Linearization`](crate::Linearization).
#[derive(Debug)]
pub struct LinearizationMut<'a> {
    /// `n` by `n`.
    pub stiffness: &'a mut [f64],
    /// `n` by `n`.
    pub damping: &'a mut [f64],
    /// `m` by `n`.
    pub constraint_stiffness: &'a mut [f64],
    /// `m` by `n`.
    pub constraint_damping: &'a mut [f64],
    /// `n`.
    pub forcing: &'a mut [f64],
    /// `m`.
    pub constraint_forcing: &'a mut [f64],
}

/// A generated mechanism with its parameters.
#[derive(Debug)]
pub struct Compiled<X: Generated<N, M>, const N: usize, const M: usize, V> {
    kernel: X::Kernel<f64>,
    /// The kernel on numbers with fused products, once steps need it.
    #[cfg(feature = "simd")]
    fused: std::sync::OnceLock<X::Kernel<Fused>>,
    values: V,
    generated: PhantomData<fn() -> X>,
}

impl<X: Generated<N, M>, const N: usize, const M: usize, V: AsRef<[f64]>> Compiled<X, N, M, V> {
    /// The mechanism with these values of its parameters, in the order of the description.
    #[inline]
    pub fn new(values: V) -> Self {
        let kernel = X::Kernel::<f64>::with_values(&|i| values.as_ref()[i]);
        Self {
            kernel,
            #[cfg(feature = "simd")]
            fused: std::sync::OnceLock::new(),
            values,
            generated: PhantomData,
        }
    }

    #[cfg(feature = "simd")]
    #[inline]
    fn fused(&self) -> &X::Kernel<Fused> {
        self.fused.get_or_init(|| X::Kernel::<Fused>::with_values(&|i| Fused(self.values.as_ref()[i])))
    }
}

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

    #[cfg(feature = "simd")]
    #[inline]
    fn model(&self) -> Option<Model> {
        Some(Model::from_generated::<X, N, M>())
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
        // Where sines and cosines of these are shared, the compiler must see that what is written leaves them alone.
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
        crate::gauss::gauss_steps::<X, N, M>(self.values.as_ref(), width)
    }

    #[inline]
    fn integrate_rk4(&self, request: &RowRequest, rows: &mut [f64]) -> RowResult {
        // Straight-line steps of a large kernel would be compiled twice.
        #[cfg(feature = "simd")]
        if const { X::Kernel::<f64>::OPERATIONS <= Fused::INLINE_LIMIT }
            && let Some(result) = Fused::vectorize_widest(
                #[inline(always)]
                || integrate_rk4(self.fused(), request, rows),
            )
        {
            return result;
        }
        integrate_rk4(&self.kernel, request, rows)
    }
}
