//! The face of a mechanism to a simulator: plain functions over slices, whatever its size.

#[cfg(feature = "std")]
extern crate alloc;

#[cfg(feature = "std")]
use alloc::{boxed::Box, vec::Vec};

use crate::buffers::{DynamicsMut, LinearizationMut, LoopConstraintsMut, RowQuantities, StartMut, StateRef};
use crate::description::Description;
#[cfg(feature = "simd")]
use crate::gauss::GaussSteps;
use crate::kernel::Schedule;
use crate::projection::{ProjectionResult, StateMut};
use crate::rows::{RowRequest, RowResult};
use crate::single_step::{StepEstimate, StepMut, StepRequest};
#[cfg(feature = "std")]
use crate::tape::Tape;
#[cfg(feature = "simd")]
use crate::width::Width;

/// The equations of motion of a mechanism with `n` coordinates and `m` constraints, its parameters inside.
///
/// Vectors of coordinates have `n` entries, those of constraints `m`; matrices are flat, row after row. A slice of
/// another length is a mistake of the caller and panics. All numbers are in SI units, angles in radians.
pub trait Mechanism: Send + Sync {
    /// Names, units and meanings.
    fn description(&self) -> &'static Description;

    /// The values of the parameters, in the order of the description.
    fn parameters(&self) -> &[f64];

    /// The functions as data, for any kind of number; `None` if the mechanism is not generated.
    #[cfg(feature = "std")]
    fn tape(&self) -> Option<&'static Tape> {
        None
    }

    /// The mechanism with these values of its parameters, in the order of the description; `None` if it is not
    /// generated.
    #[cfg(feature = "std")]
    fn with_parameters(&self, values: Vec<f64>) -> Option<Box<dyn Mechanism>> {
        let _ = values;
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

/// The quantities of a row by the functions of a mechanism, one after another.
#[inline(always)]
pub(crate) fn row_quantities<X: Mechanism + ?Sized>(
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
