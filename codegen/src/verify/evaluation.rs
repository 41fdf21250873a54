//! Evaluates all values of a tape on any number type.

use qrm_core::named_tape::{Argument, Value};
use qrm_core::{DoubleDouble, NamedTape, Operation, Scalar, execute};

/// The powers of ten that are doubles.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

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
        let text = format!("{number:e}");
        short_decimal(&text).or_else(|| exact_decimal(&text)).unwrap_or_else(|| Self::from(number))
    }
}

/// A number with at most 18 digits, and a power of ten that is a double.
fn short_decimal(text: &str) -> Option<DoubleDouble> {
    let (mantissa, exponent) = text.split_once('e')?;
    let digits: i64 = mantissa.replace('.', "").parse().ok()?;
    let places = mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    let power = exponent.parse::<i32>().ok()? - i32::try_from(places).ok()?;
    let nearest = digits as f64;
    let whole = DoubleDouble::sum(nearest, (digits - nearest as i64) as f64);
    let scale = DoubleDouble::from(POWERS_OF_TEN.get(power.unsigned_abs() as usize).copied()?);
    Some(if power < 0 { whole / scale } else { whole * scale })
}

/// Any number in the range of doubles.
fn exact_decimal(text: &str) -> Option<DoubleDouble> {
    let (sign, size) = text.strip_prefix('-').map_or((1.0, text), |size| (-1.0, size));
    let size = qrm_scene::expression::Number::parse(size)?;
    Some(DoubleDouble::sum(sign * size.value, sign * size.rest))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_decimals_are_those_of_exact_arithmetic() {
        let numbers = [0.1, -1.234_567_890_123_456_7, 6.674_3e-11, 9.806_65, 299_792_458.0, 1e22, 1.7e18, 0.0];
        for number in numbers {
            let text = format!("{number:e}");
            let [short, exact] = [short_decimal(&text), exact_decimal(&text)].map(|x| x.expect("a decimal"));
            let error = short - exact;
            assert!(error.hi().abs() <= 1e-31 * number.abs(), "{text}: {error:?}");
        }
        assert!(short_decimal("1e-300").is_none());
    }
}
