//! Symbolic results as plain data, without types of the symbolic engine.

mod equations;
mod named;
mod sparse;

use std::sync::Arc;

use num_rational::BigRational;
use num_traits::Zero as _;

pub use equations::{AffineForce, EffortGroup, Equations, KernelEquations, Linearization, NormalForce, Row};
pub use named::{Formula, Named, NamedKind, Root};
pub use sparse::{BodyInertia, EffortsAlongVariables, FunctionOfVariables, NamedVariable, SparseEquations};

use qrm_scene::expression::to_f64;
use qrm_scene::function::Function;
use qrm_scene::spline::Spline;

/// A symbolic expression in normal form: flat sums and products, rational powers, functions of one argument.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Term {
    /// An exact number.
    Number(BigRational),
    /// A symbol.
    Symbol(Symbol),
    /// A sum.
    Sum(Vec<Term>),
    /// A product.
    Product(Vec<Term>),
    /// A power with a fixed rational exponent.
    Power(Box<Term>, BigRational),
    /// A function of one argument.
    Call(Function, Box<Term>),
    /// The derivative of a spline; order 0 is the spline itself.
    Spline(Arc<Spline>, usize, Box<Term>),
}

/// A symbol in a [`Term`]; numbers are indices into the scene's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Symbol {
    /// A parameter.
    Parameter(usize),
    /// The number pi.
    Pi,
    /// Time.
    Time,
    /// The size of a virtual displacement; it vanishes during the derivation.
    Displacement,
    /// A generalized coordinate.
    Coordinate(usize),
    /// The rate of a generalized coordinate.
    Rate(usize),
    /// The acceleration of a generalized coordinate.
    Acceleration(usize),
    /// A Lagrange multiplier.
    Multiplier(usize),
    /// The size of an output that is the normal force of friction.
    NormalForce(usize),
    /// A named quantity.
    Named(usize),
    /// The derivative of a named quantity with respect to a coordinate.
    NamedSlope(usize, usize),
    /// The rate of a named quantity.
    NamedRate(usize),
    /// The second rate of a named quantity, without the part proportional to accelerations.
    NamedBias(usize),
    /// The second rate of a named quantity.
    NamedAcceleration(usize),
    /// A generalized momentum, where the sparse equations give its value.
    Momentum(usize),
    /// A generalized force, where the sparse equations give its value.
    GeneralizedForce(usize),
    /// The residual of a constraint, for a correction.
    Residual(usize),
    /// A function that is constant between jumps; the engine treats it as a constant.
    Switch(usize),
    /// A named local value, numbered in the order of its statement.
    Local(usize),
}

impl Symbol {
    /// Whether its value is constant during a run.
    pub fn is_constant(self) -> bool {
        matches!(self, Self::Parameter(_) | Self::Pi)
    }
}

impl Term {
    /// The number zero.
    pub fn zero() -> Self {
        Self::Number(BigRational::from_integer(0.into()))
    }

    /// Whether the term is the number zero.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Number(number) if number.is_zero())
    }

    /// Copies the term with some symbols replaced by other terms.
    #[must_use]
    pub fn replacing(&self, other: &impl Fn(Symbol) -> Option<Term>) -> Self {
        let inner = |term: &Term| term.replacing(other);
        match self {
            Self::Number(_) => self.clone(),
            Self::Symbol(symbol) => other(*symbol).unwrap_or_else(|| self.clone()),
            Self::Sum(terms) => Self::Sum(terms.iter().map(inner).collect()),
            Self::Product(factors) => Self::Product(factors.iter().map(inner).collect()),
            Self::Power(base, exponent) => Self::Power(Box::new(inner(base)), exponent.clone()),
            Self::Call(function, argument) => Self::Call(*function, Box::new(inner(argument))),
            Self::Spline(spline, order, argument) => Self::Spline(spline.clone(), *order, Box::new(inner(argument))),
        }
    }

    /// Copies the term with symbols for the roots among these quantities.
    #[must_use]
    pub fn naming_roots(&self, names: &[Named]) -> Self {
        let inner = |term: &Term| term.naming_roots(names);
        let is_root = |named: &Named, base: &Term| matches!(&named.kind, NamedKind::Root(r) if r.radicand == *base);
        match self {
            Self::Number(_) | Self::Symbol(_) => self.clone(),
            Self::Sum(terms) => Self::Sum(terms.iter().map(inner).collect()),
            Self::Product(factors) => Self::Product(factors.iter().map(inner).collect()),
            Self::Call(function, argument) => Self::Call(*function, Box::new(inner(argument))),
            Self::Spline(spline, order, argument) => Self::Spline(spline.clone(), *order, Box::new(inner(argument))),
            Self::Power(base, exponent) => {
                let doubled = exponent * BigRational::from_integer(2.into());
                match names.iter().position(|named| is_root(named, base)) {
                    Some(k) if doubled.is_integer() => Self::Power(Box::new(Self::Symbol(Symbol::Named(k))), doubled),
                    _ => Self::Power(Box::new(inner(base)), exponent.clone()),
                }
            }
        }
    }

    /// Evaluates the term with the values of symbols from `lookup`.
    pub fn evaluate(&self, lookup: &impl Fn(Symbol) -> f64) -> f64 {
        match self {
            Self::Number(number) => to_f64(number),
            Self::Symbol(symbol) => lookup(*symbol),
            Self::Sum(terms) => terms.iter().map(|term| term.evaluate(lookup)).sum(),
            Self::Product(factors) => factors.iter().map(|factor| factor.evaluate(lookup)).product(),
            Self::Power(base, exponent) => base.evaluate(lookup).powf(to_f64(exponent)),
            Self::Call(function, argument) => function.evaluate(&[argument.evaluate(lookup); 2]),
            Self::Spline(spline, order, argument) => spline.value(*order, argument.evaluate(lookup)),
        }
    }

    /// Whether `test` returns true for any symbol of the term.
    pub fn any_symbol(&self, test: &impl Fn(Symbol) -> bool) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Symbol(symbol) => test(*symbol),
            Self::Sum(terms) | Self::Product(terms) => terms.iter().any(|t| t.any_symbol(test)),
            Self::Power(inner, _) | Self::Call(_, inner) | Self::Spline(_, _, inner) => inner.any_symbol(test),
        }
    }
}
