//! Expressions.

use super::{Writer, builtins};
use crate::ir::{Expression, Operator};
use crate::names::Names;

/// How tightly an expression holds together.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Strength {
    Sum,
    Product,
    Sign,
    Whole,
}

impl Writer<'_> {
    /// The text of an expression; `names` are those of its function.
    pub(super) fn expression(&self, names: &Names, value: &Expression) -> String {
        let within = |inner: &Expression, least: Strength| {
            let text = self.expression(names, inner);
            if strength(inner) < least { format!("({text})") } else { text }
        };
        match value {
            Expression::Number(digits) => digits.clone(),
            Expression::Boolean(boolean) => u8::from(*boolean).to_string(),
            Expression::Pi => "3.14159265358979323846".to_owned(),
            Expression::Infinity => "INFINITY".to_owned(),
            Expression::Name(name) => names.get(name).to_owned(),
            Expression::Field(of, field) => {
                let arrow = if matches!(**of, Expression::Name(_)) { "->" } else { "." };
                format!("{}{arrow}{}", self.expression(names, of), self.fields.get(field))
            }
            Expression::Element(of, place) => format!("{}[{place}]", self.expression(names, of)),
            Expression::Negative(inner) => format!("-{}", within(inner, Strength::Whole)),
            Expression::Binary(operator, left, right) => {
                // The right operand keeps its parentheses: sums and products are rounded in their order.
                let (sign, own, next) = match operator {
                    Operator::Add => ("+", Strength::Sum, Strength::Product),
                    Operator::Subtract => ("-", Strength::Sum, Strength::Product),
                    Operator::Multiply => ("*", Strength::Product, Strength::Sign),
                    Operator::Divide => ("/", Strength::Product, Strength::Sign),
                };
                format!("{} {sign} {}", within(left, own), within(right, next))
            }
            Expression::Call(builtin, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(|value| self.expression(names, value)).collect();
                format!("{}({})", builtins::function(*builtin), arguments.join(", "))
            }
        }
    }
}

fn strength(value: &Expression) -> Strength {
    match value {
        Expression::Binary(Operator::Add | Operator::Subtract, ..) => Strength::Sum,
        Expression::Binary(Operator::Multiply | Operator::Divide, ..) => Strength::Product,
        Expression::Negative(_) => Strength::Sign,
        _ => Strength::Whole,
    }
}
