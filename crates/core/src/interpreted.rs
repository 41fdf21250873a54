//! A mechanism by its tape: operations are executed one after another, and nothing is compiled for a scene.
//!
//! They are the operations of the compiled functions, in the same order, so that both give the same numbers. Steps are
//! made by the formulae that compiled functions use too, with `kernel` in their place.

mod kernel;
mod mechanism;

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::description::Description;
use crate::kernel::Kernel;
use crate::lane_layout::BatchRequest;
use crate::lane_steps::BoxedLaneSteps;
use crate::mechanism::Mechanism;
use crate::scalar::Fused;
use crate::tape::{Tape, TapeEvaluator};
use crate::width::Width;
use kernel::InterpretedKernel;

/// Calls a function for a mechanism with the least capacity that holds its coordinates and constraints. Numbers up to
/// the capacity are computed with. Larger mechanisms have no kernel: their equations are solved with full matrices.
macro_rules! with_capacity {
    ($tape:expr, $function:ident($($argument:expr),*)) => {
        match $tape.sizes().into_iter().max() {
            // What a page downloads is small.
            #[cfg(not(target_family = "wasm"))]
            Some(0..=4) => $function::<4>($($argument),*),
            Some(0..=8) => $function::<8>($($argument),*),
            #[cfg(not(target_family = "wasm"))]
            Some(9..=32) => $function::<32>($($argument),*),
            #[cfg(not(target_family = "wasm"))]
            Some(129..=256) => $function::<256>($($argument),*),
            #[cfg(not(target_family = "wasm"))]
            Some(257..) => $function::<1024>($($argument),*),
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
