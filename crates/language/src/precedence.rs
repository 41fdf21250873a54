//! Operators and the parentheses around their operands, identical in all languages.

use super::ir::{Expression, Operator};

/// The precedence of an expression, lowest first.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Precedence {
    Sum,
    Product,
    Unary,
    Primary,
}

impl Precedence {
    fn new(value: &Expression) -> Self {
        match value {
            Expression::Binary(Operator::Add | Operator::Subtract, ..) => Self::Sum,
            Expression::Binary(Operator::Multiply | Operator::Divide, ..) => Self::Product,
            Expression::Negative(_) => Self::Unary,
            _ => Self::Primary,
        }
    }
}

/// Formats the negative of a number; `write` formats the operand.
pub(super) fn negative(operand: &Expression, write: impl Fn(&Expression) -> String) -> String {
    format!("-{}", parenthesized(operand, Precedence::Primary, write))
}

/// Formats a sum, difference, product or quotient; `write` formats an operand.
pub(super) fn binary(
    operator: Operator,
    left: &Expression,
    right: &Expression,
    write: impl Fn(&Expression) -> String,
) -> String {
    // The right operand keeps its parentheses, since sums and products are rounded in their order.
    let (sign, own, next) = match operator {
        Operator::Add => ("+", Precedence::Sum, Precedence::Product),
        Operator::Subtract => ("-", Precedence::Sum, Precedence::Product),
        Operator::Multiply => ("*", Precedence::Product, Precedence::Unary),
        Operator::Divide => ("/", Precedence::Product, Precedence::Unary),
    };
    format!("{} {sign} {}", parenthesized(left, own, &write), parenthesized(right, next, &write))
}

/// Formats an operand, in parentheses if its precedence is lower than `least`.
fn parenthesized(operand: &Expression, least: Precedence, write: impl Fn(&Expression) -> String) -> String {
    let text = write(operand);
    if Precedence::new(operand) < least { format!("({text})") } else { text }
}
