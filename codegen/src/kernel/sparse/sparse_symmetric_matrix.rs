//! A sparse symmetric matrix whose entries are sums that grow during an elimination.

use std::collections::{BTreeSet, HashMap};

use super::super::algebra::Value;
use super::super::block::Block;
use super::super::builder::Builder;
use crate::graph::Signed;

/// A sparse symmetric matrix.
pub(super) struct SparseSymmetricMatrix {
    /// The terms of the entries on and above the diagonal, by row and column.
    terms: HashMap<(usize, usize), Vec<Signed>>,
    /// The positive terms of each diagonal entry: its value if nothing had been subtracted since the last substitution.
    unreduced: Vec<Vec<Signed>>,
    /// The columns of the entries of each row, without the diagonal.
    neighbours: Vec<BTreeSet<usize>>,
}

impl SparseSymmetricMatrix {
    /// Creates a matrix of zeros.
    pub(super) fn new(size: usize) -> Self {
        Self { terms: HashMap::new(), unreduced: vec![Vec::new(); size], neighbours: vec![BTreeSet::new(); size] }
    }

    /// Adds rows of zeros up to a size.
    pub(super) fn grow(&mut self, size: usize) {
        self.neighbours.resize(size, BTreeSet::new());
        self.unreduced.resize(size, Vec::new());
    }

    /// Adds to an entry, and to the one opposite to it.
    pub(super) fn add(&mut self, i: usize, j: usize, value: Value) {
        let Some(value) = value else { return };
        self.terms.entry((i.min(j), i.max(j))).or_default().push(value);
        if i != j {
            self.neighbours[i].insert(j);
            self.neighbours[j].insert(i);
        }
    }

    /// Adds to the unreduced value of a diagonal entry.
    pub(super) fn add_unreduced(&mut self, i: usize, value: Value) {
        self.unreduced[i].extend(value);
    }

    /// Takes a value out of the unreduced value of a diagonal entry: it cancelled exactly.
    pub(super) fn remove_unreduced(&mut self, i: usize, value: Value) {
        if let Some(place) = self.unreduced[i].iter().position(|own| Some(*own) == value) {
            self.unreduced[i].remove(place);
        }
    }

    /// The unreduced value of a diagonal entry.
    pub(super) fn unreduced(&mut self, builder: &mut Builder, i: usize, name: &str) -> Value {
        let sum = builder.sum(std::mem::take(&mut self.unreduced[i]));
        builder.keep(Block::Inertia, &format!("unreduced_{name}"), sum)
    }

    /// The value of an entry, with a name.
    pub(super) fn entry(&mut self, builder: &mut Builder, [i, j]: [usize; 2], name: impl Fn(usize) -> String) -> Value {
        let key = (i.min(j), i.max(j));
        let terms = self.terms.get_mut(&key)?;
        if terms.len() > 1 {
            let sum = builder.sum(std::mem::take(terms));
            let name = format!("inertia_{}_{}", name(key.0), name(key.1));
            *terms = builder.keep(Block::Inertia, &name, sum).into_iter().collect();
        }
        terms.first().copied()
    }

    /// The other variables to which one is coupled.
    pub(super) fn neighbours(&self, i: usize) -> &BTreeSet<usize> {
        &self.neighbours[i]
    }

    /// Takes a row and its column out.
    pub(super) fn remove(&mut self, i: usize) {
        self.terms.remove(&(i, i));
        for j in std::mem::take(&mut self.neighbours[i]) {
            self.terms.remove(&(i.min(j), i.max(j)));
            self.neighbours[j].remove(&i);
        }
    }

    /// Replaces a variable by a sum of others: `z = sum of by*other`.
    pub(super) fn substitute(
        &mut self,
        builder: &mut Builder,
        z: usize,
        definition: &[(usize, Value)],
        name: impl Fn(usize) -> String + Copy,
    ) {
        let own = self.entry(builder, [z, z], name);
        let unreduced = self.unreduced(builder, z, &name(z));
        let beside: Vec<(usize, Value)> =
            self.neighbours[z].clone().into_iter().map(|u| (u, self.entry(builder, [z, u], name))).collect();
        let coupling = |u: usize| beside.iter().find(|(other, _)| *other == u).and_then(|(_, value)| *value);
        self.remove(z);
        // With `z = by*u + ...` the entries of `u` grow by `by*own + coupling` in the column of `z`.
        let mut shares: Vec<Value> = Vec::new();
        for (u, by) in definition {
            let product = builder.multiply(*by, own);
            let sum = builder.sum(coupling(*u).into_iter().chain(product).collect());
            shares.push(builder.keep(Block::Inertia, &format!("share_{}_{}", name(z), name(*u)), sum));
        }
        for (i, (u, by)) in definition.iter().enumerate() {
            let both = builder.sum(shares[i].into_iter().chain(coupling(*u)).collect());
            let product = builder.multiply(*by, both);
            self.add(*u, *u, product);
            let square = builder.multiply(*by, *by);
            let product = builder.multiply(square, unreduced);
            self.add_unreduced(*u, product);
            for (j, (v, by_v)) in definition.iter().enumerate().take(i) {
                let products = [builder.multiply(*by, shares[j]), builder.multiply(*by_v, coupling(*u))];
                products.into_iter().for_each(|product| self.add(*u, *v, product));
            }
            for (v, value) in &beside {
                if definition.iter().all(|(other, _)| other != v) {
                    let product = builder.multiply(*by, *value);
                    self.add(*u, *v, product);
                }
            }
        }
    }
}
