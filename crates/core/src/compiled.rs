//! Compiled mechanisms: generated equations of motion with parameters, and their steps in vectors.

mod mechanism;

#[cfg(feature = "std")]
extern crate alloc;

#[cfg(feature = "std")]
use alloc::{boxed::Box, vec::Vec};
use core::marker::PhantomData;

use crate::description::Description;
use crate::kernel::Equations;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::kernel::Kernel;
#[cfg(feature = "simd")]
use crate::lane_layout::BatchRequest;
#[cfg(feature = "simd")]
use crate::lane_steps::BoxedLaneSteps;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::lane_steps::{StepsBy, suits};
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::lanes::Lanes;
#[cfg(feature = "std")]
use crate::mechanism::Mechanism;
#[cfg(feature = "simd")]
use crate::scalar::Fused;
use crate::scalar::Scalar;
use crate::stored_tape::StoredTape;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::width::Width;

/// A generated mechanism, generic over the number type.
pub trait Generated<const N: usize, const M: usize>: 'static {
    /// The equations of motion of the mechanism.
    type Kernel<R: Scalar>: Equations<R, N, M> + Copy + Send + Sync + 'static;

    /// Names, units and meanings.
    const DESCRIPTION: &'static Description;

    /// The functions as data, for any kind of number.
    const TAPE: &'static StoredTape;

    /// Whether [`Equations::linearization`] gives derivatives.
    const HAS_LINEARIZATION: bool = false;

    /// Whether constraints depend on time.
    const IS_DRIVEN: bool = false;

    /// The steps of the mechanism in four and in eight lanes: see [`lane_steps!`](crate::lane_steps).
    const LANE_STEPS: LaneStepsTable;

    /// The mechanism with these values of its parameters, in the order of the description.
    ///
    /// The method is compiled with the module of its mechanism, and everything it calls is inline. If one mechanism
    /// changes, the others are not recompiled.
    #[cfg(feature = "std")]
    fn mechanism(values: Vec<f64>) -> Box<dyn Mechanism>
    where
        Self: Sized,
    {
        Box::new(Compiled::<Self, N, M, Vec<f64>>::new(values))
    }
}

#[cfg(feature = "simd")]
/// Constructors of [`LaneSteps`](crate::LaneSteps) for four and for eight lanes, with the largest residual of a
/// constraint after a reliable step; `None` where the processor has no vectors of that width, or the kernel is too
/// large for them.
pub type LaneStepsTable = [fn(BatchRequest, f64) -> Option<BoxedLaneSteps>; 2];

/// The constructors of steps in lanes; none without `simd`.
#[cfg(not(feature = "simd"))]
pub type LaneStepsTable = ();

/// The steps of a generated mechanism in four lanes: see [`LaneStepsTable`].
#[cfg(feature = "simd")]
#[inline]
pub fn four_lanes<X: Generated<N, M>, const N: usize, const M: usize>(
    request: BatchRequest,
    residual: f64,
) -> Option<BoxedLaneSteps> {
    // A constant condition, so that unused code is not compiled.
    #[cfg(target_arch = "x86_64")]
    if const { suits(Width::Four, X::Kernel::<f64>::OPERATIONS) } {
        let token = pulp::x86::V3::try_new()?;
        let kernel = X::Kernel::<Lanes<pulp::x86::V3>>::with_values(&|_| Lanes::zero());
        return Some(Box::new(StepsBy::new(token, kernel, X::DESCRIPTION, request, residual)));
    }
    let _ = (request, residual);
    None
}

/// The steps of a generated mechanism in eight lanes: see [`LaneStepsTable`].
#[cfg(feature = "simd")]
#[inline]
pub fn eight_lanes<X: Generated<N, M>, const N: usize, const M: usize>(
    request: BatchRequest,
    residual: f64,
) -> Option<BoxedLaneSteps> {
    #[cfg(target_arch = "x86_64")]
    if const { suits(Width::Eight, X::Kernel::<f64>::OPERATIONS) } {
        let token = pulp::x86::V4::try_new()?;
        let kernel = X::Kernel::<Lanes<pulp::x86::V4>>::with_values(&|_| Lanes::zero());
        return Some(Box::new(StepsBy::new(token, kernel, X::DESCRIPTION, request, residual)));
    }
    let _ = (request, residual);
    None
}

/// A generated mechanism with its parameters.
#[derive(Debug)]
pub struct Compiled<X: Generated<N, M>, const N: usize, const M: usize, V> {
    kernel: X::Kernel<f64>,
    /// The kernel on numbers with fused products, created at the first step that needs it.
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
