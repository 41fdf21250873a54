//! Quantities with a name, and their derivatives for the chain rule.

use num_rational::BigRational;

use super::sparse::NamedVariable;
use super::{Symbol, Term};
use qrm_scene::scene::Scene;

/// A quantity with a name: formulae contain its symbol and those of its derivatives, which keeps them short.
#[derive(Clone, Debug)]
pub struct Named {
    /// The name of the quantity in generated code and in the derivation.
    pub name: String,
    /// The kind of the quantity, with its terms.
    pub kind: NamedKind,
}

/// The kinds of named quantities.
#[derive(Clone, Debug)]
pub enum NamedKind {
    /// The root of a term.
    Root(Root),
    /// A coordinate of a point or body, or the argument of a function.
    Formula(Formula),
    /// Either of them, as a variable of a sparse elimination.
    Variable(NamedVariable),
}

/// A named root.
#[derive(Clone, Debug)]
pub struct Root {
    /// The term under the root.
    pub radicand: Term,
    /// The derivatives of the root with respect to the coordinates, times the root.
    pub slopes: Vec<Term>,
    /// Half of the radicand's partial derivative with respect to time.
    pub half_time_derivative: Term,
    /// Half of the second rate of the radicand, without the part proportional to accelerations.
    pub half_bias: Term,
}

/// A named formula of coordinates, time and quantities named before.
#[derive(Clone, Debug)]
pub struct Formula {
    /// The value of the formula.
    pub value: Term,
    /// The derivatives of the formula with respect to the coordinates.
    pub slopes: Vec<Term>,
    /// The rate of the formula.
    pub rate: Term,
    /// The second rate of the formula, without the part proportional to accelerations.
    pub bias: Term,
}

impl Named {
    /// The term under the root, or the formula.
    pub fn inside(&self) -> &Term {
        match &self.kind {
            NamedKind::Root(root) => &root.radicand,
            NamedKind::Formula(formula) => &formula.value,
            NamedKind::Variable(variable) => &variable.function.value,
        }
    }

    /// The plain-text name of one of its symbols.
    pub fn symbol_name(&self, symbol: Symbol, scene: &Scene) -> String {
        match symbol {
            Symbol::NamedSlope(_, i) => format!("{}_{}", self.name, scene.coordinates[i].name),
            Symbol::NamedRate(_) => format!("{}_dot", self.name),
            Symbol::NamedBias(_) => format!("{}_bias", self.name),
            Symbol::NamedAcceleration(_) => format!("{}_ddot", self.name),
            _ => self.name.clone(),
        }
    }

    /// The symbols of the quantity with this index and of its derivatives, with their terms.
    pub fn definitions(&self, place: usize) -> Vec<(Symbol, Term)> {
        let (value, slopes, rate, bias) = match &self.kind {
            NamedKind::Formula(formula) => {
                (formula.value.clone(), formula.slopes.clone(), formula.rate.clone(), formula.bias.clone())
            }
            NamedKind::Root(root) => root.terms(place),
            NamedKind::Variable(variable) => return variable.definitions(place),
        };
        let slopes = slopes.into_iter().enumerate().filter(|(_, slope)| !slope.is_zero());
        std::iter::once((Symbol::Named(place), value))
            .chain(slopes.map(|(i, slope)| (Symbol::NamedSlope(place, i), slope)))
            .chain([(Symbol::NamedRate(place), rate), (Symbol::NamedBias(place), bias)])
            .collect()
    }
}

impl Root {
    /// The value, slopes, rate and bias of the root with this index.
    fn terms(&self, place: usize) -> (Term, Vec<Term>, Term, Term) {
        let over = |term: &Term| Term::Product(vec![term.clone(), power(Term::Symbol(Symbol::Named(place)), -1, 1)]);
        let slopes = self.slopes.iter().map(|slope| if slope.is_zero() { Term::zero() } else { over(slope) });
        let moved =
            self.slopes.iter().enumerate().filter(|(_, slope)| !slope.is_zero()).map(|(i, _)| {
                Term::Product([Symbol::NamedSlope(place, i), Symbol::Rate(i)].map(Term::Symbol).to_vec())
            });
        let rate = Term::Sum(moved.chain([over(&self.half_time_derivative)]).collect());
        let square = power(Term::Symbol(Symbol::NamedRate(place)), 2, 1);
        let minus_square = Term::Product(vec![Term::Number(BigRational::from_integer((-1).into())), square]);
        let bias = over(&Term::Sum(vec![self.half_bias.clone(), minus_square]));
        (power(self.radicand.clone(), 1, 2), slopes.collect(), rate, bias)
    }
}

/// A power with the exponent `numerator / denominator`.
pub(super) fn power(base: Term, numerator: i32, denominator: i32) -> Term {
    Term::Power(Box::new(base), BigRational::new(numerator.into(), denominator.into()))
}
