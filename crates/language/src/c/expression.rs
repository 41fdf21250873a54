//! Expressions.

use super::{Writer, builtins};
use crate::ir::Expression;
use crate::names::Names;
use crate::precedence;

impl Writer<'_> {
    /// Formats an expression; `names` are those of its function.
    pub(super) fn expression(&self, names: &Names, value: &Expression) -> String {
        let write = |value: &Expression| self.expression(names, value);
        match value {
            Expression::Number(digits) => digits.clone(),
            Expression::Boolean(boolean) => u8::from(*boolean).to_string(),
            Expression::Pi => "3.14159265358979323846".to_owned(),
            Expression::Infinity => "INFINITY".to_owned(),
            Expression::Name(name) => names.get(name).to_owned(),
            Expression::Field(of, field) => {
                let arrow = if matches!(**of, Expression::Name(_)) { "->" } else { "." };
                format!("{}{arrow}{}", write(of), self.fields.get(field))
            }
            Expression::Element(of, place) => format!("{}[{place}]", write(of)),
            Expression::Negative(operand) => precedence::negative(operand, write),
            Expression::Binary(operator, left, right) => precedence::binary(*operator, left, right, write),
            Expression::Call(builtin, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(write).collect();
                format!("{}({})", builtins::function(*builtin), arguments.join(", "))
            }
        }
    }
}
