//! A mechanism by its tape: operations are executed one after another, and nothing is compiled for a scene.
//!
//! They are the operations of the compiled functions, in the same order, so that both give the same numbers. Steps are
//! made by the formulae that compiled functions use too, with `kernel` in their place.

mod kernel;
mod program;

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::buffers::{DynamicsMut, LinearizationMut, LoopConstraintsMut, StartMut, StateRef};
use crate::description::Description;
#[cfg(target_arch = "x86_64")]
use crate::gauss::GaussSteps;
use crate::kernel::{Kernel, Schedule};
use crate::lane_steps::{BatchRequest, BoxedLaneSteps};
use crate::mechanism::Mechanism;
use crate::projection::{ProjectionResult, StateMut, complete};
use crate::rows::{RowRequest, RowResult, integrate_rk4};
use crate::scalar::{Fused, Scalar};
use crate::single_step::{StepEstimate, StepMut, StepRequest, fused};
use crate::tape::{Tape, TapeEvaluator, split};
use crate::width::Width;
use kernel::InterpretedKernel;

/// Calls a function for a mechanism with the least capacity that holds its coordinates and constraints. Numbers up to
/// the capacity are computed with.
macro_rules! with_capacity {
    ($tape:expr, $function:ident($($argument:expr),*)) => {
        match $tape.sizes().into_iter().max() {
            // What a page downloads is small.
            #[cfg(not(target_family = "wasm"))]
            Some(0..=4) => $function::<4>($($argument),*),
            Some(0..=8) => $function::<8>($($argument),*),
            #[cfg(not(target_family = "wasm"))]
            Some(9..=32) => $function::<32>($($argument),*),
            _ => $function::<128>($($argument),*),
        }
    };
}

/// The largest capacity for vectors: the numbers of larger mechanisms leave the processor's cache.
#[cfg(target_arch = "x86_64")]
const LARGEST_IN_LANES: usize = 32;

/// A mechanism by its tape.
pub(crate) fn mechanism(
    description: &'static Description,
    tape: &'static Tape,
    values: Vec<f64>,
) -> Box<dyn Mechanism> {
    with_capacity!(tape, boxed(description, tape, values))
}

fn boxed<const C: usize>(
    description: &'static Description,
    tape: &'static Tape,
    values: Vec<f64>,
) -> Box<dyn Mechanism> {
    Box::new(Interpreted::<C>::new(description, tape, values))
}

/// Steps of a tape in lanes; `None` where the processor has no vectors of that width, or the mechanism is
/// too large.
pub(crate) fn lane_steps(
    mechanism: (&'static Description, &'static Tape),
    width: Width,
    request: BatchRequest,
    residual: f64,
) -> Option<BoxedLaneSteps> {
    with_capacity!(mechanism.1, lane_steps_of(mechanism, width, request, residual))
}

#[cfg(target_arch = "x86_64")]
fn lane_steps_of<const C: usize>(
    (description, tape): (&'static Description, &'static Tape),
    width: Width,
    request: BatchRequest,
    residual: f64,
) -> Option<BoxedLaneSteps> {
    use crate::lane_steps::StepsBy;
    use crate::lanes::Lanes;
    use pulp::x86::{V3, V4};
    // A constant, so that what is not used is not compiled.
    if const { C > LARGEST_IN_LANES } {
        return None;
    }
    Some(match width {
        Width::Four => {
            let token = V3::try_new()?;
            let kernel = InterpretedKernel::<Lanes<V3>, C>::new(tape, description)?;
            Box::new(StepsBy::new(token, kernel, description, request, residual))
        }
        Width::Eight => {
            let token = V4::try_new()?;
            let kernel = InterpretedKernel::<Lanes<V4>, C>::new(tape, description)?;
            Box::new(StepsBy::new(token, kernel, description, request, residual))
        }
    })
}

#[cfg(not(target_arch = "x86_64"))]
fn lane_steps_of<const C: usize>(
    _: (&Description, &Tape),
    _: Width,
    _: BatchRequest,
    _: f64,
) -> Option<BoxedLaneSteps> {
    None
}

