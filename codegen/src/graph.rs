//! Shared computations: sums, products and functions without duplicates.

use std::collections::HashMap;

use crate::term::Symbol;
use qrm_scene::function::Function;

/// The index of an operation in a [`Graph`].
pub type Id = usize;

/// A value and whether it is negated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Signed {
    /// Whether the value is negated.
    pub negative: bool,
    /// The value.
    pub id: Id,
}

impl Signed {
    /// The value with the opposite sign.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { negative: !self.negative, ..self }
    }
}

/// One operation; operands are indices of earlier operations.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Op {
    /// A positive number, as the bits of its double.
    Number(u64),
    /// A symbol.
    Input(Symbol),
    /// A sum; a sum of a single value negates it.
    Sum(Vec<Signed>),
    /// A product of at least two values.
    Product(Vec<Id>),
    /// One over a value.
    Reciprocal(Id),
    /// A power with a fixed exponent, given as the bits of its double.
    Power(Id, u64),
    /// A function of one value.
    Call(Function, Id),
}

impl Op {
    /// The values that the operation needs.
    pub fn operands(&self) -> Vec<Id> {
        match self {
            Self::Number(_) | Self::Input(_) => Vec::new(),
            Self::Sum(terms) => terms.iter().map(|t| t.id).collect(),
            Self::Product(factors) => factors.clone(),
            Self::Reciprocal(a) | Self::Power(a, _) | Self::Call(_, a) => vec![*a],
        }
    }

    /// Whether nothing is computed.
    pub fn is_leaf(&self) -> bool {
        matches!(self, Self::Number(_) | Self::Input(_))
    }
}

/// Operations without duplicates, each after its operands.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    ops: Vec<Op>,
    constant: Vec<bool>,
    places: HashMap<Op, Id>,
}

impl Graph {
    /// The operations.
    pub fn ops(&self) -> &[Op] {
        &self.ops
    }

    /// The operation with an index.
    pub fn op(&self, id: Id) -> &Op {
        &self.ops[id]
    }

    /// Whether a value is constant during a run.
    pub fn is_constant(&self, id: Id) -> bool {
        self.constant[id]
    }

    /// The index of an operation, which is added if it is new.
    pub fn add(&mut self, op: Op) -> Id {
        if let Some(&id) = self.places.get(&op) {
            return id;
        }
        let constant = match &op {
            Op::Input(symbol) => symbol.is_constant(),
            other => other.operands().iter().all(|&id| self.constant[id]),
        };
        self.ops.push(op.clone());
        self.constant.push(constant);
        self.places.insert(op, self.ops.len() - 1);
        self.ops.len() - 1
    }

    /// A symbol.
    pub fn input(&mut self, symbol: Symbol) -> Signed {
        Signed { negative: false, id: self.add(Op::Input(symbol)) }
    }

    /// A number.
    pub fn number(&mut self, value: f64) -> Signed {
        Signed { negative: value < 0.0, id: self.add(Op::Number(value.abs().to_bits())) }
    }

    /// The product of values; numbers and constants are moved to the front.
    pub fn product(&mut self, factors: Vec<Id>) -> Id {
        let one = self.add(Op::Number(1.0_f64.to_bits()));
        let mut factors = self.flat(factors);
        factors.retain(|&id| id != one);
        factors.sort_unstable();
        let (mut constants, mut varying): (Vec<Id>, Vec<Id>) = factors.into_iter().partition(|&id| self.constant[id]);
        if !varying.is_empty() && constants.len() > 1 {
            constants = vec![self.add(Op::Product(constants))];
        }
        constants.append(&mut varying);
        match constants.len() {
            0 => one,
            1 => constants[0],
            _ => self.add(Op::Product(constants)),
        }
    }

    /// Flattens nested factors.
    fn flat(&self, factors: Vec<Id>) -> Vec<Id> {
        let mut flat = Vec::new();
        let mut pending = factors;
        while let Some(id) = pending.pop() {
            match &self.ops[id] {
                Op::Product(inner) => pending.extend(inner),
                _ => flat.push(id),
            }
        }
        flat
    }

    /// The sum of values. Its sign is normalized, so that a sum and its negative share one operation.
    pub fn sum(&mut self, mut terms: Vec<Signed>) -> Signed {
        match terms.len() {
            0 => return self.number(0.0),
            1 => return terms[0],
            _ => {}
        }
        terms.sort_unstable_by_key(|t| t.id);
        let negative = terms[0].negative;
        for term in &mut terms {
            term.negative ^= negative;
        }
        Signed { negative, id: self.add(Op::Sum(terms)) }
    }

    /// Adds all operations of another graph; returns the new indices of its values.
    pub fn absorb(&mut self, other: &Graph) -> Vec<Id> {
        let mut places: Vec<Id> = Vec::with_capacity(other.ops.len());
        for op in &other.ops {
            let moved = |id: &Id| places[*id];
            let op = match op {
                Op::Number(_) | Op::Input(_) => op.clone(),
                Op::Sum(terms) => {
                    Op::Sum(terms.iter().map(|t| Signed { negative: t.negative, id: moved(&t.id) }).collect())
                }
                Op::Product(factors) => Op::Product(factors.iter().map(moved).collect()),
                Op::Reciprocal(a) => Op::Reciprocal(moved(a)),
                Op::Power(a, exponent) => Op::Power(moved(a), *exponent),
                Op::Call(function, a) => Op::Call(*function, moved(a)),
            };
            places.push(self.add(op));
        }
        places
    }

    /// All values that the roots depend on, operands first.
    pub fn reachable(&self, roots: impl IntoIterator<Item = Id>) -> Vec<Id> {
        let mut needed = vec![false; self.ops.len()];
        let mut pending: Vec<Id> = roots.into_iter().collect();
        while let Some(id) = pending.pop() {
            if !std::mem::replace(&mut needed[id], true) {
                pending.extend(self.ops[id].operands());
            }
        }
        (0..needed.len()).filter(|&id| needed[id]).collect()
    }
}
