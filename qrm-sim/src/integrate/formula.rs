//! The formulae of steps, for whoever makes steps of a run again on other numbers.

use super::adaptive::Accepted;
use super::method::Method;
use super::tableau::Tableau;
use super::{DOPRI5, GAUSS, RK4};
use super::{classical, dop853, dopri5};

/// The formula of a step.
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
    pub(super) fn of(method: &Method, step: &Accepted) -> Self {
        if step.is_implicit {
            Self::Rosenbrock
        } else if method == GAUSS && !step.is_fallback {
            Self::Gauss
        } else if method == RK4 {
            Self::Explicit(&classical::CLASSICAL)
        } else if method == DOPRI5 {
            Self::Explicit(&dopri5::TABLEAU)
        } else {
            Self::Explicit(&dop853::TABLEAU)
        }
    }

    /// The formula of steps of a fixed length.
    pub(crate) fn fixed() -> Self {
        Self::of(RK4, &Accepted::default())
    }
}