/// A mechanism by its tape, with its parameters.
struct Interpreted<const C: usize> {
    description: &'static Description,
    tape: &'static Tape,
    values: Vec<f64>,
    evaluator: Mutex<TapeEvaluator<'static, Vec<f64>>>,
    /// The kernel on doubles, and the one on doubles with fused products; `None` if the mechanism is too large.
    kernel: Option<Mutex<InterpretedKernel<f64, C>>>,
    fused: Option<Mutex<InterpretedKernel<Fused, C>>>,
}

/// Locks a mutex, also after a panic: no function panics with a value half-written that is not written anew.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<const C: usize> Interpreted<C> {
    fn new(description: &'static Description, tape: &'static Tape, values: Vec<f64>) -> Self {
        let evaluator = TapeEvaluator::with_parameters(tape, &values);
        let mut kernel = InterpretedKernel::new(tape, description);
        let mut fused = InterpretedKernel::new(tape, description);
        if let (Some(kernel), Some(fused)) = (&mut kernel, &mut fused) {
            kernel.set_values(&|i| values[i]);
            fused.set_values(&|i| Fused(values[i]));
        }
        let (kernel, fused) = (kernel.map(Mutex::new), fused.map(Mutex::new));
        Self { description, tape, values, evaluator: Mutex::new(evaluator), kernel, fused }
    }

    fn evaluator(&self) -> MutexGuard<'_, TapeEvaluator<'static, Vec<f64>>> {
        lock(&self.evaluator)
    }
}

impl<const C: usize> fmt::Debug for Interpreted<C> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Interpreted").field("values", &self.values).finish_non_exhaustive()
    }
}

/// Copies consecutive parts of results to their places.
fn scatter<const K: usize>(results: &[f64], parts: [&mut [f64]; K]) {
    let lengths = core::array::from_fn(|i| parts[i].len());
    for (part, result) in parts.into_iter().zip(split::<_, K>(results, lengths)) {
        part.copy_from_slice(result);
    }
}

