//! The plain form of a generated module, from which all languages are written.

/// A module: structs of numbers, and functions.
#[derive(Debug)]
pub(super) struct Program {
    /// What the names of its functions begin with.
    pub(super) name: String,
    pub(super) doc: Vec<String>,
    pub(super) coordinates: usize,
    pub(super) constraints: usize,
    /// Which coordinates are lengths, not angles.
    pub(super) is_length: Vec<bool>,
    pub(super) records: Vec<Record>,
    pub(super) functions: Vec<Function>,
}

impl Program {
    pub(super) fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|function| function.name == name)
    }

    pub(super) fn has(&self, part: Part) -> bool {
        self.records.iter().any(|record| record.part == part)
    }
}

/// A struct of numbers.
#[derive(Debug)]
pub(super) struct Record {
    pub(super) part: Part,
    pub(super) doc: Vec<String>,
    pub(super) fields: Vec<Field>,
}

#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) doc: Vec<String>,
}

/// The structs of a module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    /// Parameters and constants.
    Mechanism,
    Parameters,
    Constants,
    Position,
    /// Sines and cosines of all coordinates.
    Angles,
}

impl Part {
    pub(super) fn name(self) -> &'static str {
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
pub(super) struct Function {
    pub(super) name: String,
    pub(super) doc: Vec<String>,
    pub(super) arguments: Vec<Argument>,
    pub(super) results: Vec<Result>,
    pub(super) body: Vec<Statement>,
}

impl Function {
    /// Whether its one result is a number.
    pub(super) fn is_number(&self) -> bool {
        matches!(&self.results[..], [result] if result.shape == Shape::Number)
    }

    /// Whether any statement mentions a name.
    pub(super) fn mentions(&self, name: &str) -> bool {
        let mut found = false;
        for statement in &self.body {
            statement.visit(&mut |value| found |= matches!(value, Expression::Name(other) if other == name));
        }
        found
    }
}

#[derive(Clone, Debug)]
pub(super) struct Argument {
    pub(super) name: String,
    pub(super) shape: Shape,
}

#[derive(Clone, Debug)]
pub(super) struct Result {
    pub(super) name: String,
    pub(super) shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    Number,
    Vector(usize),
    /// Rows and columns.
    Matrix(usize, usize),
    Truths(usize),
    Record(Part),
}

#[derive(Clone, Debug)]
pub(super) enum Statement {
    /// What the statements after it compute.
    Comment(String),
    /// A short name of a struct.
    Alias {
        name: String,
        part: Part,
        of: Expression,
    },
    Let {
        name: String,
        value: Expression,
    },
    /// Zeros in all places of a result.
    Clear {
        place: Expression,
        shape: Shape,
    },
    /// A number in a place of a result.
    Set {
        place: Expression,
        value: Expression,
    },
    /// The one result.
    Return(Expression),
}

impl Statement {
    /// Calls a function for each expression in the statement.
    pub(super) fn visit(&self, f: &mut impl FnMut(&Expression)) {
        match self {
            Self::Comment(_) => {}
            Self::Alias { of: value, .. } | Self::Let { value, .. } | Self::Clear { place: value, .. } => {
                value.visit(f)
            }
            Self::Set { place, value } => {
                place.visit(f);
                value.visit(f);
            }
            Self::Return(value) => value.visit(f),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    /// A decimal.
    Number(String),
    Truth(bool),
    Pi,
    Infinity,
    Name(String),
    Field(Box<Expression>, String),
    /// The element at a place that is counted from zero.
    Element(Box<Expression>, usize),
    Negative(Box<Expression>),
    Binary(Operator, Box<Expression>, Box<Expression>),
    Call(Routine, Vec<Expression>),
}

impl Expression {
    pub(super) fn name(name: &str) -> Self {
        Self::Name(name.to_owned())
    }

    pub(super) fn field(self, name: &str) -> Self {
        Self::Field(Box::new(self), name.to_owned())
    }

    pub(super) fn element(self, place: usize) -> Self {
        Self::Element(Box::new(self), place)
    }

    pub(super) fn negative(self) -> Self {
        Self::Negative(Box::new(self))
    }

    pub(super) fn binary(operator: Operator, left: Self, right: Self) -> Self {
        Self::Binary(operator, Box::new(left), Box::new(right))
    }

    fn visit(&self, f: &mut impl FnMut(&Self)) {
        f(self);
        match self {
            Self::Number(_) | Self::Truth(_) | Self::Pi | Self::Infinity | Self::Name(_) => {}
            Self::Field(inner, _) | Self::Element(inner, _) | Self::Negative(inner) => inner.visit(f),
            Self::Binary(_, left, right) => {
                left.visit(f);
                right.visit(f);
            }
            Self::Call(_, arguments) => arguments.iter().for_each(|argument| argument.visit(f)),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// The functions of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Routine {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Sqrt,
    Abs,
    Floor,
    Power,
    Hypot,
    Atan2,
    /// -1, 0 or 1; what is not a number stays what it is.
    Sign,
    /// The first number if it is smaller, else the second.
    Min,
    /// The first number if it is larger, else the second.
    Max,
    /// The second number where the first one is not a number, else the first.
    Given,
}
