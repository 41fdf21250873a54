//! The coefficients of an explicit Runge-Kutta method.

use qrm_core::dop853::Row;

/// An explicit Runge-Kutta method, with its error estimate and dense output if it has them.
#[derive(Debug)]
pub(crate) struct Tableau {
    /// The number of stages of a step; the accelerations at its end are one stage more.
    pub(crate) stages: usize,
    /// Order of the step.
    pub(crate) order: i32,
    /// The exponent of the previous error in the PI control of the step length.
    pub(crate) beta: f64,
    /// The fraction of the step at which each stage is evaluated.
    pub(crate) nodes: &'static [f64],
    /// The coefficients of each stage's argument; rows after the step's own serve the dense output.
    pub(crate) rows: &'static [Row],
    /// The coefficients of the end of the step.
    pub(crate) weights: Row,
    /// The coefficients of the error estimates, one or two.
    pub(crate) errors: &'static [Row],
    /// The higher coefficients of the dense output; empty if a polynomial of degree 5 through both ends suffices.
    pub(crate) dense: &'static [Row],
    /// Computes the error from the sums of squares of the scaled estimates, the number of coordinates and rates, and
    /// the step length. An error of 1 is just accepted.
    pub(crate) error: fn([f64; 2], f64, f64) -> f64,
}
