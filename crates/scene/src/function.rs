//! The functions that formulae may call.

use num_dual::DualNum;
use qrm_core::Operation;

/// A double, possibly with derivatives.
pub trait Differentiable: DualNum<Primitive = f64> + Copy {}

impl<D: DualNum<Primitive = f64> + Copy> Differentiable for D {}

/// A function that formulae may call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Function {
    /// Square root.
    Sqrt,
    /// Sine of an angle in radians.
    Sin,
    /// Cosine of an angle in radians.
    Cos,
    /// Tangent of an angle in radians.
    Tan,
    /// Inverse sine.
    Asin,
    /// Inverse cosine.
    Acos,
    /// Inverse tangent.
    Atan,
    /// Exponential function.
    Exp,
    /// Natural logarithm.
    Log,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// Length of the vector with two given components.
    Hypot,
    /// Angle of the vector with ordinate and abscissa (in this order).
    Atan2,
    /// Absolute value.
    Abs,
    /// -1, 0 or 1.
    Sign,
    /// The smaller of two.
    Min,
    /// The larger of two.
    Max,
    /// The largest integer that is not above a number; used only to express splines.
    Floor,
}

impl Function {
    /// All functions that formulae may name, in the order of the documentation.
    pub const ALL: [Function; 18] = [
        Self::Sqrt,
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Asin,
        Self::Acos,
        Self::Atan,
        Self::Exp,
        Self::Log,
        Self::Sinh,
        Self::Cosh,
        Self::Tanh,
        Self::Hypot,
        Self::Atan2,
        Self::Abs,
        Self::Sign,
        Self::Min,
        Self::Max,
    ];

    /// The operation of a tape that computes the function.
    pub fn operation(self, arguments: &[u32]) -> Operation {
        let x = arguments[0];
        let y = || arguments[1];
        match self {
            Self::Sqrt => Operation::Sqrt(x),
            Self::Sin => Operation::Sin(x),
            Self::Cos => Operation::Cos(x),
            Self::Tan => Operation::Tan(x),
            Self::Asin => Operation::Asin(x),
            Self::Acos => Operation::Acos(x),
            Self::Atan => Operation::Atan(x),
            Self::Exp => Operation::Exp(x),
            Self::Log => Operation::Ln(x),
            Self::Sinh => Operation::Sinh(x),
            Self::Cosh => Operation::Cosh(x),
            Self::Tanh => Operation::Tanh(x),
            Self::Hypot => Operation::Hypot(x, y()),
            Self::Atan2 => Operation::Atan2(x, y()),
            Self::Abs => Operation::Abs(x),
            Self::Sign => Operation::Sign(x),
            Self::Min => Operation::Min(x, y()),
            Self::Max => Operation::Max(x, y()),
            Self::Floor => Operation::Floor(x),
        }
    }

    /// The name in a formula.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sqrt => "sqrt",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Exp => "exp",
            Self::Log => "log",
            Self::Sinh => "sinh",
            Self::Cosh => "cosh",
            Self::Tanh => "tanh",
            Self::Hypot => "hypot",
            Self::Atan2 => "atan2",
            Self::Abs => "abs",
            Self::Sign => "sign",
            Self::Min => "min",
            Self::Max => "max",
            Self::Floor => "floor",
        }
    }

    /// Finds a function by its name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }

    /// The number of arguments.
    pub fn arity(self) -> usize {
        match self {
            Self::Hypot | Self::Atan2 | Self::Min | Self::Max => 2,
            _ => 1,
        }
    }

    /// Whether the function is differentiable in its whole domain. Other functions are allowed only where nothing is
    /// differentiated: in values of parameters, first guesses and stop conditions.
    pub fn is_differentiable(self) -> bool {
        self != Self::Atan2 && !self.is_piecewise()
    }

    /// Whether the function is differentiable except at corners; such functions are also allowed in loads.
    pub fn is_piecewise(self) -> bool {
        matches!(self, Self::Abs | Self::Sign | Self::Min | Self::Max | Self::Floor)
    }

    /// Evaluates the function at `arguments`; there must be at least [`arity`](Self::arity) of them.
    pub fn evaluate<D: Differentiable>(self, arguments: &[D]) -> D {
        let x = arguments[0];
        match self {
            Self::Sqrt => x.sqrt(),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Exp => x.exp(),
            Self::Log => x.ln(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => tanh(x),
            Self::Hypot => (x * x + arguments[1] * arguments[1]).sqrt(),
            Self::Atan2 => x.atan2(arguments[1]),
            Self::Abs => {
                if x.re() < 0.0 {
                    -x
                } else {
                    x
                }
            }
            Self::Sign => D::from(f64::from(i8::from(x.re() > 0.0) - i8::from(x.re() < 0.0))),
            Self::Floor => D::from(x.re().floor()),
            Self::Min => {
                if arguments[1].re() < x.re() {
                    arguments[1]
                } else {
                    x
                }
            }
            Self::Max => {
                if arguments[1].re() > x.re() {
                    arguments[1]
                } else {
                    x
                }
            }
        }
    }
}

fn tanh<D: Differentiable>(x: D) -> D {
    let is_negative = x.re() < 0.0;
    let size = if is_negative { -x } else { x };
    if size.re() < 1.0 {
        return x.tanh();
    }
    // `DualNum::tanh` divides sinh by cosh, which overflow.
    let exp = (size * -2.0).exp();
    let value = (-exp + 1.0) / (exp + 1.0);
    if is_negative { -value } else { value }
}

#[cfg(test)]
mod tests {
    use num_dual::Dual2_64;

    use super::*;

    #[test]
    fn tanh_and_its_derivatives_do_not_overflow() {
        for x in [-1e4_f64, -1.5, -0.5, 0.0, 0.99, 1.0, 3.0, 800.0] {
            let value = Function::Tanh.evaluate(&[Dual2_64::from_re(x).derivative()]);
            let tanh = x.tanh();
            let slope = 1.0 - tanh * tanh;
            let expected = [tanh, slope, -2.0 * tanh * slope];
            for (found, expected) in [value.re, value.v1, value.v2].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-15, "{x}: {found} instead of {expected}");
            }
        }
    }
}
