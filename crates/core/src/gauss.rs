//! Steps of the Gauss method of order 16 by a kernel, its eight nodes in the lanes of vectors.

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

/// Nodes of a step.
pub const GAUSS_NODES: usize = 8;

/// Steps of one motion by the Gauss method: collocation at the zeros of the Legendre polynomial of degree 8, solved by
/// fixed-point iteration, all nodes at once.
///
/// A step begins its iteration from the polynomial of the step before.
pub trait GaussSteps: core::fmt::Debug + Send {
    /// A step from a state to its end, which is not projected. `None` where the kernel does not suit a position, or a
    /// number is not finite.
    fn step(&mut self, request: &GaussRequest, from: &StateRef, end: GaussEnd) -> Option<GaussEstimate>;

    /// A copy.
    fn boxed_clone(&self) -> Box<dyn GaussSteps>;
}

impl Clone for Box<dyn GaussSteps> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// A step of the Gauss method to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussRequest {
    /// Length of the step.
    pub h: f64,
    /// Largest error of a step: of an angle itself, of a length or a rate `x` relative to `1 + |x|`.
    pub tolerance: f64,
    /// Whether it is a shorter step from the same state as the last one, directly after it. The next step goes on from
    /// the last one all the same.
    pub is_inside: bool,
}

/// The end of a step of the Gauss method.
#[derive(Debug)]
pub struct GaussEnd<'a> {
    /// The coordinates there.
    pub q: &'a mut [f64],
    /// The rates there.
    pub qd: &'a mut [f64],
    /// The accelerations of the polynomials at the beginning and at the end, where no nodes are.
    pub extrapolated: [&'a mut [f64]; 2],
}

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convergence {
    /// The iteration converged.
    Converged,
    /// The iteration was given up early: the error is far too large.
    TooLong,
    /// The iteration did not converge, or too slowly.
    Diverged,
}

/// The error of a step of the Gauss method, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussEstimate {
    /// The estimated error of the step relative to the tolerance: 1 is just accepted; beyond, the end is of no use.
    pub error: f64,
    /// How the iteration ended.
    pub convergence: Convergence,
    /// How often all nodes were evaluated.
    pub iterations: u32,
    /// The work of the loads that have no potential, and of what drives the constraints, in J.
    pub work: f64,
}
