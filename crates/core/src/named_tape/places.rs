//! The places of values in a tape for evaluators.

use std::vec;
use std::vec::Vec;

use super::order::ordered;
use super::{NamedTape, Value, place};
use crate::tape::{Operation, TapeFunction};

/// Values that have a place, and the next free one.
#[derive(Clone)]
pub(super) struct Places<'t> {
    tape: &'t NamedTape,
    /// The place of each value that has one.
    known: Vec<Option<u32>>,
    next: u32,
}

impl<'t> Places<'t> {
    /// Assigns places to the inputs.
    pub(super) fn new(tape: &'t NamedTape) -> Self {
        let known = (0..tape.values.len()).map(|value| (value < tape.inputs()).then(|| place(value))).collect();
        Self { tape, known, next: place(tape.inputs()) }
    }

    /// Assigns places to all constants on the way to these values, that is, to values that follow from parameters
    /// alone.
    pub(super) fn constants(&mut self, roots: impl Iterator<Item = u32>) -> Vec<Operation> {
        let is_constant = self.tape.are_constant();
        let constants: Vec<u32> = self.needed(roots).into_iter().filter(|value| is_constant[*value as usize]).collect();
        self.operations(constants.into_iter())
    }

    /// The function that computes the parameters, each after its operands.
    pub(super) fn parameters(&self, roots: &[u32]) -> TapeFunction {
        // Constants follow from parameters, so none is known yet.
        let mut own = Self { next: self.next, ..Self::new(self.tape) };
        let values = own.needed(roots.iter().copied());
        TapeFunction { operations: own.place_all(values).into(), results: own.results(roots).into() }
    }

    /// A function whose values keep no places.
    pub(super) fn function(&self, roots: &[u32]) -> TapeFunction {
        self.clone().first_part(&[], roots)
    }

    /// A function whose values, and `others`, keep their places for the functions that follow.
    pub(super) fn first_part(&mut self, others: &[u32], roots: &[u32]) -> TapeFunction {
        let operations = self.operations(others.iter().chain(roots).copied());
        TapeFunction { operations: operations.into(), results: self.results(roots).into() }
    }

    /// A function whose places the functions that follow do not use.
    pub(super) fn part(&mut self, roots: &[u32]) -> TapeFunction {
        self.part_after(&[], roots)
    }

    /// A function that runs after one with the results `before`.
    pub(super) fn part_after(&mut self, before: &[u32], roots: &[u32]) -> TapeFunction {
        let mut own = self.clone();
        own.operations(before.iter().copied());
        let part = own.first_part(&[], roots);
        self.next = own.next;
        part
    }

    /// Assigns places to all values that the roots need.
    fn operations(&mut self, roots: impl Iterator<Item = u32>) -> Vec<Operation> {
        let needed = self.needed(roots);
        self.place_all(ordered(self.tape, &needed))
    }

    fn place_all(&mut self, values: Vec<u32>) -> Vec<Operation> {
        let mut operations = Vec::new();
        for value in values {
            self.known[value as usize] = Some(self.next);
            self.next += 1;
            if let Value::Operation(operation) = self.tape.values[value as usize] {
                operations.push(operation.map(|operand| self.place(operand)));
            }
        }
        operations
    }

    fn results(&self, roots: &[u32]) -> Vec<u32> {
        roots.iter().map(|root| self.place(*root)).collect()
    }

    fn place(&self, value: u32) -> u32 {
        self.known[value as usize].unwrap_or_else(|| unreachable!("operands come first"))
    }

    /// The values that the roots need and that have no place yet, in their order; a cosine follows its sine.
    pub(super) fn needed(&self, roots: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut is_needed = vec![false; self.known.len()];
        let mut pending: Vec<u32> = roots.collect();
        while let Some(value) = pending.pop() {
            if self.known[value as usize].is_some() || std::mem::replace(&mut is_needed[value as usize], true) {
                continue;
            }
            match self.tape.values[value as usize] {
                Value::Input => {}
                Value::Cosine => pending.push(value - 1),
                Value::Operation(operation) => {
                    if matches!(operation, Operation::SinCos(_)) {
                        pending.push(value + 1);
                    }
                    operation.for_each_operand(|operand| pending.push(operand));
                }
            }
        }
        (0..place(is_needed.len())).filter(|&value| is_needed[value as usize]).collect()
    }
}
