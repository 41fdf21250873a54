//! Products and quotients as factors above and below the fraction bar.

use num_rational::BigRational;
use num_traits::{One, Signed};

use crate::term::Term;

/// A product or quotient without its sign.
pub(super) struct Fraction<'t> {
    pub(super) is_negative: bool,
    pub(super) coefficient: BigRational,
    pub(super) above: Vec<Factor<'t>>,
    pub(super) below: Vec<Factor<'t>>,
}

/// A power with a positive exponent.
pub(super) struct Factor<'t> {
    pub(super) base: &'t Term,
    pub(super) exponent: BigRational,
}

impl<'t> Fraction<'t> {
    pub(super) fn new(term: &'t Term) -> Self {
        let mut fraction =
            Self { is_negative: false, coefficient: BigRational::one(), above: Vec::new(), below: Vec::new() };
        fraction.take(term, false);
        fraction.is_negative = fraction.coefficient.is_negative();
        fraction.coefficient = fraction.coefficient.abs();
        // Constants first and functions last: no factor can then be mistaken for a part of an argument.
        let rank = |factor: &Factor| match factor.base {
            Term::Number(_) => 0,
            Term::Symbol(symbol) if symbol.is_constant() => 1,
            Term::Sum(_) | Term::Product(_) | Term::Power(..) => 3,
            Term::Symbol(_) => 4,
            Term::Call(..) | Term::Spline(..) => 5,
        };
        fraction.above.sort_by_key(rank);
        fraction.below.sort_by_key(rank);
        fraction
    }
}

impl<'t> Fraction<'t> {
    /// Multiplies or divides by a term; nested products are flattened.
    fn take(&mut self, term: &'t Term, divides: bool) {
        let (base, exponent) = match term {
            Term::Product(factors) => return factors.iter().for_each(|factor| self.take(factor, divides)),
            Term::Number(number) if divides => return self.coefficient /= number,
            Term::Number(number) => return self.coefficient *= number,
            Term::Power(base, exponent) => (&**base, exponent.clone()),
            base => (base, BigRational::one()),
        };
        if matches!(base, Term::Product(_)) && exponent == -BigRational::one() {
            return self.take(base, !divides);
        }
        let side = if exponent.is_negative() == divides { &mut self.above } else { &mut self.below };
        side.push(Factor { base, exponent: exponent.abs() });
    }
}
