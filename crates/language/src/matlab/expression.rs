//! Expressions.

use super::{Writer, builtins};
use crate::ir::{Builtin, Expression};
use crate::names::Names;
use crate::precedence;

impl Writer<'_> {
    /// Formats an expression; `names` are those of its function.
    pub(super) fn expression(&self, names: &Names, value: &Expression) -> String {
        let write = |value: &Expression| self.expression(names, value);
        match value {
            Expression::Number(digits) => digits.strip_suffix(".0").unwrap_or(digits).to_owned(),
            Expression::Boolean(boolean) => boolean.to_string(),
            Expression::Pi => "pi".to_owned(),
            Expression::Infinity => "Inf".to_owned(),
            Expression::Name(name) => names.get(name).to_owned(),
            Expression::Field(of, field) => match (&**of, field.as_str()) {
                (Expression::Name(mechanism), "parameters") if mechanism == "m" => "p".to_owned(),
                (Expression::Name(mechanism), "constants") if mechanism == "m" => "k".to_owned(),
                _ => format!("{}.{}", write(of), self.fields.get(field)),
            },
            Expression::Element(of, place) => match &**of {
                Expression::Element(rows, row) => {
                    format!("{}({}, {})", write(rows), row + 1, place + 1)
                }
                _ => format!("{}({})", write(of), place + 1),
            },
            Expression::Negative(operand) => precedence::negative(operand, write),
            Expression::Binary(operator, left, right) => precedence::binary(*operator, left, right, write),
            Expression::Call(Builtin::ValueOr, arguments) => match &arguments[..] {
                [Expression::Field(of, field), own] => {
                    let [of, own] = [&**of, own].map(write);
                    format!("value_of({of}, '{}', {own})", self.fields.get(field))
                }
                _ => unreachable!("the parser makes it of a field and a value"),
            },
            Expression::Call(builtin, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(write).collect();
                format!("{}({})", builtins::function(*builtin), arguments.join(", "))
            }
        }
    }
}
