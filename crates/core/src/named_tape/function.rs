//! A function of a tape: arguments, statements, results.

use std::fmt;
use std::format;
use std::string::String;
use std::vec;
use std::vec::Vec;

use serde::{Deserialize, Serialize};

use super::{NamedTape, Value};
use crate::tape::Operation;

/// A function's argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Argument {
    /// The result of the function `position`.
    Position,
    /// Time.
    Time,
    /// The coordinates.
    Coordinates,
    /// The rates of the coordinates.
    Rates,
    /// The accelerations of the coordinates.
    Accelerations,
    /// The multipliers.
    Multipliers,
    /// Residuals of the constraints.
    Residuals,
    /// Sines and cosines of the coordinates.
    Angles,
}

impl Argument {
    /// Time, coordinates, rates, accelerations and multipliers.
    pub const STATE: [Self; 5] = [Self::Time, Self::Coordinates, Self::Rates, Self::Accelerations, Self::Multipliers];
}

/// Values arranged for a function's result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Shape<T> {
    /// One value.
    Scalar(T),
    /// A list.
    Vector(Vec<T>),
    /// A list of rows.
    Matrix(Vec<Vec<T>>),
}

impl<T> Shape<T> {
    /// All values, row by row.
    pub fn values(&self) -> Vec<&T> {
        match self {
            Self::Scalar(value) => vec![value],
            Self::Vector(values) => values.iter().collect(),
            Self::Matrix(rows) => rows.iter().flatten().collect(),
        }
    }

    /// All values, to be changed.
    pub fn values_mut(&mut self) -> Vec<&mut T> {
        match self {
            Self::Scalar(value) => vec![value],
            Self::Vector(values) => values.iter_mut().collect(),
            Self::Matrix(rows) => rows.iter_mut().flatten().collect(),
        }
    }

    /// Other values in the same arrangement.
    pub fn map<U>(&self, f: &mut impl FnMut(&T) -> U) -> Shape<U> {
        match self {
            Self::Scalar(value) => Shape::Scalar(f(value)),
            Self::Vector(values) => Shape::Vector(values.iter().map(f).collect()),
            Self::Matrix(rows) => Shape::Matrix(rows.iter().map(|row| row.iter().map(&mut *f).collect()).collect()),
        }
    }
}

/// A result, or a named part of one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultField {
    /// The name of the part; empty if it is the whole result.
    pub name: String,
    /// The description of the part; empty if there is none.
    pub doc: String,
    /// The values of the part.
    pub values: Shape<u32>,
}

/// A value that gets a name.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Statement {
    /// A comment line before it.
    pub comment: Option<String>,
    /// The value.
    pub value: u32,
    /// The name of the value; two names for a pair of sine and cosine.
    pub names: Vec<String>,
}

/// A function.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Function {
    /// The name of the function.
    pub name: String,
    /// The description of what the function computes; Markdown.
    pub doc: String,
    /// Other names, for searches.
    pub aliases: Vec<String>,
    /// The arguments of the function.
    pub arguments: Vec<Argument>,
    /// Named values, in their order.
    pub statements: Vec<Statement>,
    /// The results of the function.
    pub parts: Vec<ResultField>,
    /// The type of a result with named parts.
    pub structure: Option<String>,
}

impl Function {
    /// A part of the result by its name.
    pub fn part(&self, name: &str) -> Option<&ResultField> {
        self.parts.iter().find(|part| part.name == name)
    }

    /// The values of all parts.
    pub fn results(&self) -> impl Iterator<Item = u32> {
        self.parts.iter().flat_map(|part| part.values.values()).copied()
    }

    /// Counts the operations of the function, without those for values that are given.
    pub fn operations(&self, tape: &NamedTape, is_given: impl Fn(u32) -> bool) -> Operations {
        let mut operations = Operations::default();
        let mut named: Vec<u32> = Vec::new();
        for statement in &self.statements {
            operations.count(tape, statement.value, true, &|value| is_given(value) || named.contains(&value));
            named.extend((0..).take(statement.names.len()).map(|i| statement.value + i));
        }
        for result in self.results() {
            operations.count(tape, result, false, &|value| is_given(value) || named.contains(&value));
        }
        operations
    }
}

/// The operations of each kind that a function takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Operations {
    /// Additions, subtractions and separate changes of sign.
    pub additions: usize,
    /// Multiplications.
    pub multiplications: usize,
    /// Divisions.
    pub divisions: usize,
    /// Square roots.
    pub roots: usize,
    /// Pairs of a sine and a cosine.
    pub sines: usize,
    /// Other functions.
    pub others: usize,
}

impl Operations {
    /// The sum of all operations except sines and cosines.
    pub fn sum(&self) -> usize {
        self.additions + self.multiplications + self.divisions + self.roots + self.others
    }

    /// Adds the operations of an expression, down to values with a name.
    fn count(&mut self, tape: &NamedTape, value: u32, is_definition: bool, has_name: &dyn Fn(u32) -> bool) {
        if !is_definition && has_name(value) {
            return;
        }
        let Value::Operation(operation) = tape.values()[value as usize] else { return };
        use Operation as Op;
        match operation {
            Op::Number(_) | Op::Pi => {}
            Op::Neg(_) | Op::Add(..) | Op::Sub(..) => self.additions += 1,
            Op::Mul(..) => self.multiplications += 1,
            Op::MulAdd(..) | Op::NegMulAdd(..) => {
                self.additions += 1;
                self.multiplications += 1;
            }
            Op::Div(..) | Op::Recip(_) => self.divisions += 1,
            Op::Sqrt(_) => self.roots += 1,
            Op::Sin(_) | Op::Cos(_) | Op::SinCos(_) => self.sines += 1,
            _ => self.others += 1,
        }
        operation.for_each_operand(|operand| self.count(tape, operand, false, has_name));
    }
}

impl fmt::Display for Operations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.additions, "additions"),
            (self.multiplications, "multiplications"),
            (self.divisions, "divisions"),
            (self.roots, "roots"),
            (self.sines, "sine-cosine pairs"),
            (self.others, "other functions"),
        ];
        let said: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {}", if *count == 1 { &what[..what.len() - 1] } else { what }))
            .collect();
        f.write_str(&if said.is_empty() { "no operations".into() } else { said.join(", ") })
    }
}
