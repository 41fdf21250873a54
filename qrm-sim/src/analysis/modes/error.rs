//! Why there is no equilibrium, or no linear model.

use crate::position::NotAssembled;

/// Why there is no equilibrium, or no linear model about it.
#[derive(Clone, Debug)]
pub enum NoModes {
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
    /// A constraint depends on time: the mechanism is moved.
    Driven,
    /// The constraints leave no degree of freedom.
    NoFreedom,
    /// Some constraints repeat others.
    Redundant {
        /// The number of independent constraints.
        rank: usize,
    },
    /// The position is singular: the constraints do not say which motions they allow.
    Singular {
        /// The coordinates.
        q: Vec<f64>,
    },
    /// A motion that the constraints allow has no inertia.
    Massless {
        /// The coordinates.
        q: Vec<f64>,
    },
    /// Loads, masses or their derivatives are not finite.
    NotFinite {
        /// The coordinates.
        q: Vec<f64>,
    },
    /// The search ended without an equilibrium.
    NotFound {
        /// The nearest position.
        q: Vec<f64>,
        /// An independent coordinate there.
        coordinate: usize,
        /// The generalized force on it that is not balanced, the largest one of all.
        residual: f64,
    },
    /// The eigenvalues cannot be computed.
    NoEigenvalues,
    /// An input changes the constraints or the masses, so that its rates would matter.
    NotALoad {
        /// The parameter.
        parameter: usize,
        /// Whether it changes the constraints; masses if not.
        changes_constraints: bool,
    },
    /// An output has no derivatives at the equilibrium, such as the size of a force that is zero there.
    OutputNotSmooth {
        /// The output.
        output: usize,
    },
}
