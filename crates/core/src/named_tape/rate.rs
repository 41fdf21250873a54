//! Derivatives of a tape's values with respect to time along a motion.

use std::collections::HashMap;
use std::vec::Vec;

use super::{Argument, NamedTape, Value, place};
use crate::tape::Operation as Op;

impl NamedTape {
    /// The derivative of a value with respect to time, in terms of the rates and accelerations of the coordinates;
    /// `None` if the value depends on accelerations or multipliers.
    pub fn rate(&mut self, value: u32) -> Option<u32> {
        let mut rates: HashMap<u32, u32> = HashMap::new();
        for each in self.needed(std::iter::once(value)) {
            let rate = match self.values[each as usize] {
                Value::Input => self.rate_of_input(each)?,
                Value::Cosine => match self.values[each as usize - 1] {
                    Value::Operation(Op::SinCos(angle)) => {
                        let down = self.product(each - 1, rates[&angle]);
                        self.negative(down)
                    }
                    _ => unreachable!("a cosine follows the sine of its angle"),
                },
                Value::Operation(operation) => self.rate_of_operation(each, operation, &rates),
            };
            rates.insert(each, rate);
        }
        rates.get(&value).copied()
    }

    fn rate_of_input(&mut self, input: u32) -> Option<u32> {
        let n = place(self.coordinates);
        let [t, q, qdd] = [Argument::Time, Argument::Coordinates, Argument::Accelerations].map(|own| self.input(own));
        match input {
            _ if input < t => Some(self.number(0.0)),
            _ if input == t => Some(self.number(1.0)),
            _ if (q..qdd).contains(&input) => Some(input + n),
            _ => None,
        }
    }

