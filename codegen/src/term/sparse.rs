//! The equations of motion with the second rates of named quantities as unknowns beside the accelerations: sparse,
//! whatever the coordinates are.

use super::{Symbol, Term};

/// The equations of motion for a sparse elimination. The variables are the coordinates and the named quantities, each
/// defined by variables before it.
#[derive(Clone, Debug, Default)]
pub struct SparseEquations {
    /// The named quantities, each after those that it uses.
    pub names: Vec<NamedVariable>,
    /// Constraints, C(q).
    pub constraints: Vec<LocalFunction>,
    /// The inertia of each body.
    pub inertias: Vec<BodyInertia>,
    /// The forces of inertia at zero accelerations of the coordinates, and the loads.
    pub efforts: Vec<LocalEfforts>,
    /// The outputs of the scene.
    pub outputs: Vec<Term>,
}

/// A function of variables and time, with its derivatives.
#[derive(Clone, Debug)]
pub struct LocalFunction {
    /// The value of the function.
    pub value: Term,
    /// The derivatives with respect to variables that are not zero.
    pub by: Vec<(Symbol, Term)>,
    /// The derivative with respect to time.
    pub by_time: Term,
    /// The second rate of the function, without the parts proportional to second rates of variables.
    pub bias: Term,
}

/// A named quantity as a variable.
#[derive(Clone, Debug)]
pub struct NamedVariable {
    /// The name of the quantity in generated code.
    pub name: String,
    /// Whether the quantity is the root of the function; derivatives and bias are then halved.
    pub is_root: bool,
    /// The function.
    pub function: LocalFunction,
}

/// The inertia of a body.
#[derive(Clone, Debug)]
pub struct BodyInertia {
    /// The variables on which position and angle of the body depend.
    pub variables: Vec<Symbol>,
    /// The rows of the symmetric matrix for the rates of these variables, each up to its diagonal.
    pub matrix: Vec<Vec<Term>>,
}

/// The forces and torques on a body, or of a load.
#[derive(Clone, Debug)]
pub struct LocalEfforts {
    /// The variables on which the displacements depend.
    pub variables: Vec<Symbol>,
    /// Forces and torques, each with its name and the derivatives of its displacement with respect to the variables.
    pub efforts: Vec<(String, Term, Vec<Term>)>,
    /// The resulting forces along the variables, simplified together.
    pub total: Vec<Term>,
}
