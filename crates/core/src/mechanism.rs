//! A mechanism as simulators see it: plain functions over slices, independent of its size.

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

/// The equations of motion of a mechanism with `n` coordinates and `m` constraints. A mechanism holds its parameters.
///
/// Vectors of coordinates have `n` entries, those of constraints `m`; matrices are flat, row by row. A slice of another
/// length is an error of the caller and panics. All numbers are in SI units, angles in radians.
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

    /// Creates the mechanism with these values of its parameters, in the order of the description; `None` if it is not
    /// generated.
    #[cfg(feature = "std")]
    fn with_parameters(&self, values: Vec<f64>) -> Option<Box<dyn Mechanism>> {
        let _ = values;
        None
    }

    /// Whether constraints depend on time.
    fn is_driven(&self) -> bool;

    /// Whether [`linearization`](Self::linearization) gives derivatives, which are then generated.
    fn has_linearization(&self) -> bool {
        false
    }

    /// The number of operations of the kernel for accelerations and multipliers.
    fn operations(&self) -> usize;

    /// The start of the motion.
    fn start(&self, start: StartMut);

    /// The step length and the end of the motion.
    fn schedule(&self) -> Schedule<f64>;

    /// A value that rises through zero when the scene's stop condition becomes true; `None` if there is no such
    /// condition.
    fn event(&self, at: &StateRef) -> Option<f64>;

    /// The parts of the equations of motion.
    fn dynamics(&self, t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut);

    /// The constraints, their Jacobian and their derivative with respect to time.
    fn loop_constraints(&self, t: f64, q: &[f64], constraints: LoopConstraintsMut);

    /// The reduced mass matrix `Mbar`, `n` by `n`.
    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]);

    /// The kinetic energy and the potential of the conservative loads, in J.
    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2];

    /// The power, in W, of the loads without a potential and of the driven constraints.
    fn power(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64;

    /// Computes the outputs in the order of the description, as many as fit into `outputs`.
    fn outputs(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]);

    /// Computes the quantities of a trajectory's row, which share sines and cosines: outputs, constraints, energy and
    /// power.
    fn row_quantities(&self, at: &StateRef, outputs: &mut [f64], constraints: LoopConstraintsMut) -> RowQuantities {
        row_quantities(self, at, outputs, constraints)
    }

    /// Computes the derivatives of the equations of motion with respect to the state. If the scene does not ask for
    /// them, returns false and writes nothing.
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

    /// Computes accelerations and multipliers by the kernel; false where it is not valid at the position, or a number
    /// is not finite. Without a kernel, steps use the plain functions.
    fn accelerations(&self, t: f64, q: &[f64], qd: &[f64], qdd: &mut [f64], multipliers: &mut [f64]) -> bool {
        let _ = (t, q, qd, qdd, multipliers);
        false
    }

    /// Projects coordinates and rates onto the constraints at time `t` in the mass metric by the kernel, up to a
    /// `residual`, and computes accelerations and multipliers. Returns `None` and writes nothing where the kernel is
    /// not valid at the position, the projection does not converge, or a number is not finite.
    fn project(&self, t: f64, residual: f64, state: StateMut) -> Option<ProjectionResult> {
        let _ = (t, residual, state);
        None
    }

    /// Makes a step of the Dormand-Prince pair of order 8 from a state on the constraints, and projects its end onto
    /// them in the mass metric. Returns `None` where the kernel is not valid at a position, a number is not finite, or
    /// the processor has no fused products.
    fn dop853_step(&self, request: &StepRequest, from: &StateRef, step: StepMut) -> Option<StepEstimate> {
        let _ = (request, from, step);
        None
    }

    /// Steps of the Gauss method with vectors of this width; `None` where there is no kernel for them.
    #[cfg(feature = "simd")]
    fn gauss_steps(&self, width: Width) -> Option<Box<dyn GaussSteps>> {
        let _ = width;
        None
    }

    /// Fills `rows` by steps of [`rk4_step`](crate::rk4_step) from the state in the first row. It stops when `rows` is
    /// full, the end or the event is reached, or a step is unreliable.
    fn integrate_rk4(&self, request: &RowRequest, rows: &mut [f64]) -> RowResult {
        let _ = (request, rows);
        RowResult { rows_written: 0, reason: None }
    }
}

/// Computes the quantities of a row by calling the functions of a mechanism one after another.
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
