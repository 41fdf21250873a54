//! An operation whose Taylor series follows by a recurrence.

use crate::Interval;

/// One value of a function; operands are nodes before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Node {
    /// Time, a coordinate, a rate, an acceleration or a multiplier.
    Argument,
    /// A value that depends on parameters alone.
    Constant(Interval),
    Neg(u32),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    Sqrt(u32),
    /// The cosine is the next node.
    Sin(u32),
    /// The sine is the node before.
    Cos(u32),
    Exp(u32),
    /// Its slope, one less the square, is the node after the next one.
    Tanh(u32),
    /// A function of the first operand; its derivative by it is one over the second one.
    Inverse(Inverse, u32, u32),
    Abs(u32),
    /// The first operand where the third one is not below zero, the second one where that is not above zero.
    Choice(u32, u32, u32),
    /// Minus one or one.
    Sign(u32),
    /// The largest whole number that is not above.
    Floor(u32),
    /// The angle of an ordinate and an abscissa, whose squares add up to the third operand.
    Angle(u32, u32, u32),
}

/// A function by its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Inverse {
    Ln,
    Asin,
    Atan,
}

impl Node {
    /// The value of the node, from the values of its operands.
    pub(super) fn value(self, at: impl Fn(u32) -> Interval) -> Interval {
        match self {
            Self::Argument => Interval::ENTIRE,
            Self::Angle(a, b, _) => at(a).atan2(at(b)),
            Self::Constant(value) => value,
            Self::Neg(a) => -at(a),
            Self::Add(a, b) => at(a) + at(b),
            Self::Sub(a, b) => at(a) - at(b),
            Self::Mul(a, b) if a == b => at(a).square(),
            Self::Mul(a, b) => at(a) * at(b),
            Self::Div(a, b) => at(a) / at(b),
            Self::Sqrt(a) => at(a).sqrt(),
            Self::Sin(a) => at(a).sin_cos().0,
            Self::Cos(a) => at(a).sin_cos().1,
            Self::Exp(a) => at(a).exp(),
            Self::Tanh(a) => at(a).tanh(),
            Self::Inverse(Inverse::Ln, a, _) => at(a).ln(),
            Self::Inverse(Inverse::Asin, a, _) => at(a).asin(),
            Self::Inverse(Inverse::Atan, a, _) => at(a).atan(),
            Self::Abs(a) if is_above(at(a)) => at(a),
            Self::Abs(a) if is_above(-at(a)) => -at(a),
            Self::Choice(a, _, c) if is_above(at(c)) => at(a),
            Self::Choice(_, b, c) if is_above(-at(c)) => at(b),
            Self::Abs(a) => Interval::new(0.0, at(a).magnitude()),
            Self::Choice(a, b, _) => at(a).hull(at(b)),
            Self::Sign(a) if at(a) == Interval::ZERO => Interval::ZERO,
            Self::Sign(a) if at(a).contains(0.0) => Interval::new(-1.0, 1.0),
            Self::Sign(a) => Interval::point(at(a).mid().signum()),
            Self::Floor(a) => Interval::new(at(a).lo().floor(), at(a).hi().floor()),
        }
    }

    /// Whether the node may have a corner or a jump among the values of its operands.
    pub(super) fn has_corner(self, at: impl Fn(u32) -> Interval) -> bool {
        match self {
            Self::Abs(a) | Self::Choice(_, _, a) => !is_above(at(a)) && !is_above(-at(a)),
            _ => self.may_jump(at),
        }
    }

    /// Whether the node may have a jump among the values of its operands.
    pub(super) fn may_jump(self, at: impl Fn(u32) -> Interval) -> bool {
        match self {
            Self::Sign(a) => at(a).contains(0.0) && at(a) != Interval::ZERO,
            Self::Floor(a) => at(a).lo().floor() != at(a).hi().floor(),
            _ => false,
        }
    }

    /// The name of the operation in messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Argument | Self::Constant(_) => "a number",
            Self::Neg(_) | Self::Add(..) | Self::Sub(..) => "a sum",
            Self::Mul(..) => "a product",
            Self::Div(..) => "a quotient",
            Self::Sqrt(_) => "a square root",
            Self::Sin(_) | Self::Cos(_) => "a sine or cosine",
            Self::Exp(_) => "an exponential",
            Self::Tanh(_) => "a hyperbolic tangent",
            Self::Inverse(Inverse::Ln, ..) => "a logarithm",
            Self::Inverse(..) => "an inverse sine, cosine or tangent",
            Self::Abs(_) => "an absolute value",
            Self::Choice(..) => "a minimum or maximum",
            Self::Sign(_) => "a sign",
            Self::Floor(_) => "a whole part",
            Self::Angle(..) => "the angle of a vector",
        }
    }

    /// The operands of the node.
    pub(super) fn operands(self) -> [Option<u32>; 3] {
        match self {
            Self::Argument | Self::Constant(_) => [None; 3],
            Self::Neg(a) | Self::Sqrt(a) | Self::Sin(a) | Self::Cos(a) | Self::Exp(a) => [Some(a), None, None],
            Self::Tanh(a) | Self::Abs(a) | Self::Sign(a) | Self::Floor(a) => [Some(a), None, None],
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => [Some(a), Some(b), None],
            Self::Inverse(_, a, b) => [Some(a), Some(b), None],
            Self::Choice(a, b, c) | Self::Angle(a, b, c) => [Some(a), Some(b), Some(c)],
        }
    }
}

/// Whether no number is below zero.
pub(super) fn is_above(interval: Interval) -> bool {
    interval.lo() >= 0.0
}