    fn rate_of_operation(&mut self, value: u32, operation: Op, rates: &HashMap<u32, u32>) -> u32 {
        let operands: Vec<u32> = {
            let mut operands = Vec::new();
            operation.for_each_operand(|operand| operands.push(operand));
            operands
        };
        if operands.iter().all(|operand| self.is_zero(rates[operand])) {
            return self.number(0.0);
        }
        let rate = |operand: u32| rates[&operand];
        let one = self.number(1.0);
        match operation {
            Op::Number(_) | Op::Pi | Op::Sign(_) | Op::Floor(_) => self.number(0.0),
            Op::Neg(a) => self.negative(rate(a)),
            Op::Add(a, b) => self.sum(rate(a), rate(b)),
            Op::Sub(a, b) => self.difference(rate(a), rate(b)),
            Op::Mul(a, b) => self.rate_of_product(a, b, rates),
            Op::MulAdd(a, b, c) => {
                let product = self.rate_of_product(a, b, rates);
                self.sum(product, rate(c))
            }
            Op::NegMulAdd(a, b, c) => {
                let product = self.rate_of_product(a, b, rates);
                self.difference(rate(c), product)
            }
            Op::Div(a, b) => {
                let moved = self.product(value, rate(b));
                let above = self.difference(rate(a), moved);
                self.quotient(above, b)
            }
            Op::Recip(a) => {
                let square = self.product(value, value);
                let down = self.product(square, rate(a));
                self.negative(down)
            }
            Op::Sqrt(a) => {
                let twice = self.sum(value, value);
                self.quotient(rate(a), twice)
            }
            Op::Sin(a) => {
                let cosine = self.operation(Op::Cos(a));
                self.product(cosine, rate(a))
            }
            Op::SinCos(a) => self.product(value + 1, rate(a)),
            Op::Cos(a) => {
                let sine = self.operation(Op::Sin(a));
                let down = self.product(sine, rate(a));
                self.negative(down)
            }
            Op::Tan(a) => {
                let slope = self.operation(Op::MulAdd(value, value, one));
                self.product(slope, rate(a))
            }
            Op::Asin(a) | Op::Acos(a) => {
                let rest = self.operation(Op::NegMulAdd(a, a, one));
                let root = self.operation(Op::Sqrt(rest));
                let rise = self.quotient(rate(a), root);
                if matches!(operation, Op::Asin(_)) { rise } else { self.negative(rise) }
            }
            Op::Atan(a) => {
                let below = self.operation(Op::MulAdd(a, a, one));
                self.quotient(rate(a), below)
            }
            Op::Exp(a) => self.product(value, rate(a)),
            Op::Ln(a) => self.quotient(rate(a), a),
            Op::Sinh(a) => {
                let slope = self.operation(Op::Cosh(a));
                self.product(slope, rate(a))
            }
            Op::Cosh(a) => {
                let slope = self.operation(Op::Sinh(a));
                self.product(slope, rate(a))
            }
            Op::Tanh(a) => {
                let slope = self.operation(Op::NegMulAdd(value, value, one));
                self.product(slope, rate(a))
            }
            Op::Abs(a) => {
                let sign = self.operation(Op::Sign(a));
                self.product(sign, rate(a))
            }
            Op::Min(a, b) | Op::Max(a, b) => {
                // Half the sum, and half the signed difference.
                let (sum, apart) = (self.sum(rate(a), rate(b)), self.difference(rate(a), rate(b)));
                let difference = self.difference(a, b);
                let sign = self.operation(Op::Sign(difference));
                let distance = self.product(sign, apart);
                let is_max = matches!(operation, Op::Max(..));
                let twice = if is_max { self.sum(sum, distance) } else { self.difference(sum, distance) };
                let half = self.number(0.5);
                self.product(half, twice)
            }
            Op::Hypot(a, b) => {
                let (along_a, along_b) = (self.product(a, rate(a)), self.product(b, rate(b)));
                let sum = self.sum(along_a, along_b);
                self.quotient(sum, value)
            }
            Op::Atan2(y, x) => {
                let (left, right) = (self.product(x, rate(y)), self.product(y, rate(x)));
                let above = self.difference(left, right);
                let (xx, yy) = (self.product(x, x), self.product(y, y));
                let below = self.sum(xx, yy);
                self.quotient(above, below)
            }
            Op::PowI(a, exponent) => {
                let factor = self.number(f64::from(exponent));
                let power = self.operation(Op::PowI(a, exponent - 1));
                let slope = self.product(factor, power);
                self.product(slope, rate(a))
            }
            Op::PowF(a, exponent) => {
                let factor = self.number(exponent);
                let power = self.operation(Op::PowF(a, exponent - 1.0));
                let slope = self.product(factor, power);
                self.product(slope, rate(a))
            }
            Op::Pow(a, b) => {
                let less = self.difference(b, one);
                let power = self.operation(Op::Pow(a, less));
                let slope = self.product(b, power);
                let by_base = self.product(slope, rate(a));
                if self.is_zero(rate(b)) {
                    return by_base;
                }
                let logarithm = self.operation(Op::Ln(a));
                let growth = self.product(value, logarithm);
                let by_exponent = self.product(growth, rate(b));
                self.sum(by_base, by_exponent)
            }
        }
    }

    fn rate_of_product(&mut self, a: u32, b: u32, rates: &HashMap<u32, u32>) -> u32 {
        let (first, second) = (self.product(rates[&a], b), self.product(a, rates[&b]));
        self.sum(first, second)
    }

    fn sum(&mut self, a: u32, b: u32) -> u32 {
        match [a, b].map(|value| self.is_zero(value)) {
            [true, _] => b,
            [_, true] => a,
            _ => self.operation(Op::Add(a, b)),
        }
    }

    fn difference(&mut self, a: u32, b: u32) -> u32 {
        match [a, b].map(|value| self.is_zero(value)) {
            [_, true] => a,
            [true, _] => self.negative(b),
            _ => self.operation(Op::Sub(a, b)),
        }
    }

    fn product(&mut self, a: u32, b: u32) -> u32 {
        let (zero, one) = (self.number(0.0), self.number(1.0));
        match [a, b] {
            [factor, _] | [_, factor] if self.is_zero(factor) => zero,
            [factor, other] | [other, factor] if factor == one => other,
            _ => self.operation(Op::Mul(a, b)),
        }
    }

    fn quotient(&mut self, a: u32, b: u32) -> u32 {
        if self.is_zero(a) { a } else { self.operation(Op::Div(a, b)) }
    }
}
