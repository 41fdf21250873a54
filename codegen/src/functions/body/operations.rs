//! Emits the operations that compute values.

use qrm_core::Operation;

use super::Body;
use crate::graph::{Id, Op, Signed};
use crate::term::Symbol;

/// The number of terms in a partial sum: sums of more than twice as many terms are split into independent parts.
const CHAIN: usize = 8;

impl Body<'_> {
    pub(super) fn compute(&mut self, id: Id) -> u32 {
        let graph = self.graph;
        match graph.op(id) {
            Op::Number(bits) => self.tape.borrow_mut().number(f64::from_bits(*bits)),
            Op::Input(Symbol::Pi) => self.operation(Operation::Pi),
            Op::Input(symbol) => unreachable!("{symbol:?} stands outside"),
            Op::Sum(terms) => self.sum(terms),
            Op::Product(factors) => self.product(factors),
            Op::Reciprocal(a) => {
                let value = self.value(*a);
                self.operation(Operation::Recip(value))
            }
            Op::Power(a, exponent) => {
                let value = self.value(*a);
                self.operation(Operation::PowF(value, f64::from_bits(*exponent)))
            }
            Op::Call(function, a) => {
                let value = self.value(*a);
                self.operation(function.operation(&[value]))
            }
        }
    }

    /// Emits a sum, with a positive term first if there is one.
    fn sum(&mut self, terms: &[Signed]) -> u32 {
        if let Some(depths) = self.depths {
            return self.joined_sum(terms, depths);
        }
        let mut ordered: Vec<Signed> = terms.to_vec();
        if let Some(first) = ordered.iter().position(|t| !t.negative) {
            let first = ordered.remove(first);
            ordered.insert(0, first);
        }
        let mut sum = self.root(ordered[0]);
        for term in &ordered[1..] {
            sum = self.added(sum, *term);
        }
        sum
    }

    /// Adds a term to a sum.
    fn added(&mut self, sum: u32, term: Signed) -> u32 {
        let value = self.value(term.id);
        self.operation(if term.negative { Operation::Sub(sum, value) } else { Operation::Add(sum, value) })
    }

    /// Emits a sum with fused products, deepest product last.
    fn joined_sum(&mut self, terms: &[Signed], depths: &[u32]) -> u32 {
        let is_product = |body: &Self, id: Id| {
            matches!(body.graph.op(id), Op::Product(_))
                && !body.values.contains_key(&id)
                && !body.predefined.contains_key(&id)
        };
        let mut ordered = terms.to_vec();
        ordered.sort_by_key(|term| (is_product(self, term.id), depths[term.id]));
        if ordered.len() > 2 * CHAIN {
            let parts: Vec<u32> = ordered.chunks(CHAIN).map(|part| self.joined_sum(part, depths)).collect();
            let sum = parts.into_iter().reduce(|sum, part| self.operation(Operation::Add(sum, part)));
            return sum.unwrap_or_else(|| unreachable!("a long sum has parts"));
        }
        let first = ordered.iter().position(|t| !t.negative && (ordered.len() == 1 || !is_product(self, t.id)));
        let first = first.or_else(|| ordered.iter().position(|t| !is_product(self, t.id)));
        let first = first.or_else(|| ordered.iter().position(|t| !t.negative)).unwrap_or(0);
        let first = ordered.remove(first);
        let mut sum = self.root(first);
        for term in ordered {
            let graph = self.graph;
            sum = match graph.op(term.id) {
                Op::Product(factors) if is_product(self, term.id) => {
                    let factors = self.by_depth(factors);
                    let last = self.value(factors[factors.len() - 1]);
                    let others = self.product(&factors[..factors.len() - 1]);
                    self.operation(match term.negative {
                        true => Operation::NegMulAdd(others, last, sum),
                        false => Operation::MulAdd(others, last, sum),
                    })
                }
                _ => self.added(sum, term),
            };
        }
        sum
    }

    fn by_depth(&self, factors: &[Id]) -> Vec<Id> {
        let mut factors = factors.to_vec();
        if let Some(depths) = self.depths {
            factors.sort_by_key(|&id| depths[id]);
        }
        factors
    }

    /// Emits a product; reciprocals used only here become divisions.
    fn product(&mut self, factors: &[Id]) -> u32 {
        let graph = self.graph;
        let factors = &self.by_depth(factors)[..];
        let divisor = |body: &Self, id: Id| match graph.op(id) {
            // A kernel keeps reciprocals separate, since they do not depend on the other factors.
            Op::Reciprocal(a)
                if body.depths.is_none() && !body.values.contains_key(&id) && !body.predefined.contains_key(&id) =>
            {
                Some(*a)
            }
            _ => None,
        };
        let mut product: Option<u32> = None;
        for &factor in factors {
            if divisor(self, factor).is_some() {
                continue;
            }
            let value = self.value(factor);
            product = Some(product.map_or(value, |product| self.operation(Operation::Mul(product, value))));
        }
        for &factor in factors {
            let Some(divisor) = divisor(self, factor) else { continue };
            let value = self.value(divisor);
            product = Some(match product {
                Some(product) => self.operation(Operation::Div(product, value)),
                None => self.operation(Operation::Recip(value)),
            });
        }
        product.unwrap_or_else(|| unreachable!("a product has factors"))
    }
}
