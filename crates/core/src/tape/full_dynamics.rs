//! The dynamics of a large tree with its mass matrix, for computations that need all entries as operations.

use std::borrow::Cow;
use std::vec;
use std::vec::Vec;

use super::operation::places;
use super::{Operation, Tape, TapeFunction};

impl Tape {
    /// Mass matrix, generalized forces, constraint Jacobian and constraint bias. The mass matrix of a large tree is
    /// made of its momenta for unit rates, without the operations on zeros.
    pub fn full_dynamics(&self) -> Cow<'_, TapeFunction> {
        let Some(momenta) = &self.momenta else { return Cow::Borrowed(&self.dynamics) };
        let ([n, _], first, end) = (self.sizes(), self.arguments().qd as u32, self.arguments().end as u32);
        let rates = first..first + n as u32;
        let mut written = Written { next: end, operations: Vec::new() };
        let (zero, one) = (written.add(Operation::Number(0.0)), written.add(Operation::Number(1.0)));

        // Values that do not depend on the rates are the same in all columns.
        let mut new = vec![0; places(&momenta.operations)];
        let mut varies = vec![false; new.len()];
        let mut place = 0;
        for operation in momenta.operations.iter() {
            let width = places(&[*operation]);
            let mut is_varying = false;
            operation.for_each_operand(|o| is_varying |= rates.contains(&o) || o >= end && varies[(o - end) as usize]);
            varies[place..place + width].fill(is_varying);
            if !is_varying {
                let own = written.add(operation.map(|o| if o < end { o } else { new[(o - end) as usize] }));
                (0..width).for_each(|k| new[place + k] = own + k as u32);
            }
            place += width;
        }
        let mut matrix = vec![zero; n * n];
        for j in 0..n {
            let mut place = 0;
            for operation in momenta.operations.iter() {
                let width = places(&[*operation]);
                if varies[place] {
                    let own = written.folded(
                        operation.map(|o| match o {
                            o if rates.contains(&o) => {
                                if (o - first) as usize == j {
                                    one
                                } else {
                                    zero
                                }
                            }
                            o if o < end => o,
                            o => new[(o - end) as usize],
                        }),
                        [zero, one],
                    );
                    (0..width).for_each(|k| new[place + k] = own + k as u32);
                }
                place += width;
            }
            for (i, &result) in momenta.results.iter().enumerate().skip(j) {
                let entry = match result {
                    // The momentum of a unit mass is the rate itself.
                    rate if rates.contains(&rate) && (rate - first) as usize == j => one,
                    rate if rates.contains(&rate) => zero,
                    other if other < end => other,
                    other => new[(other - end) as usize],
                };
                (matrix[i * n + j], matrix[j * n + i]) = (entry, entry);
            }
        }
        let moved = written.next - end;
        let other = |o: u32| if o < end { o } else { o + moved };
        for operation in self.dynamics.operations.iter() {
            written.add(operation.map(other));
        }
        matrix.extend(self.dynamics.results.iter().map(|&result| other(result)));
        Cow::Owned(TapeFunction { operations: written.operations.into(), results: matrix.into() })
    }
}

/// Operations in their order, and the next free place.
struct Written {
    next: u32,
    operations: Vec<Operation>,
}

impl Written {
    /// Adds an operation. Returns its place.
    fn add(&mut self, operation: Operation) -> u32 {
        let place = self.next;
        self.next += places(&[operation]) as u32;
        self.operations.push(operation);
        place
    }

    /// Adds an operation unless its result follows from operands that are zero or one. Returns its place.
    fn folded(&mut self, operation: Operation, [zero, one]: [u32; 2]) -> u32 {
        match operation {
            Operation::Mul(a, b) if a == zero || b == zero => zero,
            Operation::Mul(a, b) if a == one => b,
            Operation::Mul(a, b) if b == one => a,
            Operation::Add(a, b) if a == zero => b,
            Operation::Add(a, b) | Operation::Sub(a, b) if b == zero => a,
            Operation::Sub(a, b) if a == zero => self.add(Operation::Neg(b)),
            Operation::Neg(a) | Operation::Div(a, _) if a == zero => zero,
            Operation::MulAdd(a, b, c) | Operation::NegMulAdd(a, b, c) if a == zero || b == zero => c,
            Operation::MulAdd(a, b, c) if c == zero => self.folded(Operation::Mul(a, b), [zero, one]),
            other => self.add(other),
        }
    }
}
