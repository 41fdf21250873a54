//! The formulae of steps, for repeating the steps of a run on other numbers.

use super::method::Method;
use super::step_formula::Accepted;
use super::tableau::Tableau;
use super::{GAUSS, RK4};

/// A formula, with the data needed to repeat its steps.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Formula {
    /// An explicit Runge-Kutta method.
    Explicit(&'static Tableau),
    /// RODAS.
    Rosenbrock,
    /// The Gauss method.
    Gauss,
}

impl Formula {
    /// The formula of an accepted step of a method.
    pub(super) fn new(method: &Method, step: &Accepted) -> Self {
        match method.tableau {
            _ if method == GAUSS && !step.is_fallback => Self::Gauss,
            Some(tableau) if !step.is_implicit => Self::Explicit(tableau),
            _ => Self::Rosenbrock,
        }
    }

    /// The formula of steps of a fixed length.
    pub(crate) fn fixed() -> Self {
        Self::new(RK4, &Accepted::default())
    }
}