impl<const C: usize> Mechanism for Interpreted<C> {
    fn description(&self) -> &'static Description {
        self.description
    }

    fn parameters(&self) -> &[f64] {
        &self.values
    }

    fn tape(&self) -> Option<&'static Tape> {
        Some(self.tape)
    }

    fn with_parameters(&self, values: Vec<f64>) -> Option<Box<dyn Mechanism>> {
        Some(Box::new(Self::new(self.description, self.tape, values)))
    }

    fn is_driven(&self) -> bool {
        self.tape.is_driven
    }

    fn has_linearization(&self) -> bool {
        self.tape.linearization.is_some()
    }

    fn operations(&self) -> usize {
        self.tape.kernel.operations
    }

    fn start(&self, start: StartMut) {
        self.evaluator().start(start.q, start.qd);
        let (given, given_rates) = self.tape.given.split_at(start.given.len());
        start.given.copy_from_slice(given);
        start.given_rates.copy_from_slice(given_rates);
    }

    fn schedule(&self) -> Schedule<f64> {
        self.evaluator().schedule()
    }

    fn event(&self, at: &StateRef) -> Option<f64> {
        self.evaluator().event(at.t, at.q, at.qd, at.qdd, at.multipliers)
    }

    fn dynamics(&self, t: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut) {
        let mut results = vec![0.0; self.tape.dynamics.results.len()];
        self.evaluator().dynamics(t, q, qd, &mut results);
        let DynamicsMut { mass_matrix, generalized_forces, constraint_jacobian, constraint_bias } = dynamics;
        scatter(&results, [mass_matrix, generalized_forces, constraint_jacobian, constraint_bias]);
    }

    fn loop_constraints(&self, t: f64, q: &[f64], constraints: LoopConstraintsMut) {
        let mut results = vec![0.0; self.tape.loop_constraints.results.len()];
        self.evaluator().loop_constraints(t, q, &mut results);
        let LoopConstraintsMut { residuals, constraint_jacobian, constraint_rate } = constraints;
        scatter(&results, [residuals, constraint_jacobian, constraint_rate]);
    }

    fn mass_matrix(&self, q: &[f64], mass_matrix: &mut [f64]) {
        self.evaluator().mass_matrix(q, mass_matrix);
    }

    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        self.evaluator().energy(q, qd)
    }

    fn power(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64 {
        self.evaluator().power(t, q, qd, qdd, multipliers)
    }

    fn outputs(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]) {
        let mut results = vec![0.0; self.tape.outputs.results.len()];
        self.evaluator().outputs(t, q, qd, qdd, multipliers, &mut results);
        outputs.iter_mut().zip(results).for_each(|(output, result)| *output = result);
    }

    fn linearization(
        &self,
        t: f64,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        multipliers: &[f64],
        linearization: LinearizationMut,
    ) -> bool {
        let Some(function) = &self.tape.linearization else { return false };
        let mut results = vec![0.0; function.results.len()];
        self.evaluator().linearization(t, q, qd, qdd, multipliers, &mut results);
        let LinearizationMut { stiffness, damping, constraint_stiffness, constraint_damping, .. } = linearization;
        let (forcing, constraint_forcing) = (linearization.forcing, linearization.constraint_forcing);
        let parts = [stiffness, damping, constraint_stiffness, constraint_damping, forcing, constraint_forcing];
        scatter(&results, parts);
        true
    }

    fn accelerations(&self, t: f64, q: &[f64], qd: &[f64], qdd: &mut [f64], multipliers: &mut [f64]) -> bool {
        let Some(kernel) = &self.kernel else { return false };
        let (mut q, mut qd) = (q.to_vec(), qd.to_vec());
        let state = StateMut { q: &mut q, qd: &mut qd, qdd, multipliers };
        complete(&*lock(kernel), t, None, state).is_some()
    }

    fn project(&self, t: f64, residual: f64, state: StateMut) -> Option<ProjectionResult> {
        complete(&*lock(self.kernel.as_ref()?), t, Some(residual), state)
    }

    fn dop853_step(&self, request: &StepRequest, from: &StateRef, step: StepMut) -> Option<StepEstimate> {
        let kernel = &*lock(self.fused.as_ref()?);
        Fused::vectorize(
            #[inline(always)]
            || fused::dop853(kernel, request, from, step),
        )?
    }

    #[cfg(target_arch = "x86_64")]
    fn gauss_steps(&self, width: Width) -> Option<Box<dyn GaussSteps>> {
        use crate::gauss::Steps;
        use crate::lanes::Lanes;
        use pulp::x86::{V3, V4};
        if const { C > LARGEST_IN_LANES } {
            return None;
        }
        let (description, tape) = (self.description, self.tape);
        Some(match width {
            Width::Four => {
                let token = V3::try_new()?;
                let mut kernel = InterpretedKernel::<Lanes<V3>, C>::new(tape, description)?;
                kernel.set_values(&|i| Lanes::from_f64(self.values[i]));
                Box::new(Steps::new(token, kernel))
            }
            Width::Eight => {
                let token = V4::try_new()?;
                let mut kernel = InterpretedKernel::<Lanes<V4>, C>::new(tape, description)?;
                kernel.set_values(&|i| Lanes::from_f64(self.values[i]));
                Box::new(Steps::new(token, kernel))
            }
        })
    }

    fn integrate_rk4(&self, request: &RowRequest, rows: &mut [f64]) -> RowResult {
        let (Some(kernel), Some(fused)) = (&self.kernel, &self.fused) else {
            return RowResult { rows_written: 0, reason: None };
        };
        // The same numbers as a compiled kernel has.
        if self.operations() <= Fused::INLINE_LIMIT {
            let fused = &*lock(fused);
            let rows = &mut *rows;
            if let Some(result) = Fused::vectorize(
                #[inline(always)]
                || integrate_rk4(fused, request, rows),
            ) {
                return result;
            }
        }
        integrate_rk4(&*lock(kernel), request, rows)
    }
}
