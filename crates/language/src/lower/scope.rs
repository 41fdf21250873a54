//! The names of values in a function of a program.

use std::collections::HashMap;

use qrm_core::NamedTape;
use qrm_core::named_tape::{self, Argument, Value, place};

use super::expression;
use crate::ir::{Expression, Shape, Statement, StructKind};
use crate::sparsity::is_sparse;

/// The names of values in a function, and whether they are used.
pub(super) struct Scope<'t> {
    tape: &'t NamedTape,
    pub(super) names: HashMap<u32, Expression>,
    /// The short names at the beginning of the function, each with its statement and whether it is used.
    pub(super) bindings: Vec<(Statement, bool)>,
    /// The bindings of values.
    pub(super) bound: HashMap<u32, usize>,
}

impl<'t> Scope<'t> {
    pub(super) fn new(tape: &'t NamedTape) -> Self {
        Self { tape, names: HashMap::new(), bindings: Vec::new(), bound: HashMap::new() }
    }

    /// Adds a short name for a struct.
    pub(super) fn alias(&mut self, name: &str, kind: StructKind, of: Expression) {
        self.bindings.push((Statement::Alias { name: name.to_owned(), kind, of }, false));
    }

    pub(super) fn name_parameters(&mut self, of: &Expression) {
        let parameters = self.tape.names.range(..place(self.tape.sizes()[0]));
        self.names.extend(parameters.map(|(input, name)| (*input, of.clone().field(name))));
    }

    /// Adds names for the fields of a position.
    pub(super) fn name_fields(&mut self) {
        let position = self.tape.function("position").map(|own| &own.parts[..]).unwrap_or_default();
        for part in position {
            for value in part.values.values() {
                self.name(*value, &part.name, Expression::name("position").field(&part.name));
            }
        }
    }

    /// Adds names for the values of an argument.
    pub(super) fn bind(&mut self, argument: Argument) {
        let [_, n, m] = self.tape.sizes();
        let (list, count) = match argument {
            Argument::Position => return,
            Argument::Time => {
                self.names.insert(self.tape.input(argument), Expression::name("t"));
                return;
            }
            Argument::Angles => {
                for i in 0..n {
                    for (field, input) in [("sin", self.tape.sine(i)), ("cos", self.tape.sine(i) + place(n))] {
                        let name = self.tape.names[&input].clone();
                        self.name(input, &name, Expression::name("angles").field(field).element(i));
                    }
                }
                return;
            }
            Argument::Coordinates => ("q", n),
            Argument::Rates => ("qd", n),
            Argument::Accelerations => ("qdd", n),
            Argument::Multipliers => ("multipliers", m),
            Argument::Residuals => ("residuals", m),
        };
        for i in 0..count {
            let input = self.tape.input(argument) + place(i);
            let name = self.tape.names[&input].clone();
            self.name(input, &name, Expression::name(list).element(i));
        }
    }

    /// Adds a name for a value that is stored elsewhere.
    fn name(&mut self, value: u32, name: &str, stands_at: Expression) {
        self.bindings.push((Statement::Let { name: name.to_owned(), value: stands_at }, false));
        self.names.insert(value, Expression::name(name));
        self.bound.insert(value, self.bindings.len() - 1);
    }

    /// The statements of a function.
    pub(super) fn statements(&mut self, own: &named_tape::Function) -> Vec<Statement> {
        let mut statements = Vec::new();
        for statement in &own.statements {
            statements.extend(statement.comment.iter().map(|text| Statement::Comment(text.clone())));
            let values = self.computed(statement.value);
            for ((name, value), at) in statement.names.iter().zip(values).zip(statement.value..) {
                statements.push(Statement::Let { name: name.clone(), value });
                self.names.insert(at, Expression::name(name));
                self.bound.remove(&at);
            }
        }
        statements
    }

    /// A name for a result that is unused elsewhere in the function.
    pub(super) fn free(&self, wish: &str, own: &named_tape::Function) -> String {
        let statements = own.statements.iter().flat_map(|statement| &statement.names);
        let bound = self.bindings.iter().map(|(statement, _)| match statement {
            Statement::Alias { name, .. } | Statement::Let { name, .. } => name,
            _ => unreachable!("functions begin with names"),
        });
        let taken: Vec<&String> = statements.chain(bound).collect();
        let arguments = ["m", "p", "t", "q", "qd", "qdd", "multipliers", "residuals", "angles", "position"];
        let is_argument = |name: &str| {
            arguments.contains(&name) && own.arguments.iter().any(|argument| argument_name(*argument) == name)
        };
        let mut name = wish.to_owned();
        while taken.contains(&&name) || is_argument(&name) {
            name.push('_');
        }
        name
    }

    /// Assigns the elements of a result.
    pub(super) fn fill(&mut self, statements: &mut Vec<Statement>, name: &str, shape: Shape, values: &[u32]) {
        let at = |i: usize| match shape {
            Shape::Matrix(_, columns) => Expression::name(name).element(i / columns).element(i % columns),
            Shape::Vector(_) => Expression::name(name).element(i),
            _ => Expression::name(name),
        };
        let is_zero = |value: u32| self.tape.is_zero(value);
        let filled = values.iter().filter(|value| !is_zero(**value)).count();
        let is_sparse = matches!(shape, Shape::Matrix(..)) && is_sparse(values.len(), filled);
        if is_sparse {
            statements.push(Statement::Clear { place: Expression::name(name), shape });
        }
        for (i, value) in values.iter().enumerate() {
            if !(is_sparse && self.tape.is_zero(*value)) {
                statements.push(Statement::Assign { place: at(i), value: self.value(*value) });
            }
        }
    }

    /// The expression of a value: its name if it has one.
    pub(super) fn value(&mut self, value: u32) -> Expression {
        if let Some(name) = self.names.get(&value) {
            if let Some(&binding) = self.bound.get(&value) {
                self.bindings[binding].1 = true;
            }
            return name.clone();
        }
        self.computed(value).remove(0)
    }

    /// The operation that computes a value; for a sine with its cosine, both.
    fn computed(&mut self, value: u32) -> Vec<Expression> {
        match self.tape.values()[value as usize] {
            Value::Operation(operation) => expression::expressions(operation, |operand| self.value(operand)),
            Value::Input | Value::Cosine => unreachable!("inputs and cosines have names"),
        }
    }
}

fn argument_name(argument: Argument) -> &'static str {
    match argument {
        Argument::Position => "position",
        Argument::Time => "t",
        Argument::Coordinates => "q",
        Argument::Rates => "qd",
        Argument::Accelerations => "qdd",
        Argument::Multipliers => "multipliers",
        Argument::Residuals => "residuals",
        Argument::Angles => "angles",
    }
}
