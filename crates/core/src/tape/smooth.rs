//! Smooth continuations of equations of motion across their corners and jumps.

use std::vec::Vec;

use super::{Operation, Tape, TapeEvaluator};
use crate::Scalar;

impl<R: Scalar> TapeEvaluator<'_, Vec<R>> {
    /// The tape whose signs are those of a state: a smooth continuation of the equations of motion from there.
    ///
    /// It differs from the tape in `dynamics`, `momenta`, `loop_constraints` and `switching_functions`, where `sign(x)`
    /// is a number, and `abs(x)` is `x` or `-x`.
    pub fn with_signs_of(&mut self, t: R, q: &[R], qd: &[R]) -> Tape {
        let mut tape = self.tape.clone();
        let functions = [&mut tape.dynamics, &mut tape.loop_constraints, &mut tape.switching_functions];
        for function in functions.into_iter().chain(&mut tape.momenta) {
            self.evaluate_at(t, [q, qd], &function.operations);
            for operation in function.operations.to_mut() {
                let value = |place: u32| self.values[place as usize].to_f64();
                *operation = match *operation {
                    Operation::Sign(a) => Operation::Number(Scalar::sign(value(a))),
                    Operation::Abs(a) if value(a) < 0.0 => Operation::Neg(a),
                    // The operand itself, in a place of its own.
                    Operation::Abs(a) => Operation::PowI(a, 1),
                    other => other,
                };
            }
        }
        tape
    }
}
