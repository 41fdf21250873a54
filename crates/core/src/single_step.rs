//! A step of one motion by a kernel, with the instructions that the processor has.

#[cfg(feature = "simd")]
pub(crate) mod fused;

use crate::projection::StateMut;

/// A request for a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRequest {
    /// Length of the step.
    pub h: f64,
    /// Largest error of the step: absolute for an angle, relative to `1 + |x|` for a length or a rate `x`.
    pub tolerance: f64,
    /// Largest residual of a constraint at the end.
    pub residual: f64,
}

/// Buffers for the result of a step.
#[derive(Debug)]
pub struct StepMut<'a> {
    /// The projected end of the step, without its time.
    pub end: StateMut<'a>,
    /// The largest correction of each coordinate by projections so far, `n`.
    pub corrections: &'a mut [f64],
    /// The higher coefficients of the dense output, `4 n` for the coordinates and `4 n` for the rates; empty if they
    /// are not wanted. They are meaningless if the error of the step is above 1.
    pub dense: &'a mut [f64],
}

/// The error of a step, and the corrections by its projection.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepEstimate {
    /// The estimated error of the step relative to the tolerance. Up to 1 the step is accepted; above, the end is
    /// meaningless.
    pub error: f64,
    /// An estimate of the fastest rate of the motion times the length of the step.
    pub stiffness: f64,
    /// Largest residual of a constraint before the projection, in its unit.
    pub residual: f64,
    /// The number of corrections of the coordinates.
    pub corrections: u32,
}
