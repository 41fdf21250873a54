//! Expressions for numbers.

/// An expression with a numerical value.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A decimal.
    Number(String),
    /// A boolean.
    Boolean(bool),
    /// The ratio of a circle's circumference to its diameter.
    Pi,
    /// Positive infinity.
    Infinity,
    /// A name that is defined in the function, or is an argument.
    Name(String),
    /// A number in a struct.
    Field(Box<Expression>, String),
    /// The element at an index, counted from zero.
    Element(Box<Expression>, usize),
    /// The negative of a number.
    Negative(Box<Expression>),
    /// A sum, difference, product or quotient.
    Binary(Operator, Box<Expression>, Box<Expression>),
    /// A call of a builtin function.
    Call(Builtin, Vec<Expression>),
}

impl Expression {
    pub(crate) fn name(name: &str) -> Self {
        Self::Name(name.to_owned())
    }

    pub(crate) fn field(self, name: &str) -> Self {
        Self::Field(Box::new(self), name.to_owned())
    }

    pub(crate) fn element(self, place: usize) -> Self {
        Self::Element(Box::new(self), place)
    }

    pub(crate) fn negative(self) -> Self {
        Self::Negative(Box::new(self))
    }

    pub(crate) fn binary(operator: Operator, left: Self, right: Self) -> Self {
        Self::Binary(operator, Box::new(left), Box::new(right))
    }

    pub(super) fn visit(&self, f: &mut impl FnMut(&Self)) {
        f(self);
        match self {
            Self::Number(_) | Self::Boolean(_) | Self::Pi | Self::Infinity | Self::Name(_) => {}
            Self::Field(inner, _) | Self::Element(inner, _) | Self::Negative(inner) => inner.visit(f),
            Self::Binary(_, left, right) => {
                left.visit(f);
                right.visit(f);
            }
            Self::Call(_, arguments) => arguments.iter().for_each(|argument| argument.visit(f)),
        }
    }
}

/// An operation on two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "their names say it")]
pub enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// The builtin functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "their names say it")]
pub enum Builtin {
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
    /// -1, 0 or 1; NaN stays NaN.
    Sign,
    /// The first number if it is smaller, otherwise the second.
    Min,
    /// The first number if it is larger, otherwise the second.
    Max,
    /// The second number if the first one is NaN, otherwise the first.
    ValueOr,
}
