//! The number type of generated functions.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What generated functions ask of a number: doubles have it, and so can lanes of doubles or dual numbers.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The number nearest to a double.
    fn from_f64(value: f64) -> Self;
    /// Zero.
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    /// One over the number.
    fn recip(self) -> Self {
        Self::from_f64(1.0) / self
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Sine.
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// Cosine.
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    /// Tangent.
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
}

macro_rules! forward_to_std {
    ($($name:ident),*) => {
        $(#[inline(always)] fn $name(self) -> Self { f64::$name(self) })*
    };
}

impl Real for f64 {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
    // One call for both, faster than the system's two, and the same digits on every system.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        f64::powf(self, exponent)
    }
    forward_to_std!(recip, sqrt, sin, cos, tan, asin, acos, atan, exp, ln, sinh, cosh, tanh);
}
