//! The equations of motion of a mechanism: the interface between generated code and simulators.
//!
//! Generated code implements [`Kernel`] and [`Generated`], with sizes known at compile time. A simulator uses
//! [`Mechanism`], plain functions over slices; a program lists its mechanisms as [`Model`]s. Time-critical parts are
//! compiled for each mechanism: rows by [`rk4_step`] and motions in lanes.
//!
//! With `q` the generalized coordinates and `C(q) = 0` the loop constraints:
//!
//! ```text
//! | Mbar  C_q' | | qdd    |   | fbar           |
//! | C_q   0    | | lambda | = | -(C_q qd)_q qd |
//! ```
//!
//! Constraints may depend on time, `C(q, t) = 0`: then `C_q qd + C_t = 0`, and `(C_q qd)_q qd + 2 C_qt qd + C_tt`
//! replaces `(C_q qd)_q qd`.

#![no_std]

#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("qrm-core needs one of its features: `std`, or `libm` where there is no standard library");

mod angles;
#[cfg(feature = "simd")]
mod batch;
mod buffers;
mod compiled;
#[cfg(feature = "std")]
mod derived;
mod description;
mod digest;
#[cfg(feature = "simd")]
pub mod dop853;
// Only the coefficients are public.
#[cfg(not(feature = "simd"))]
#[path = "dop853/coefficients.rs"]
pub mod dop853;
mod double_double;
#[cfg(feature = "dual")]
mod dual;
#[cfg(feature = "simd")]
mod gauss;
#[cfg(feature = "simd")]
mod interpreted;
mod interval;
mod kernel;
mod kernel_state;
#[cfg(feature = "std")]
pub mod lane_layout;
#[cfg(feature = "simd")]
mod lane_steps;
#[cfg(feature = "simd")]
mod lanes;
mod math;
mod mechanism;
#[cfg(feature = "simd")]
mod model;
#[cfg(feature = "std")]
pub mod named_tape;
mod projection;
mod rk4;
mod rows;
mod scalar;
mod sine;
mod single_step;
mod step_end;
mod stored_tape;
#[cfg(feature = "std")]
mod tape;
mod vectors;
#[cfg(feature = "simd")]
mod width;

pub use angles::Angles;
#[cfg(feature = "simd")]
pub use batch::{Batch, LaneSchedule};
pub use buffers::{DynamicsMut, LinearizationMut, LoopConstraintsMut, RowQuantities, StartMut, StateRef};
pub use compiled::{Compiled, Generated, LaneStepsTable};
#[cfg(feature = "simd")]
pub use compiled::{eight_lanes, four_lanes};
#[cfg(feature = "std")]
pub use derived::{DERIVING, DerivedScene, OwnedDescription, OwnedParameter, OwnedQuantity, WAITING};
pub use description::{Description, ParameterDescription, QuantityDescription};
pub use digest::digest;
pub use double_double::DoubleDouble;
#[cfg(feature = "dual")]
pub use dual::{Dual, DualKind};
#[cfg(feature = "simd")]
pub use gauss::{Convergence, GAUSS_NODES, GaussEnd, GaussEstimate, GaussRequest, GaussSteps};
pub use interval::Interval;
pub use kernel::{
    Dynamics, Equations, Kernel, Linearization, LoopConstraints, MAX_GROWTH, Schedule, Start, copy_outputs,
    mass_matrix_from_momenta,
};
pub use kernel_state::{KernelState, StepResult};
#[cfg(feature = "std")]
pub use lane_layout::{BatchRequest, CHECKPOINTS};
#[cfg(feature = "simd")]
pub use lane_steps::{BoxedLaneSteps, LaneSteps};
pub use mechanism::Mechanism;
#[cfg(feature = "simd")]
pub use model::{Model, ParameterOverrides};
#[cfg(feature = "std")]
pub use named_tape::NamedTape;
pub use projection::{ProjectionResult, StateMut};
pub use rk4::rk4_step;
pub use rows::{RowLayout, RowRequest, RowResult, StopReason};
pub use scalar::{Fused, Scalar};
pub use sine::sin_cos;
pub use single_step::{StepEstimate, StepMut, StepRequest};
pub use step_end::{CORRECTION_ROUNDING, MAX_CORRECTIONS, RESIDUAL_ROUNDING};
pub use stored_tape::StoredTape;
#[cfg(feature = "std")]
pub use tape::{Obstacle, Operation, Tape, TapeEvaluator, TapeFunction, TapeKernel, TapeSeries, execute};
#[cfg(feature = "simd")]
pub use width::Width;

/// Lists mechanisms as a program's `MODELS`: `MODULE::MECHANISM, COORDINATES, CONSTRAINTS;` for a compiled one,
/// `interpreted MODULE;` for an interpreted one. The list needs the feature `simd`.
#[cfg(feature = "simd")]
#[macro_export]
macro_rules! models {
    (@list [$($model:expr,)*]) => {
        /// All mechanisms, in the order of the scene files.
        pub static MODELS: &[$crate::Model] = &[$($model),*];
    };
    (@list [$($model:expr,)*] interpreted $module:ident; $($rest:tt)*) => {
        $crate::models! {
            @list [$($model,)* $crate::Model::interpreted(&$module::DESCRIPTION, &$module::TAPE),] $($rest)*
        }
    };
    (@list [$($model:expr,)*] $mechanism:ty, $n:literal, $m:literal; $($rest:tt)*) => {
        $crate::models! { @list [$($model,)* $crate::Model::from_generated::<$mechanism, $n, $m>(),] $($rest)* }
    };
    ($($list:tt)*) => {
        $crate::models! { @list [] $($list)* }
    };
}

/// Does nothing without the feature `simd`.
#[cfg(not(feature = "simd"))]
#[macro_export]
macro_rules! models {
    ($($list:tt)*) => {};
}

/// Defines `LANE_STEPS`, for [`Generated::LANE_STEPS`], in the module of a mechanism:
/// `lane_steps!(MECHANISM, COORDINATES, CONSTRAINTS)`. Without the feature `simd` it is `()`.
///
/// The steps of each number of lanes have their own module. rustc makes codegen units of modules, so they compile in
/// parallel with the rest of the mechanism.
#[cfg(feature = "simd")]
#[macro_export]
macro_rules! lane_steps {
    ($mechanism:ident, $n:literal, $m:literal) => {
        mod four_lanes {
            pub(super) fn steps(request: $crate::BatchRequest, residual: f64) -> Option<$crate::BoxedLaneSteps> {
                $crate::four_lanes::<super::$mechanism, $n, $m>(request, residual)
            }
        }

        mod eight_lanes {
            pub(super) fn steps(request: $crate::BatchRequest, residual: f64) -> Option<$crate::BoxedLaneSteps> {
                $crate::eight_lanes::<super::$mechanism, $n, $m>(request, residual)
            }
        }

        const LANE_STEPS: $crate::LaneStepsTable = [four_lanes::steps, eight_lanes::steps];
    };
}

/// Defines `LANE_STEPS` as `()`.
#[cfg(not(feature = "simd"))]
#[macro_export]
macro_rules! lane_steps {
    ($mechanism:ident, $n:literal, $m:literal) => {
        const LANE_STEPS: $crate::LaneStepsTable = ();
    };
}
