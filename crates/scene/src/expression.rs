//! Formulae as flat lists of operations, with operands before the operations that use them.
//!
//! The list represents a tree without pointers, so a formula of any length is evaluated, translated and freed by a loop
//! instead of recursion.

use std::sync::Arc;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive};

use crate::diagnostic::Span;
use crate::function::Function;
use crate::spline::Spline;

/// A formula whose leaves are numbers and names `N`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Expression<N> {
    nodes: Vec<Node<N>>,
    spans: Vec<Span>,
}

/// The index of an operation in its [`Expression`].
pub type NodeId = usize;

/// One operation of an [`Expression`]; operands are indices of earlier operations.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Node<N> {
    /// A number as written.
    Number(Number),
    /// A named quantity.
    Name(N),
    /// `-a`
    Negate(NodeId),
    /// `a + b`
    Add(NodeId, NodeId),
    /// `a - b`
    Subtract(NodeId, NodeId),
    /// `a * b`
    Multiply(NodeId, NodeId),
    /// `a / b`
    Divide(NodeId, NodeId),
    /// `a ^ b`
    Power(NodeId, NodeId),
    /// `f(a, ...)`
    Call(Function, Vec<NodeId>),
    /// A spline of a lookup table.
    Spline(Arc<Spline>, NodeId),
}

/// A number of a scene: exact for differentiation, as the nearest double for evaluation.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Number {
    /// The exact value of the decimal; for data, the value of the double.
    #[serde(skip, default = "num_traits::Zero::zero")]
    pub exact: BigRational,
    /// The double nearest to it.
    pub value: f64,
    /// The double nearest to the difference between the exact value and `value`.
    pub rest: f64,
}

impl<N> Node<N> {
    /// The indices of the operands.
    pub fn operands(&self) -> Vec<NodeId> {
        match self {
            Self::Number(_) | Self::Name(_) => Vec::new(),
            Self::Negate(a) | Self::Spline(_, a) => vec![*a],
            Self::Add(a, b) | Self::Subtract(a, b) | Self::Multiply(a, b) | Self::Divide(a, b) | Self::Power(a, b) => {
                vec![*a, *b]
            }
            Self::Call(_, arguments) => arguments.clone(),
        }
    }

    /// Whether the operation is differentiable except at corners and jumps.
    pub fn is_piecewise(&self) -> bool {
        match self {
            Self::Call(function, _) => function.is_piecewise(),
            Self::Spline(spline, _) => !spline.corners().is_empty(),
            _ => false,
        }
    }
}

impl<N: Clone> Node<N> {
    /// Copies the operation with its operands shifted by `by`.
    pub(crate) fn moved(&self, by: usize) -> Self {
        self.at(|place| place + by)
    }

    /// Copies the operation with its operands mapped by `place`.
    pub(crate) fn at(&self, place: impl Fn(NodeId) -> NodeId) -> Self {
        match self {
            Self::Number(_) | Self::Name(_) => self.clone(),
            Self::Negate(a) => Self::Negate(place(*a)),
            Self::Add(a, b) => Self::Add(place(*a), place(*b)),
            Self::Subtract(a, b) => Self::Subtract(place(*a), place(*b)),
            Self::Multiply(a, b) => Self::Multiply(place(*a), place(*b)),
            Self::Divide(a, b) => Self::Divide(place(*a), place(*b)),
            Self::Power(a, b) => Self::Power(place(*a), place(*b)),
            Self::Call(function, arguments) => Self::Call(*function, arguments.iter().map(|a| place(*a)).collect()),
            Self::Spline(spline, a) => Self::Spline(Arc::clone(spline), place(*a)),
        }
    }
}

impl Number {
    /// Reads a decimal such as `0.2`, `12` or `1e-3`; `None` if it is outside the range of doubles.
    pub fn parse(decimal: &str) -> Option<Self> {
        let value: f64 = decimal.parse().ok()?;
        let (mantissa, exponent) = match decimal.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent),
            None => (decimal, "0"),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits: BigInt = format!("{whole}{fraction}").parse().ok()?;
        let is_zero = digits == BigInt::ZERO;
        if !value.is_finite() || (value == 0.0) != is_zero {
            return None;
        }
        if is_zero {
            return Some(Self { exact: BigRational::from(digits), value, rest: 0.0 });
        }
        // The range of doubles, 5e-324 to 1.8e308, bounds the power by the length of the text.
        let power = exponent.parse::<i64>().ok()? - i64::try_from(fraction.len()).ok()?;
        let scale = BigInt::from(10).pow(u32::try_from(power.unsigned_abs()).ok()?);
        let exact = if power < 0 { BigRational::new(digits, scale) } else { BigRational::from(digits * scale) };
        Some(Self::near(exact, value))
    }

    /// Creates a number whose nearest double is known.
    pub(crate) fn near(exact: BigRational, value: f64) -> Self {
        let rest = BigRational::from_float(value).map_or(0.0, |nearest| to_f64(&(&exact - nearest)));
        Self { exact, value, rest }
    }

    /// Creates a number from a double.
    pub(crate) fn double(value: f64) -> Self {
        Self { exact: BigRational::from_float(value).unwrap_or_default(), value, rest: 0.0 }
    }

    /// Creates an integer.
    pub fn whole(value: i32) -> Self {
        Self { exact: BigRational::from(BigInt::from(value)), value: f64::from(value), rest: 0.0 }
    }
}

