//! Arguments at whose zeros the equations of motion change abruptly or fast: those of `abs` and `sign`, and those of
//! hyperbolic tangents.

use std::collections::BTreeSet;

use qrm_core::named_tape::{Argument, Function, ResultField, Shape, Value};
use qrm_core::{NamedTape, Operation};

/// Finds the arguments on the way to the equations of motion. If the forces contain absolute values of
/// solutions of a linear system, these are skipped: they belong to the search for normal forces of friction.
pub(super) fn switching(tape: &NamedTape, has_solved_forces: bool) -> [Function; 2] {
    let degrees = degrees_in_time(tape);
    let solved = if has_solved_forces { follows_from_quotients(tape, &degrees) } else { Vec::new() };
    let [mut linear, mut other, mut of_tanh] = [BTreeSet::new(), BTreeSet::new(), BTreeSet::new()];
    let roots = ["dynamics", "momenta", "generalized_forces", "loop_constraints"]
        .into_iter()
        .filter_map(|name| tape.function(name));
    for value in tape.needed(roots.flat_map(Function::results)) {
        let Value::Operation(operation) = tape.values()[value as usize] else { continue };
        match operation {
            Operation::Abs(argument) | Operation::Sign(argument) if solved.get(argument as usize) == Some(&true) => {}
            Operation::Abs(argument) | Operation::Sign(argument) => match degrees[argument as usize] {
                Degree::Constant => {}
                Degree::Linear => drop(linear.insert(argument)),
                Degree::Other => drop(other.insert(argument)),
            },
            Operation::Tanh(argument) if degrees[argument as usize] != Degree::Constant => {
                of_tanh.insert(argument);
            }
            _ => {}
        }
    }
    let part = |name: &str, values: BTreeSet<u32>| ResultField {
        name: name.to_owned(),
        doc: String::new(),
        values: Shape::Vector(values.into_iter().collect()),
    };
    let function = |name: &str, parts: Vec<ResultField>| Function {
        name: name.to_owned(),
        arguments: vec![Argument::Time, Argument::Coordinates, Argument::Rates],
        parts,
        ..Default::default()
    };
    [
        function("switching_functions", vec![part("linear_in_time", linear), part("other", other)]),
        function("tanh_arguments", vec![part("", of_tanh)]),
    ]
}

/// Whether each value depends on a quotient whose divisor varies with the motion.
fn follows_from_quotients(tape: &NamedTape, degrees: &[Degree]) -> Vec<bool> {
    let mut follows: Vec<bool> = Vec::with_capacity(tape.values().len());
    for (i, entry) in tape.values().iter().enumerate() {
        follows.push(match *entry {
            Value::Input => false,
            Value::Cosine => follows[i - 1],
            Value::Operation(operation) => {
                let mut is_one = match operation {
                    Operation::Div(_, divisor) | Operation::Recip(divisor) => {
                        degrees[divisor as usize] == Degree::Other
                    }
                    _ => false,
                };
                operation.for_each_operand(|operand| is_one |= follows[operand as usize]);
                is_one
            }
        });
    }
    follows
}

/// The dependence of a value on time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Degree {
    /// The value follows from parameters alone.
    Constant,
    /// The value is `a + b t` with constants `a` and `b`.
    Linear,
    /// The value depends on the motion, or on time in another way.
    Other,
}

/// The degree of each value.
fn degrees_in_time(tape: &NamedTape) -> Vec<Degree> {
    let constant = tape.are_constant();
    let mut degrees: Vec<Degree> = Vec::with_capacity(tape.values().len());
    for (i, entry) in tape.values().iter().enumerate() {
        let of = |operand: u32| degrees[operand as usize];
        let product = |a: u32, b: u32| match (of(a), of(b)) {
            (Degree::Constant, other) | (other, Degree::Constant) => other,
            _ => Degree::Other,
        };
        degrees.push(match *entry {
            _ if constant[i] => Degree::Constant,
            // Time is the input after the parameters.
            Value::Input if i == tape.sizes()[0] => Degree::Linear,
            Value::Input => Degree::Other,
            Value::Cosine => degrees[i - 1],
            Value::Operation(operation) => match operation {
                Operation::Neg(a) => of(a),
                Operation::Add(a, b) | Operation::Sub(a, b) => of(a).max(of(b)),
                Operation::Mul(a, b) => product(a, b),
                Operation::Div(a, b) if of(b) == Degree::Constant => of(a),
                Operation::MulAdd(a, b, c) | Operation::NegMulAdd(a, b, c) => product(a, b).max(of(c)),
                _ => Degree::Other,
            },
        });
    }
    degrees
}
