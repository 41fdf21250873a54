//! A step of one motion by a kernel, with the instructions of the processor at hand.

#[cfg(feature = "simd")]
pub(crate) mod fused;

use crate::projection::StateMut;

/// A step to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRequest {
    /// Length of the step.
    pub h: f64,
    /// Largest error of the step: of an angle itself, of a length or a rate `x` relative to `1 + |x|`.
    pub tolerance: f64,
    /// Largest residual of a constraint at the end.
    pub residual: f64,
}

/// Room for what a step gives.
#[derive(Debug)]
pub struct StepMut<'a> {
    /// The projected end of the step, without its time.
    pub end: StateMut<'a>,
    /// The largest correction of each coordinate by projections so far, `n`.
    pub corrections: &'a mut [f64],
    /// The higher coefficients of the dense output, those of the coordinates and then those of the rates, `4 n` each;
    /// empty if they are not asked for. What is given for a step with an error above 1 is of no use.
    pub dense: &'a mut [f64],
}

/// The error of a step, and what its projection corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepEstimate {
    /// The estimated error of the step relative to the tolerance: 1 is just accepted; beyond, the end is of no use.
    pub error: f64,
    /// The fastest rate of the motion times the length of the step, roughly.
    pub stiffness: f64,
    /// Largest residual of a constraint before the projection, in its unit.
    pub residual: f64,
    /// How often the projection corrected the coordinates.
    pub corrections: u32,
}
