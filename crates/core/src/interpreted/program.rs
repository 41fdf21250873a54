//! Operations prepared for being executed often.

extern crate alloc;

use alloc::vec::Vec;

use crate::scalar::Scalar;
use crate::tape::{Operation, OperationKind, execute_one};

/// Operations in runs of one kind. Sums, differences and products are executed as products with a sum, of one and of
/// the zero that changes no sum: so there are few kinds, and the processor foresees which one follows.
#[derive(Clone, Debug)]
pub(super) struct Program {
    /// Kinds, and how many operations of the kind follow each other.
    runs: Vec<(OperationKind, u32)>,
    /// The factors and the summand of each operation that is a product with a sum.
    terms: Vec<[u32; 3]>,
    others: Vec<Operation>,
    /// The place of the first result.
    first: usize,
}

/// The places of two numbers that every program needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitConstants {
    pub(super) one: u32,
    /// The zero below zero: added to any number, it gives the number, signs of zeros included.
    pub(super) negative_zero: u32,
}

impl Program {
    /// The operations whose results have the places from `first` on.
    pub(super) fn new(operations: &[Operation], first: usize, units: UnitConstants) -> Self {
        let mut program = Self { runs: Vec::new(), terms: Vec::new(), others: Vec::new(), first };
        let UnitConstants { one, negative_zero } = units;
        for &operation in operations {
            let kind = operation.kind();
            match program.runs.last_mut() {
                Some((last, count)) if *last == kind => *count += 1,
                _ => program.runs.push((kind, 1)),
            }
            match operation {
                Operation::Add(a, b) => program.terms.push([a, one, b]),
                Operation::Mul(a, b) => program.terms.push([a, b, negative_zero]),
                Operation::Neg(a) => program.terms.push([a, one, negative_zero]),
                Operation::Sub(a, b) => program.terms.push([b, one, a]),
                Operation::MulAdd(a, b, c) | Operation::NegMulAdd(a, b, c) => program.terms.push([a, b, c]),
                other => program.others.push(other),
            }
        }
        program
    }

    /// Executes the operations.
    #[inline(never)]
    pub(super) fn execute<R: Scalar>(&self, values: &mut [R]) {
        R::vectorized(
            #[inline(always)]
            || self.execute_all(values),
        );
    }

    #[inline(always)]
    fn execute_all<R: Scalar>(&self, values: &mut [R]) {
        let (mut next, mut terms, mut others) = (self.first, &self.terms[..], &self.others[..]);
        for &(kind, count) in &self.runs {
            let count = count as usize;
            match kind {
                OperationKind::MulAdd => {
                    let (run, rest) = terms.split_at(count);
                    terms = rest;
                    for &[a, b, c] in run {
                        values[next] = values[a as usize].mul_add(values[b as usize], values[c as usize]);
                        next += 1;
                    }
                }
                OperationKind::NegMulAdd => {
                    let (run, rest) = terms.split_at(count);
                    terms = rest;
                    for &[a, b, c] in run {
                        values[next] = values[a as usize].neg_mul_add(values[b as usize], values[c as usize]);
                        next += 1;
                    }
                }
                OperationKind::Other => {
                    let (run, rest) = others.split_at(count);
                    others = rest;
                    for operation in run {
                        next = execute_one(values, next, operation);
                    }
                }
            }
        }
    }
}
