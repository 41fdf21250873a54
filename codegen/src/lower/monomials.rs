//! Sums of products: merges equal parts and factors out common factors.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed as _, ToPrimitive};

use super::Lowering;
use crate::graph::{Id, Op, Signed};
use crate::term::Term;
use qrm_scene::expression::to_f64;
use qrm_scene::function::Function;

/// A product in a sum.
#[derive(Clone, Debug)]
pub(super) struct Monomial {
    pub(super) negative: bool,
    pub(super) factors: Vec<Id>,
}

impl Lowering {
    /// A product or power as a list of factors.
    pub(super) fn monomial(&mut self, term: &Term) -> Monomial {
        let mut monomial = Monomial { negative: false, factors: Vec::new() };
        let terms = match term {
            Term::Product(factors) => factors.as_slice(),
            single => std::slice::from_ref(single),
        };
        for factor in terms {
            match factor {
                Term::Power(base, exponent) => self.power(base, exponent, &mut monomial),
                other => {
                    let value = self.term(other);
                    monomial.negative ^= value.negative;
                    monomial.factors.push(value.id);
                }
            }
        }
        monomial
    }

    /// Appends the factors of a power: integer and half-integer exponents use multiplication, root and reciprocal.
    fn power(&mut self, base: &Term, exponent: &BigRational, monomial: &mut Monomial) {
        let doubled = exponent * BigRational::from_integer(2.into());
        let small = doubled.is_integer().then(|| doubled.to_integer().to_i32()).flatten().filter(|n| n.abs() <= 32);
        let Some(halves) = small else {
            let base = self.term(base);
            let base = self.positive(base);
            monomial.factors.push(self.graph.add(Op::Power(base, to_f64(exponent).to_bits())));
            return;
        };
        let is_root = halves % 2 != 0;
        let base = if is_root {
            let radicand = self.term(base);
            let radicand = self.positive(radicand);
            self.graph.add(Op::Call(Function::Sqrt, radicand))
        } else {
            let value = self.term(base);
            monomial.negative ^= value.negative && (halves / 2) % 2 != 0;
            value.id
        };
        let factor = if halves < 0 { self.reciprocal(base) } else { base };
        let times = if is_root { halves.unsigned_abs() } else { halves.unsigned_abs() / 2 };
        monomial.factors.extend(std::iter::repeat_n(factor, times as usize));
    }

    /// A sum: equal varying parts are merged, then common factors are factored out.
    pub(super) fn sum(&mut self, terms: &[Term]) -> Signed {
        let mut merged: BTreeMap<Vec<Id>, Vec<Monomial>> = BTreeMap::new();
        for term in terms {
            let monomial = self.monomial(term);
            let (constant, mut varying): (Vec<Id>, Vec<Id>) =
                monomial.factors.into_iter().partition(|&id| self.graph.is_constant(id));
            varying.sort_unstable();
            merged.entry(varying).or_default().push(Monomial { negative: monomial.negative, factors: constant });
        }
        let mut monomials = Vec::new();
        for (mut factors, constants) in merged {
            let coefficient = self.factored(constants);
            if !self.is_one(coefficient.id) || factors.is_empty() {
                factors.insert(0, coefficient.id);
            }
            monomials.push(Monomial { negative: coefficient.negative, factors });
        }
        self.factored(monomials)
    }

    fn is_one(&self, id: Id) -> bool {
        *self.graph.op(id) == Op::Number(1.0_f64.to_bits())
    }

    /// Sums monomials; repeatedly factors out the most common factor.
    fn factored(&mut self, monomials: Vec<Monomial>) -> Signed {
        let mut terms = Vec::new();
        let mut rest = monomials;
        while let Some(common) = most_common_factor(&rest) {
            let (with, without): (Vec<Monomial>, Vec<Monomial>) =
                rest.into_iter().partition(|m| m.factors.contains(&common));
            let inner = with.into_iter().map(|mut monomial| {
                if let Some(place) = monomial.factors.iter().position(|&id| id == common) {
                    monomial.factors.remove(place);
                }
                monomial
            });
            let inner = self.factored(inner.collect());
            terms.push(Signed { negative: inner.negative, id: self.graph.product(vec![common, inner.id]) });
            rest = without;
        }
        for monomial in rest {
            terms.push(Signed { negative: monomial.negative, id: self.graph.product(monomial.factors) });
        }
        self.total(terms)
    }

    /// Sums terms; adds numbers and counts equal terms.
    pub fn total(&mut self, terms: Vec<Signed>) -> Signed {
        let mut number = 0.0;
        let mut counts: BTreeMap<Id, i32> = BTreeMap::new();
        for term in terms {
            let sign = if term.negative { -1 } else { 1 };
            match self.graph.op(term.id) {
                Op::Number(bits) => number += f64::from(sign) * f64::from_bits(*bits),
                _ => *counts.entry(term.id).or_default() += sign,
            }
        }
        let mut kept = Vec::new();
        if number != 0.0 {
            kept.push(self.graph.number(number));
        }
        for (id, count) in counts {
            match count {
                0 => {}
                1 | -1 => kept.push(Signed { negative: count < 0, id }),
                _ => {
                    let times = self.graph.number(f64::from(count));
                    kept.push(Signed { negative: times.negative, id: self.graph.product(vec![times.id, id]) });
                }
            }
        }
        self.graph.sum(kept)
    }
}

/// The factor that occurs in most monomials, if it occurs in more than one.
fn most_common_factor(monomials: &[Monomial]) -> Option<Id> {
    let mut counts: BTreeMap<Id, usize> = BTreeMap::new();
    for monomial in monomials {
        let mut seen = monomial.factors.clone();
        seen.sort_unstable();
        seen.dedup();
        for id in seen {
            *counts.entry(id).or_default() += 1;
        }
    }
    let best = counts.into_iter().max_by_key(|&(id, count)| (count, std::cmp::Reverse(id)))?;
    (best.1 > 1).then_some(best.0)
}
