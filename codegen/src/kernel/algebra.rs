//! Arithmetic on values, some of which are structurally zero.

use std::collections::HashSet;

use super::block::Block;
use super::builder::{Builder, Local};
use crate::graph::{Id, Op, Signed};
use crate::term::{Symbol, Term};
use qrm_scene::function::Function;

/// A value; `None` is a structural zero.
pub(super) type Value = Option<Signed>;
/// A matrix, as rows.
pub(super) type Matrix = Vec<Vec<Value>>;

impl Builder<'_> {
    /// The value of a term.
    pub(super) fn value(&mut self, term: &Term) -> Value {
        let value = self.lowering.term(term);
        (!self.is_zero(value)).then_some(value)
    }

    pub(super) fn is_zero(&self, value: Signed) -> bool {
        *self.lowering.graph.op(value.id) == Op::Number(0)
    }

    pub(super) fn is_one(&self, value: Signed) -> bool {
        *self.lowering.graph.op(value.id) == Op::Number(1.0_f64.to_bits())
    }

    /// Names a value, unless it needs no computation.
    pub(super) fn keep(&mut self, block: Block, name: &str, value: Value) -> Value {
        let value = value?;
        let graph = &mut self.lowering.graph;
        if graph.is_constant(value.id) || graph.op(value.id).is_leaf() {
            return Some(value);
        }
        let place = self.by_value.get(&value.id).copied().unwrap_or_else(|| {
            let plain = Signed { negative: false, ..value };
            let input = if self.is_inline { plain } else { graph.input(Symbol::Local(self.next)) };
            self.next += 1;
            self.by_value.insert(value.id, self.locals.len());
            self.definitions.insert(input.id, value.id);
            self.locals.push(Local { name: name.to_lowercase(), value: plain, input, block });
            self.locals.len() - 1
        });
        Some(Signed { negative: value.negative, id: self.locals[place].input.id })
    }

    /// Binds a symbol to a value.
    pub(super) fn bind(&mut self, symbol: Symbol, value: Value) {
        let zero = self.lowering.graph.number(0.0);
        self.lowering.bound.insert(symbol, value.unwrap_or(zero));
    }

    /// The value of a bound symbol.
    pub(super) fn bound(&self, symbol: Symbol) -> Value {
        self.lowering.bound.get(&symbol).copied().filter(|value| !self.is_zero(*value))
    }

    pub(super) fn multiply(&mut self, a: Value, b: Value) -> Value {
        let (a, b) = (a?, b?);
        let negative = a.negative != b.negative;
        let id = match (self.is_one(a), self.is_one(b)) {
            (true, _) => b.id,
            (_, true) => a.id,
            _ => self.lowering.graph.product(vec![a.id, b.id]),
        };
        Some(Signed { negative, id })
    }

    pub(super) fn sum(&mut self, terms: Vec<Signed>) -> Value {
        let sum = self.lowering.total(terms);
        (!self.is_zero(sum)).then_some(sum)
    }

    pub(super) fn difference(&mut self, a: Value, b: Value) -> Value {
        let terms = a.into_iter().chain(b.map(Signed::negated)).collect();
        self.sum(terms)
    }

    /// The sum of products of entries.
    pub(super) fn dot(&mut self, a: &[Value], b: &[Value]) -> Value {
        let products: Vec<Signed> = a.iter().zip(b).filter_map(|(a, b)| self.multiply(*a, *b)).collect();
        self.sum(products)
    }

    pub(super) fn root(&mut self, radicand: Value) -> Value {
        let radicand = self.lowering.positive(radicand?);
        Some(Signed { negative: false, id: self.lowering.graph.add(Op::Call(Function::Sqrt, radicand)) })
    }

    /// One over a value. If the reciprocal of a factor already exists, the remaining factors are inverted separately,
    /// which does not have to wait for it.
    pub(super) fn reciprocal(&mut self, value: Value) -> Value {
        let value = value?;
        if self.is_one(value) {
            return Some(value);
        }
        let definition = self.definitions.get(&value.id).copied().unwrap_or(value.id);
        let known = |id: &Id| self.lowering.inverses.get(id).copied();
        if let Op::Product(factors) = self.lowering.graph.op(definition).clone()
            && let Some((place, inverse)) = factors.iter().enumerate().find_map(|(i, id)| Some((i, known(id)?)))
        {
            let rest = factors.iter().enumerate().filter(|(i, _)| *i != place).map(|(_, id)| *id).collect();
            let rest = self.lowering.graph.product(rest);
            let over = Signed { negative: value.negative, id: self.lowering.reciprocal(rest) };
            return self.multiply(Some(Signed { negative: false, id: inverse }), Some(over));
        }
        Some(Signed { negative: value.negative, id: self.lowering.reciprocal(value.id) })
    }

    /// The number of operations that compute values from named ones, without constants.
    pub(super) fn cost(&self, values: impl Iterator<Item = Value>) -> usize {
        let graph = &self.lowering.graph;
        let (mut seen, mut cost) = (HashSet::new(), 0);
        let mut pending: Vec<Id> = values.flatten().map(|value| value.id).collect();
        while let Some(id) = pending.pop() {
            if graph.is_constant(id) || !seen.insert(id) {
                continue;
            }
            let operands = graph.op(id).operands();
            cost += match graph.op(id) {
                Op::Sum(_) | Op::Product(_) => operands.len() - 1,
                _ => 0,
            };
            pending.extend(operands);
        }
        cost
    }
}
