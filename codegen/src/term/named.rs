//! Quantities that stand under a name in other formulae, with what the chain rule needs of them.

use num_rational::BigRational;

use super::{Symbol, Term};
use qrm_scene::scene::Scene;

/// A quantity under a name: formulae hold its symbol and those of its derivatives, so that they stay short.
#[derive(Clone, Debug)]
pub struct Named {
    /// The name of the quantity in generated code and in the derivation.
    pub name: String,
    /// The kind of the quantity, with its terms.
    pub kind: NamedKind,
}

/// How a named quantity and its derivatives are computed.
#[derive(Clone, Debug)]
pub enum NamedKind {
    /// The root of a term.
    Root(Root),
    /// A point's or body's coordinate, or the argument of a function.
    Formula(Formula),
}

/// A named root.
#[derive(Clone, Debug)]
pub struct Root {
    /// The term under the root.
    pub radicand: Term,
    /// The derivative of the root by each coordinate, times the root.
    pub slopes: Vec<Term>,
    /// Half of the radicand's derivative by time alone.
    pub half_time_derivative: Term,
    /// Half of what the second rate of the radicand has beside the accelerations.
    pub half_bias: Term,
}

/// A named formula in terms of coordinates, time and quantities named before.
#[derive(Clone, Debug)]
pub struct Formula {
    /// The value of the formula.
    pub value: Term,
    /// The derivative of the formula by each coordinate.
    pub slopes: Vec<Term>,
    /// The rate of the formula.
    pub rate: Term,
    /// The second rate of the formula without its slopes times the accelerations.
    pub bias: Term,
}

impl Named {
    /// The term under the root, or the formula.
    pub fn inside(&self) -> &Term {
        match &self.kind {
            NamedKind::Root(root) => &root.radicand,
            NamedKind::Formula(formula) => &formula.value,
        }
    }

    /// The name of one of its symbols in plain text.
    pub fn symbol_name(&self, symbol: Symbol, scene: &Scene) -> String {
        match symbol {
            Symbol::NamedSlope(_, i) => format!("{}_{}", self.name, scene.coordinates[i].name),
            Symbol::NamedRate(_) => format!("{}_dot", self.name),
            Symbol::NamedBias(_) => format!("{}_bias", self.name),
            _ => self.name.clone(),
        }
    }

    /// The symbols of the quantity at this place of a list and of its derivatives, with what they stand for.
    pub fn definitions(&self, place: usize) -> Vec<(Symbol, Term)> {
        let (value, slopes, rate, bias) = match &self.kind {
            NamedKind::Formula(formula) => {
                (formula.value.clone(), formula.slopes.clone(), formula.rate.clone(), formula.bias.clone())
            }
            NamedKind::Root(root) => root.terms(place),
        };
        let slopes = slopes.into_iter().enumerate().filter(|(_, slope)| !slope.is_zero());
        std::iter::once((Symbol::Named(place), value))
            .chain(slopes.map(|(i, slope)| (Symbol::NamedSlope(place, i), slope)))
            .chain([(Symbol::NamedRate(place), rate), (Symbol::NamedBias(place), bias)])
            .collect()
    }
}

impl Root {
    /// Value, slopes, rate and bias of the root at this place.
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
fn power(base: Term, numerator: i32, denominator: i32) -> Term {
    Term::Power(Box::new(base), BigRational::new(numerator.into(), denominator.into()))
}
