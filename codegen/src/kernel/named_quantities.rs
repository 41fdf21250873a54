//! Named quantities: values, slopes, rates and biases.

use super::algebra::Value;
use super::block::Block;
use super::builder::Builder;
use crate::graph::Signed;
use crate::term::{Named, NamedKind, Root, Symbol, Term};

impl Builder<'_> {
    /// Values and slopes of named quantities.
    pub(super) fn names(&mut self, names: &[Named]) {
        for (k, named) in names.iter().enumerate() {
            let (block, slopes, inverse) = match &named.kind {
                NamedKind::Root(root) => (Block::Roots, &root.slopes, self.named_root(k, &named.name, &root.radicand)),
                NamedKind::Formula(formula) => {
                    let value = self.named(Block::Names, &named.name, &formula.value);
                    self.bind(Symbol::Named(k), value);
                    (Block::Names, &formula.slopes, Some(self.lowering.graph.number(1.0)))
                }
                NamedKind::Variable(_) => unreachable!("only a sparse elimination has variables"),
            };
            for (i, slope) in slopes.iter().enumerate() {
                let slope = self.value(slope);
                let slope = self.multiply(slope, inverse);
                let slope = self.keep(block, &format!("{}_{}", named.name, self.scene.coordinates[i].name), slope);
                self.bind(Symbol::NamedSlope(k, i), slope);
            }
        }
    }

    /// Defines a named root; returns its reciprocal.
    pub(super) fn named_root(&mut self, k: usize, name: &str, radicand: &Term) -> Value {
        let radicand = self.lowering.term(radicand);
        let radicand = self.keep(Block::Roots, &format!("{name}_sq"), Some(radicand));
        let value = self.root(radicand);
        let value = self.keep(Block::Roots, name, value);
        self.bind(Symbol::Named(k), value);
        // Root and reciprocal both use the radicand directly and can be computed in parallel; the reciprocal of the
        // root would have to wait for the root.
        let over = self.reciprocal(radicand);
        let inverse = self.multiply(value, over);
        let inverse = self.keep(Block::Roots, &format!("inv_{name}"), inverse);
        if let (Some(value), Some(inverse)) = (value, inverse) {
            self.lowering.inverses.insert(value.id, inverse.id);
        }
        inverse
    }

    /// Names the sine and cosine of an angle that is a sum of coordinates and of angles with such names.
    pub(super) fn keep_angle(&mut self, name: &str, value: Value, kept: Value) {
        let (Some(value), Some(kept)) = (value, kept) else { return };
        if value.id == kept.id || !self.lowering.adds_angles {
            return;
        }
        if let Some(pair) = self.lowering.sine_and_cosine_of_sum(value.id) {
            let mut named = |what: &str, value: Signed| {
                self.keep(Block::Names, &format!("{what}_{name}"), Some(value)).unwrap_or(value)
            };
            let [sine, cosine] = pair;
            let sine = named("sin", Signed { negative: sine.negative != value.negative, ..sine });
            let cosine = named("cos", cosine);
            self.lowering
                .named_angles
                .insert(kept.id, [Signed { negative: sine.negative != kept.negative, ..sine }, cosine]);
        }
    }

    /// Rates and biases of named quantities.
    pub(super) fn named_rates(&mut self, names: &[Named]) {
        for (k, Named { name, kind }) in names.iter().enumerate() {
            match kind {
                NamedKind::Root(root) => self.root_rate(k, name, root),
                NamedKind::Formula(formula) => {
                    let rate = self.named(Block::NamedRates, &format!("{name}_dot"), &formula.rate);
                    self.bind(Symbol::NamedRate(k), rate);
                    let bias = self.named(Block::NamedRates, &format!("{name}_bias"), &formula.bias);
                    self.bind(Symbol::NamedBias(k), bias);
                }
                NamedKind::Variable(_) => unreachable!("only a sparse elimination has variables"),
            }
        }
    }

    fn root_rate(&mut self, k: usize, name: &str, root: &Root) {
        let n = self.scene.coordinates.len();
        let slopes: Vec<Value> = (0..n).map(|i| self.bound(Symbol::NamedSlope(k, i))).collect();
        let rates: Vec<Value> = (0..n).map(|i| Some(self.lowering.graph.input(Symbol::Rate(i)))).collect();
        let moved = self.dot(&slopes, &rates);
        let time_derivative = self.value(&root.half_time_derivative);
        let root_value = self.bound(Symbol::Named(k));
        let inverse = self.reciprocal(root_value);
        let time_derivative = self.multiply(time_derivative, inverse);
        let rate = self.sum(moved.into_iter().chain(time_derivative).collect());
        let rate = self.keep(Block::Rates, &format!("{name}_dot"), rate);
        self.bind(Symbol::NamedRate(k), rate);
        let square = self.multiply(rate, rate);
        let half = self.value(&root.half_bias);
        let sum = self.difference(half, square);
        let bias = self.multiply(sum, inverse);
        let bias = self.keep(Block::Rates, &format!("{name}_bias"), bias);
        self.bind(Symbol::NamedBias(k), bias);
    }
}
