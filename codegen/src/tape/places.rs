//! The places of traced values in a tape.

mod schedule;

use qrm_core::{Operation, OwnedFunction};

use super::trace::{Entry, Trace, Traced};
use schedule::scheduled;

/// Values that have a place, and the next free one.
#[derive(Clone)]
pub(super) struct Places<'t> {
    trace: &'t Trace,
    /// The place of each value that has one.
    known: Vec<Option<u32>>,
    next: u32,
}

/// The place at the end of a list.
pub(super) fn place(length: usize) -> u32 {
    u32::try_from(length).unwrap_or_else(|_| unreachable!("no scene has 2^32 operations"))
}

impl<'t> Places<'t> {
    /// The places of the inputs.
    pub(super) fn new(trace: &'t Trace, inputs: usize) -> Self {
        let known = (0..trace.entries.len()).map(|entry| (entry < inputs).then(|| place(entry))).collect();
        Self { trace, known, next: place(inputs) }
    }

    /// Gives places to all that follows from parameters alone on the way to these values.
    pub(super) fn constants<'r>(&mut self, roots: impl Iterator<Item = &'r Traced>) -> Vec<Operation> {
        let is_constant = self.are_constant();
        let constants: Vec<Traced> =
            self.needed(roots.copied()).into_iter().filter(|value| is_constant[value.0 as usize]).collect();
        self.operations(constants.into_iter())
    }

    /// The values of parameters, each after what it follows from.
    pub(super) fn parameters(&self, inputs: usize) -> OwnedFunction {
        // Constants follow from parameters, so none of them is known.
        let mut own = Self { next: self.next, ..Self::new(self.trace, inputs) };
        let values = own.needed(self.trace.parameters.iter().copied());
        OwnedFunction { operations: own.place_all(values), results: own.results(&self.trace.parameters) }
    }

    /// A function; its values have no place afterwards.
    pub(super) fn function(&self, roots: &[Traced]) -> OwnedFunction {
        self.clone().first_part(&[], roots)
    }

    /// A function whose values, and others, keep their places for those that follow.
    pub(super) fn first_part(&mut self, others: &[Traced], roots: &[Traced]) -> OwnedFunction {
        let operations = self.operations(others.iter().chain(roots).copied());
        OwnedFunction { operations, results: self.results(roots) }
    }

    /// A function whose places are not used by those that follow.
    pub(super) fn part(&mut self, roots: &[Traced]) -> OwnedFunction {
        self.part_after(&[], roots)
    }

    /// A function that is executed after one with these results.
    pub(super) fn part_after(&mut self, before: &[Traced], roots: &[Traced]) -> OwnedFunction {
        let mut own = self.clone();
        own.operations(before.iter().copied());
        let part = own.first_part(&[], roots);
        self.next = own.next;
        part
    }

    /// Gives places to all that is needed for some values.
    fn operations(&mut self, roots: impl Iterator<Item = Traced>) -> Vec<Operation> {
        let needed = self.needed(roots);
        self.place_all(scheduled(self.trace, &needed))
    }

    fn place_all(&mut self, values: Vec<Traced>) -> Vec<Operation> {
        let mut operations = Vec::new();
        for value in values {
            self.known[value.0 as usize] = Some(self.next);
            self.next += 1;
            if let Entry::Operation(operation) = self.trace.entries[value.0 as usize] {
                operations.push(operation.map(|operand| self.place(operand)));
            }
        }
        operations
    }

    fn results(&self, roots: &[Traced]) -> Vec<u32> {
        roots.iter().map(|root| self.place(root.0)).collect()
    }

    fn place(&self, value: u32) -> u32 {
        self.known[value as usize].unwrap_or_else(|| unreachable!("operands come first"))
    }

    /// Values without a place that are needed for others, in their order; sine and cosine come together.
    pub(super) fn needed(&self, roots: impl Iterator<Item = Traced>) -> Vec<Traced> {
        let mut is_needed = vec![false; self.known.len()];
        let mut pending: Vec<u32> = roots.map(|root| root.0).collect();
        while let Some(value) = pending.pop() {
            if self.known[value as usize].is_some() || std::mem::replace(&mut is_needed[value as usize], true) {
                continue;
            }
            match self.trace.entries[value as usize] {
                Entry::Input => {}
                Entry::Cosine => pending.push(value - 1),
                Entry::Operation(operation) => {
                    if matches!(operation, Operation::SinCos(_)) {
                        pending.push(value + 1);
                    }
                    operation.for_each_operand(|operand| pending.push(operand));
                }
            }
        }
        (0..place(is_needed.len())).filter(|&value| is_needed[value as usize]).map(Traced).collect()
    }

    /// Which values follow from parameters alone.
    pub(super) fn are_constant(&self) -> Vec<bool> {
        let mut constant: Vec<bool> = Vec::with_capacity(self.trace.entries.len());
        for (i, entry) in self.trace.entries.iter().enumerate() {
            constant.push(match entry {
                Entry::Input => i < self.trace.parameters.len(),
                Entry::Cosine => constant[i - 1],
                Entry::Operation(operation) => {
                    let mut all = true;
                    operation.for_each_operand(|operand| all &= constant[operand as usize]);
                    all
                }
            });
        }
        constant
    }
}
