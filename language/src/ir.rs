//! The intermediate representation of a generated module, from which all languages are written.

mod expression;

use std::collections::BTreeSet;

use super::Untranslated;
use super::names::Names;
pub use expression::{Builtin, Expression, Operator};

/// A module: structs of numbers, and functions.
#[derive(Debug)]
pub struct Program {
    /// What the names of its functions begin with.
    pub name: String,
    /// The lines of its documentation.
    pub doc: Vec<String>,
    /// What its operations are, and what was left out.
    pub notes: Vec<String>,
    /// Its coordinates.
    pub coordinates: Vec<Quantity>,
    /// Its constraints.
    pub constraints: Vec<Quantity>,
    /// Its outputs.
    pub outputs: Vec<Quantity>,
    /// Which coordinates have sines and cosines in the equations.
    pub has_angle: Vec<bool>,
    /// Which coordinates are lengths, not angles.
    pub is_length: Vec<bool>,
    /// Its structs.
    pub structs: Vec<Struct>,
    /// Its functions, each behind those that it needs results of.
    pub functions: Vec<Function>,
}

impl Program {
    /// The function of this name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|function| function.name == name)
    }

    /// Whether the module has this struct.
    pub fn has(&self, kind: StructKind) -> bool {
        self.structs.iter().any(|structure| structure.kind == kind)
    }
}

/// A coordinate, a constraint or an output.
#[derive(Debug)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub doc: String,
}

/// A struct of numbers.
#[derive(Debug)]
pub struct Struct {
    /// Which one it is.
    pub kind: StructKind,
    /// The lines of its documentation.
    pub doc: Vec<String>,
    /// Its numbers.
    pub fields: Vec<Field>,
}

/// A number in a struct.
#[derive(Debug)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// The lines of its documentation.
    pub doc: Vec<String>,
}

/// The kinds of structs of a module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StructKind {
    /// Parameters and constants.
    Mechanism,
    /// The numbers of the scene that can be changed.
    Parameters,
    /// What depends on parameters alone.
    Constants,
    /// What follows from the position alone.
    Position,
    /// Sines and cosines of all coordinates.
    Angles,
}

impl StructKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mechanism => "mechanism",
            Self::Parameters => "parameters",
            Self::Constants => "constants",
            Self::Position => "position",
            Self::Angles => "angles",
        }
    }
}

/// A function without loops and branches.
#[derive(Debug)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// The lines of its documentation.
    pub doc: Vec<String>,
    /// Its arguments.
    pub arguments: Vec<Variable>,
    /// What it gives.
    pub results: Vec<Variable>,
    /// Its statements; each place of a result is set once they have been executed.
    pub body: Vec<Statement>,
}

impl Function {
    /// Whether its one result is a number.
    pub fn returns_scalar(&self) -> bool {
        matches!(&self.results[..], [result] if result.shape == Shape::Scalar)
    }

    /// The names of arguments, results and values in a language.
    pub(crate) fn local_names(&self, is_reserved: impl Fn(&str) -> bool) -> Result<Names, Untranslated> {
        let arguments = self.arguments.iter().map(|argument| argument.name.as_str());
        let results = self.results.iter().map(|result| result.name.as_str());
        let values = self.body.iter().filter_map(|statement| match statement {
            Statement::Alias { name, .. } | Statement::Let { name, .. } => Some(name.as_str()),
            _ => None,
        });
        Names::new(arguments.chain(results).chain(values), is_reserved)
    }

    /// The builtin functions that it calls.
    pub(crate) fn builtins(&self) -> BTreeSet<Builtin> {
        let mut called = BTreeSet::new();
        for statement in &self.body {
            statement.visit(&mut |value| {
                if let Expression::Call(builtin, _) = value {
                    called.insert(*builtin);
                }
            });
        }
        called
    }

    /// Whether any statement mentions a name.
    pub(crate) fn mentions(&self, name: &str) -> bool {
        let mut found = false;
        for statement in &self.body {
            statement.visit(&mut |value| found |= matches!(value, Expression::Name(other) if other == name));
        }
        found
    }
}

/// An argument or a result of a function.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
}

/// The shape of an argument or a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A number.
    Scalar,
    /// So many numbers.
    Vector(usize),
    /// Rows and columns.
    Matrix(usize, usize),
    /// So many booleans.
    Booleans(usize),
    /// A struct.
    Struct(StructKind),
}

/// A statement of a function.
#[derive(Clone, Debug)]
pub enum Statement {
    /// What the statements after it compute.
    Comment(String),
    /// A short name of a struct.
    Alias {
        /// The short name.
        name: String,
        /// Which struct it is.
        kind: StructKind,
        /// What it stands for.
        of: Expression,
    },
    /// A name for a number.
    Let {
        /// The name.
        name: String,
        /// The number.
        value: Expression,
    },
    /// Zeros in all places of a result.
    Clear {
        /// The result.
        place: Expression,
        /// Its shape.
        shape: Shape,
    },
    /// A number in a place of a result.
    Assign {
        /// The place.
        place: Expression,
        /// The number.
        value: Expression,
    },
    /// The one result.
    Return(Expression),
}

impl Statement {
    /// Calls a function for each expression in the statement.
    pub(crate) fn visit(&self, f: &mut impl FnMut(&Expression)) {
        match self {
            Self::Comment(_) => {}
            Self::Alias { of: value, .. } | Self::Let { value, .. } | Self::Clear { place: value, .. } => {
                value.visit(f)
            }
            Self::Assign { place, value } => {
                place.visit(f);
                value.visit(f);
            }
            Self::Return(value) => value.visit(f),
        }
    }
}