/// The double nearest to a rational.
pub fn to_f64(exact: &BigRational) -> f64 {
    let (numerator, denominator) = (exact.numer(), exact.denom());
    let exactly = BigInt::one() << 53;
    if numerator.abs() <= exactly && *denominator <= exactly {
        // Both are exact doubles, so only the quotient is rounded.
        return numerator.to_f64().unwrap_or(f64::NAN) / denominator.to_f64().unwrap_or(f64::NAN);
    }
    exact.to_f64().unwrap_or(f64::NAN)
}

impl<N> Expression<N> {
    /// Creates an expression without operations, to be filled by [`push`](Self::push).
    pub fn new() -> Self {
        Self { nodes: Vec::new(), spans: Vec::new() }
    }

    /// Appends an operation; its operands must have been appended before.
    pub fn push(&mut self, node: Node<N>, span: Span) -> NodeId {
        self.nodes.push(node);
        self.spans.push(span);
        self.nodes.len() - 1
    }

    /// The operations; the last one is the value.
    pub fn nodes(&self) -> &[Node<N>] {
        &self.nodes
    }

    /// The location of an operation in the text of the scene.
    pub fn span(&self, id: NodeId) -> Span {
        self.spans[id].clone()
    }

    /// The location of the whole expression in the text of the scene.
    pub fn whole_span(&self) -> Span {
        self.spans.last().cloned().unwrap_or(0..0)
    }

    /// The names that occur.
    pub fn names(&self) -> impl Iterator<Item = &N> {
        self.nodes.iter().filter_map(|node| match node {
            Node::Name(name) => Some(name),
            _ => None,
        })
    }

    /// Changes the location of an operation, for example to include the parentheses around it.
    pub fn set_span(&mut self, id: NodeId, span: Span) {
        self.spans[id] = span;
    }

    /// Maps every location in the text.
    pub fn move_spans(&mut self, to: impl Fn(&Span) -> Span) {
        for span in &mut self.spans {
            *span = to(span);
        }
    }

    /// Copies the expression with names mapped by `rename`.
    pub fn map<M>(&self, mut rename: impl FnMut(&N, &Span) -> M) -> Expression<M> {
        let nodes = self.nodes.iter().zip(&self.spans).map(|(node, span)| match node {
            Node::Number(n) => Node::Number(n.clone()),
            Node::Name(name) => Node::Name(rename(name, span)),
            Node::Negate(a) => Node::Negate(*a),
            Node::Add(a, b) => Node::Add(*a, *b),
            Node::Subtract(a, b) => Node::Subtract(*a, *b),
            Node::Multiply(a, b) => Node::Multiply(*a, *b),
            Node::Divide(a, b) => Node::Divide(*a, *b),
            Node::Power(a, b) => Node::Power(*a, *b),
            Node::Call(f, arguments) => Node::Call(*f, arguments.clone()),
            Node::Spline(spline, a) => Node::Spline(Arc::clone(spline), *a),
        });
        Expression { nodes: nodes.collect(), spans: self.spans.clone() }
    }

    /// The base of an operation that is a power with this constant exponent.
    pub fn base(&self, id: NodeId, exponent: f64) -> Option<NodeId> {
        match self.nodes[id] {
            Node::Power(base, own) => {
                matches!(&self.nodes[own], Node::Number(number) if number.value == exponent).then_some(base)
            }
            _ => None,
        }
    }
}

impl<N: Clone> Expression<N> {
    /// Appends the operations of another formula; the last one is its value.
    pub(crate) fn append(&mut self, other: &Self) -> NodeId {
        let offset = self.nodes.len();
        self.nodes.extend(other.nodes.iter().map(|node| node.moved(offset)));
        self.spans.extend_from_slice(&other.spans);
        self.nodes.len() - 1
    }

    /// Copies the formula with splines expressed by step functions between the pieces.
    #[must_use]
    pub fn without_splines(&self) -> Self {
        let mut written = Self::new();
        let mut places: Vec<NodeId> = Vec::with_capacity(self.nodes.len());
        for (node, span) in self.nodes.iter().zip(&self.spans) {
            let place = match node {
                Node::Spline(spline, a) => spline.append(0, &mut written, places[*a], span),
                node => written.push(node.at(|a| places[a]), span.clone()),
            };
            places.push(place);
        }
        written
    }
}

impl<N> Default for Expression<N> {
    fn default() -> Self {
        Self::new()
    }
}
