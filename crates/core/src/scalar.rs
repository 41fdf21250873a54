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
    /// The largest number of operations of a kernel whose steps are straight-line code. Steps of larger kernels loop
    /// over their stages, which compiles in a fraction of the time.
    const INLINE_LIMIT: usize = 600;

    /// The number nearest to a double.
    fn from_f64(value: f64) -> Self;
    /// The double nearest to the number: the value of a dual number, the first of the lanes.
    fn to_f64(self) -> f64;
    /// The number of a formula whose nearest double is `value`. A double stands for itself; numbers with more digits
    /// stand for the simplest fraction with that double, 1/10 for 0.1.
    #[inline(always)]
    fn from_number(value: f64) -> Self {
        Self::from_f64(value)
    }
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
    /// The largest integer that is not above the number.
    fn floor(self) -> Self;
    /// `self * a + b`, rounded once where the processor does so quickly.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `b - self * a`, likewise.
    fn neg_mul_add(self, a: Self, b: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The larger number; not a number if one of them is not.
    fn max(self, other: Self) -> Self;
    /// The smaller number; not a number if one of them is not.
    fn min(self, other: Self) -> Self;
    /// Angle of the vector with ordinate `self` and this abscissa.
    fn atan2(self, abscissa: Self) -> Self;
    /// Length of the vector with these components.
    fn hypot(self, other: Self) -> Self;
    /// An integer power.
    fn powi(self, exponent: i32) -> Self;
    /// A power with any exponent.
    fn pow(self, exponent: Self) -> Self;
    /// Whether all lanes are below zero.
    fn is_negative(self) -> bool;
    /// Whether all lanes lie between `-bound` and `bound`; false if a lane is not a number.
    fn is_within(self, bound: f64) -> bool;
    /// `inside` where `self` is between `-bound` and `bound`, else `outside`.
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self;
    /// Sine and cosine of an angle that is `n` quarter turns larger than the one with `sin` and `cos`; `self` is the
    /// integer `n` plus `1.5 * 2^52`.
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self);
    /// Sine and cosine of very large angles.
    fn sin_cos_far(self) -> (Self, Self);
    /// Sine and cosine out of line.
    fn sin_cos_apart(self) -> (Self, Self);
    /// Calls a function that is not inlined, with the target features of these numbers.
    #[inline(always)]
    fn vectorized<T>(f: impl FnOnce() -> T) -> T {
        f()
    }
}
