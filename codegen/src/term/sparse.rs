//! The equations of motion with the second rates of named quantities as unknowns together with the accelerations. They
//! are sparse for all choices of coordinates.

use num_rational::BigRational;

use super::named::power;
use super::{Symbol, Term};

/// The equations of motion for a sparse elimination. The variables are the coordinates and the named quantities, each
/// defined by variables before it.
#[derive(Clone, Debug, Default)]
pub struct SparseEquations {
    /// The named quantities, each after those that it uses.
    pub names: Vec<NamedVariable>,
    /// Constraints, C(q).
    pub constraints: Vec<FunctionOfVariables>,
    /// The inertia of each body.
    pub inertias: Vec<BodyInertia>,
    /// The forces of inertia at zero accelerations of the coordinates, and the loads.
    pub efforts: Vec<EffortsAlongVariables>,
    /// The outputs of the scene.
    pub outputs: Vec<Term>,
}

/// A function of variables and time, with its derivatives.
#[derive(Clone, Debug)]
pub struct FunctionOfVariables {
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
    pub function: FunctionOfVariables,
}

impl NamedVariable {
    /// The symbols of the quantity with this index and of its derivatives, with their terms.
    pub(super) fn definitions(&self, place: usize) -> Vec<(Symbol, Term)> {
        let FunctionOfVariables { value, by, by_time, bias } = &self.function;
        let over = |terms: Vec<Term>| match self.is_root {
            true => Term::Product(vec![Term::Sum(terms), power(Term::Symbol(Symbol::Named(place)), -1, 1)]),
            false => Term::Sum(terms),
        };
        let times = |by: &Term, symbol: Symbol| Term::Product(vec![by.clone(), Term::Symbol(symbol)]);
        let moved = |of_coordinate: fn(usize) -> Symbol, of_name: fn(usize) -> Symbol| {
            by.iter().filter_map(move |(variable, by)| match variable {
                Symbol::Coordinate(i) => Some(times(by, of_coordinate(*i))),
                Symbol::Named(k) => Some(times(by, of_name(*k))),
                _ => None,
            })
        };
        let square = self.is_root.then(|| {
            let square = power(Term::Symbol(Symbol::NamedRate(place)), 2, 1);
            Term::Product(vec![Term::Number(BigRational::from_integer((-1).into())), square])
        });
        let own = std::iter::once(bias.clone()).chain(square);
        let through_names = by.iter().filter_map(|(variable, by)| match variable {
            Symbol::Named(k) => Some(times(by, Symbol::NamedBias(*k))),
            _ => None,
        });
        let value = if self.is_root { power(value.clone(), 1, 2) } else { value.clone() };
        let rate = over(moved(Symbol::Rate, Symbol::NamedRate).chain([by_time.clone()]).collect());
        let acceleration = over(moved(Symbol::Acceleration, Symbol::NamedAcceleration).chain(own.clone()).collect());
        std::iter::once((Symbol::Named(place), value))
            .chain([
                (Symbol::NamedRate(place), rate),
                (Symbol::NamedBias(place), over(through_names.chain(own).collect())),
                (Symbol::NamedAcceleration(place), acceleration),
            ])
            .collect()
    }
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
pub struct EffortsAlongVariables {
    /// The variables on which the displacements depend.
    pub variables: Vec<Symbol>,
    /// Forces and torques, each with its name and the derivatives of its displacement with respect to the variables.
    pub efforts: Vec<(String, Term, Vec<Term>)>,
    /// The resulting forces along the variables, simplified together.
    pub total: Vec<Term>,
}
