//! Evaluates all values of a tape on any number type.

use qrm_core::named_tape::{Argument, Value};
use qrm_core::{DoubleDouble, NamedTape, Operation, Scalar, execute};

/// A number type on which a tape is verified.
pub(crate) trait Number: Scalar {
    /// The number that a double represents in a scene: its shortest decimal.
    fn decimal(number: f64) -> Self;
}

impl Number for f64 {
    fn decimal(number: f64) -> Self {
        number
    }
}

impl Number for DoubleDouble {
    fn decimal(number: f64) -> Self {
        let size = qrm_scene::expression::Number::parse(&format!("{:?}", number.abs()));
        let size = size.map_or(Self::from(number.abs()), |size| Self::sum(size.value, size.rest));
        if number < 0.0 { -size } else { size }
    }
}

/// The values of a tape.
pub(crate) struct Evaluation<'t, N> {
    tape: &'t NamedTape,
    values: Vec<N>,
}

impl<'t, N: Number> Evaluation<'t, N> {
    /// Computes the values for given parameters and arguments; missing ones are not a number.
    pub(crate) fn new(tape: &'t NamedTape, parameters: &[N], arguments: &[(Argument, &[N])]) -> Self {
        let mut values = vec![N::from_f64(f64::NAN); tape.inputs()];
        values[..parameters.len()].copy_from_slice(parameters);
        for &(argument, numbers) in arguments {
            let first = tape.input(argument) as usize;
            values[first..first + numbers.len()].copy_from_slice(numbers);
            if argument == Argument::Coordinates {
                for (i, q) in numbers.iter().enumerate() {
                    let sine = tape.sine(i) as usize;
                    values[sine] = q.sin();
                    values[sine + numbers.len()] = q.cos();
                }
            }
        }
        let mut evaluation = Self { tape, values };
        evaluation.values.resize(tape.values().len(), N::zero());
        for (at, value) in tape.values().iter().enumerate() {
            evaluation.evaluate(at, *value);
        }
        evaluation
    }

    /// The values of the parameters in the scene, some of them replaced; each depends on earlier ones.
    pub(crate) fn parameters(tape: &'t NamedTape, replace: impl Fn(usize) -> Option<N>) -> Vec<N> {
        let mut evaluation = Self { tape, values: vec![N::from_f64(f64::NAN); tape.values().len()] };
        let Some(function) = tape.function("parameters") else { return Vec::new() };
        for (i, result) in function.results().enumerate() {
            for at in tape.needed(std::iter::once(result)) {
                evaluation.evaluate(at as usize, tape.values()[at as usize]);
            }
            evaluation.values[i] = replace(i).unwrap_or(evaluation.values[result as usize]);
        }
        evaluation.values.truncate(tape.sizes()[0]);
        evaluation.values
    }

    fn evaluate(&mut self, at: usize, value: Value) {
        match value {
            Value::Operation(Operation::Number(number)) => self.values[at] = N::decimal(number),
            Value::Operation(operation) => drop(execute(&mut self.values, at, &[operation])),
            Value::Input | Value::Cosine => {}
        }
    }

    /// The results of a function, or of a part of it such as `dynamics.mass_matrix`; empty if there is no such
    /// function.
    pub(crate) fn results(&self, name: &str) -> Vec<N> {
        let (name, part) = name.split_once('.').unwrap_or((name, ""));
        let Some(function) = self.tape.function(name) else { return Vec::new() };
        let all = function.parts.iter().filter(|own| part.is_empty() || own.name == part);
        all.flat_map(|part| part.values.values()).map(|&value| self.values[value as usize]).collect()
    }
}
