//! Symbolic results as plain data, free of the engine's types.

mod equations;
mod named;

use std::sync::Arc;

use num_rational::BigRational;
use num_traits::Zero as _;

pub use equations::{AffineForce, Equations, KernelEquations, Linearization, NormalForce, Push, Row};
pub use named::{Formula, Named, NamedKind, Root};
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
    /// The derivative of a spline, of an order; the spline itself where that is zero.
    Spline(Arc<Spline>, usize, Box<Term>),
}

/// A symbol in a [`Term`]; numbers are places in the scene's lists.
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
    /// The derivative of a named quantity by a coordinate.
    NamedSlope(usize, usize),
    /// The rate of a named quantity.
    NamedRate(usize),
    /// The second rate of a named quantity without its slopes times the accelerations.
    NamedBias(usize),
    /// How far a constraint is from closed, for a correction.
    Residual(usize),
    /// A function that changes in jumps alone: a constant to the engine.
    Switch(usize),
    /// A value that has a statement of its own, in the order of the statements.
    Local(usize),
}

impl Symbol {
    /// Whether it keeps its value during a run.
    pub fn is_constant(self) -> bool {
        matches!(self, Self::Parameter(_) | Self::Pi)
    }
}

impl Term {
    /// The number zero.
    pub fn zero() -> Self {
        Self::Number(BigRational::from_integer(0.into()))
    }

    /// Whether it is the number zero.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Number(number) if number.is_zero())
    }

    /// A copy of the term with other terms for some of its symbols.
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

    /// A copy of the term with symbols for the roots among these quantities.
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

    /// The value of the term when each symbol has the value that `lookup` gives it.
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

    /// Whether a symbol for which `test` holds occurs.
    pub fn any_symbol(&self, test: &impl Fn(Symbol) -> bool) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Symbol(symbol) => test(*symbol),
            Self::Sum(terms) | Self::Product(terms) => terms.iter().any(|t| t.any_symbol(test)),
            Self::Power(inner, _) | Self::Call(_, inner) | Self::Spline(_, _, inner) => inner.any_symbol(test),
        }
    }
}
