//! Steps of the Gauss method of order 16 by a kernel, with its eight nodes in the lanes of vectors.

#[cfg(target_arch = "x86_64")]
mod at_nodes;
mod coefficients;
#[cfg(target_arch = "x86_64")]
mod steps;

extern crate alloc;

use alloc::boxed::Box;

#[cfg(target_arch = "x86_64")]
pub(crate) use steps::Steps;

use crate::buffers::StateRef;

/// The number of nodes of a step.
pub const GAUSS_NODES: usize = 8;

/// Steps of one motion by the Gauss method: collocation at the zeros of the Legendre polynomial of degree 8, solved by
/// fixed-point iteration of all nodes at once.
///
/// The iteration of a step begins with the extrapolated polynomial of the step before.
pub trait GaussSteps: core::fmt::Debug + Send {
    /// Makes a step; its end is not projected. Returns `None` where the kernel is not valid at a position, or a number
    /// is not finite.
    fn step(&mut self, request: &GaussRequest, from: &StateRef, end: GaussEnd) -> Option<GaussEstimate>;

    /// Copies the steps into a new box.
    fn boxed_clone(&self) -> Box<dyn GaussSteps>;
}

impl Clone for Box<dyn GaussSteps> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// A request for a step of the Gauss method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussRequest {
    /// Length of the step.
    pub h: f64,
    /// Largest error of a step: absolute for an angle, relative to `1 + |x|` for a length or a rate `x`.
    pub tolerance: f64,
    /// Whether the step is a shorter one from the same state as the last step, directly after it. The next step still
    /// continues from the last step.
    pub is_within_last_step: bool,
}

/// The end of a step of the Gauss method.
#[derive(Debug)]
pub struct GaussEnd<'a> {
    /// The coordinates there.
    pub q: &'a mut [f64],
    /// The rates there.
    pub qd: &'a mut [f64],
    /// The accelerations of the polynomial, extrapolated to the beginning and to the end of the step, where there are
    /// no nodes.
    pub extrapolated: [&'a mut [f64]; 2],
}

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convergence {
    /// The iteration converged.
    Converged,
    /// The iteration was stopped early: the error is far too large.
    TooLong,
    /// The iteration did not converge, or converged too slowly.
    Diverged,
}

/// The error of a step of the Gauss method, and the course of the iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussEstimate {
    /// The estimated error of the step relative to the tolerance. Up to 1 the step is accepted; above, the end is
    /// meaningless.
    pub error: f64,
    /// The outcome of the iteration.
    pub convergence: Convergence,
    /// The number of evaluations of all nodes.
    pub iterations: u32,
    /// The work, in J, of the loads without a potential and of the driven constraints.
    pub work: f64,
}
