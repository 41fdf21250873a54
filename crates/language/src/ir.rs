//! The intermediate representation of a generated module, from which C and MATLAB are written.

mod expression;

use std::collections::BTreeSet;

use super::names::Names;
use crate::untranslated::Untranslated;
pub use expression::{Builtin, Expression, Operator};

/// A module: structs of numbers, and functions.
#[derive(Debug)]
pub struct Program {
    /// The prefix of the names of the program's functions.
    pub name: String,
    /// The lines of its documentation.
    pub doc: Vec<String>,
    /// Notes on the operations of the program and on its omissions.
    pub notes: Vec<String>,
    /// The coordinates of the mechanism.
    pub coordinates: Vec<Quantity>,
    /// The constraints of the mechanism.
    pub constraints: Vec<Quantity>,
    /// The outputs of the scene.
    pub outputs: Vec<Quantity>,
    /// Whether the sine and cosine of each coordinate occur in the equations.
    pub has_angle: Vec<bool>,
    /// Whether each coordinate is a length, not an angle.
    pub is_length: Vec<bool>,
    /// The structs of the module.
    pub structs: Vec<Struct>,
    /// The functions of the module, each after those whose results it uses.
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
    /// The name of the quantity.
    pub name: String,
    /// The unit of the quantity.
    pub unit: String,
    /// The description of the quantity.
    pub doc: String,
}

/// A struct of numbers.
#[derive(Debug)]
pub struct Struct {
    /// The kind of the struct.
    pub kind: StructKind,
    /// The lines of its documentation.
    pub doc: Vec<String>,
    /// The numbers in the struct.
    pub fields: Vec<Field>,
}

/// A number in a struct.
#[derive(Debug)]
pub struct Field {
    /// The name of the number.
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
    /// Values that depend on parameters alone.
    Constants,
    /// Values that follow from the position alone.
    Position,
    /// Sines and cosines of all coordinates.
    Angles,
}

impl StructKind {
    /// The name of the struct of this kind.
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
    /// The name of the function.
    pub name: String,
    /// The lines of its documentation.
    pub doc: Vec<String>,
    /// The arguments of the function.
    pub arguments: Vec<Variable>,
    /// The results of the function.
    pub results: Vec<Variable>,
    /// The statements of the function; they set every element of the results.
    pub body: Vec<Statement>,
}

impl Function {
    /// Whether the function has a single result that is a number.
    pub fn returns_scalar(&self) -> bool {
        matches!(&self.results[..], [result] if result.shape == Shape::Scalar)
    }

    /// The names of arguments, results and values in a target language.
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

    /// Whether any statement uses a name.
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
    /// The name of the argument or result.
    pub name: String,
    /// The shape of the argument or result.
    pub shape: Shape,
}

/// The shape of an argument or a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A number.
    Scalar,
    /// A vector of this length.
    Vector(usize),
    /// A matrix with these numbers of rows and columns.
    Matrix(usize, usize),
    /// A list of booleans of this length.
    Booleans(usize),
    /// A struct.
    Struct(StructKind),
}

/// A statement of a function.
#[derive(Clone, Debug)]
pub enum Statement {
    /// A comment about the statements after it.
    Comment(String),
    /// A short name for a struct.
    Alias {
        /// The short name.
        name: String,
        /// The kind of the struct.
        kind: StructKind,
        /// The expression that the short name abbreviates.
        of: Expression,
    },
    /// A named number.
    Let {
        /// The name.
        name: String,
        /// The number.
        value: Expression,
    },
    /// Sets all elements of a result to zero.
    Clear {
        /// The result.
        place: Expression,
        /// The shape of the result.
        shape: Shape,
    },
    /// Sets an element of a result.
    Assign {
        /// The place.
        place: Expression,
        /// The number.
        value: Expression,
    },
    /// Returns the single result.
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
