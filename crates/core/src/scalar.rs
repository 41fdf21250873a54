//! The number type of generated functions.

mod double;
mod fused;

use core::ops::{Add, Div, Mul, Neg, Sub};

pub use fused::Fused;

/// A number of a generated function: a double, a vector of doubles in lanes, a dual number.
pub trait Scalar:
    Copy
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A step stands as straight-line code up to this number of operations of its kernel, else as a loop over its
    /// stages, which takes a fraction of the time to compile.
    const INLINE_LIMIT: usize = 600;

    /// The number nearest to a double.
    fn from_f64(value: f64) -> Self;
    /// The double nearest to the number; of a dual number its value, of lanes the first.
    fn to_f64(self) -> f64;
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    /// The ratio of a circle's circumference to its diameter.
    #[inline(always)]
    fn pi() -> Self {
        Self::from_f64(core::f64::consts::PI)
    }
    /// One over the number.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::from_f64(1.0) / self
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Sine.
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// Cosine.
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    /// Tangent.
    #[inline(always)]
    fn tan(self) -> Self {
        let (sine, cosine) = self.sin_cos();
        sine / cosine
    }
    /// Inverse sine.
    fn asin(self) -> Self;
    /// Inverse cosine.
    fn acos(self) -> Self;
    /// Inverse tangent.
    fn atan(self) -> Self;
    /// Exponential function.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Power with a fixed exponent.
    fn powf(self, exponent: f64) -> Self;
    /// -1, 0 or 1.
    fn sign(self) -> Self;
    /// The largest whole number that is not above the number.
    fn floor(self) -> Self;
    /// `self * a + b`, rounded once where the processor does so quickly.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `b - self * a`, likewise.
    fn neg_mul_add(self, a: Self, b: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The larger number.
    fn max(self, other: Self) -> Self;
    /// The smaller number.
    fn min(self, other: Self) -> Self;
    /// Angle of the vector with this ordinate and that abscissa.
    fn atan2(self, abscissa: Self) -> Self;
    /// Length of the vector with these components.
    fn hypot(self, other: Self) -> Self;
    /// A whole power.
    fn powi(self, exponent: i32) -> Self;
    /// A power with any exponent.
    fn pow(self, exponent: Self) -> Self;
    /// Whether all lanes are below zero.
    fn is_negative(self) -> bool;
    /// Whether all lanes are between `-bound` and `bound`; a lane that is not a number is not.
    fn is_within(self, bound: f64) -> bool;
    /// `inside` where `self` is between `-bound` and `bound`, else `outside`.
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self;
    /// With `self` a whole number `n` plus `1.5 * 2^52`: sine and cosine of an angle that is `n` quarter turns larger
    /// than one with these.
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self);
    /// Sine and cosine of very large angles.
    fn sin_cos_far(self) -> (Self, Self);
    /// Sine and cosine out of line.
    fn sin_cos_apart(self) -> (Self, Self);
    /// Calls a function with the instructions that belong to these numbers, for where it is compiled out of line.
    #[inline(always)]
    fn vectorized<T>(f: impl FnOnce() -> T) -> T {
        f()
    }
}
