//! The number type of generated functions.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::math;
use crate::sine::sin_cos;

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

/// A double whose products and sums are rounded together, for processors that do so.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Fused(pub f64);

macro_rules! forward {
    ($($name:ident),*) => {
        $(#[inline(always)] fn $name(self) -> Self { math::$name(self) })*
    };
}

macro_rules! forward_inside {
    ($($name:ident),*) => {
        $(#[inline(always)] fn $name(self) -> Self { Self(math::$name(self.0)) })*
    };
}

macro_rules! operators {
    ($($operator:ident $name:ident),*) => {
        $(impl $operator for Fused {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self { Self(self.0.$name(other.0)) }
        })*
    };
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Fused {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for f64 {
    // Processors that have no fused products have small caches too.
    const INLINE_LIMIT: usize = 0;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        math::powf(self, exponent)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        // Zero, and what is not a number, stay what they are.
        if self == 0.0 || self.is_nan() { self } else { f64::signum(self) }
    }
    forward!(recip, floor, sqrt, tan, asin, acos, atan, exp, ln, sinh, cosh, tanh);
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        b - self * a
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    fn atan2(self, abscissa: Self) -> Self {
        math::atan2(self, abscissa)
    }
    fn hypot(self, other: Self) -> Self {
        math::hypot(self, other)
    }
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        math::powi(self, exponent)
    }
    fn pow(self, exponent: Self) -> Self {
        math::powf(self, exponent)
    }
    #[inline(always)]
    fn is_negative(self) -> bool {
        self < 0.0
    }
    #[inline(always)]
    fn is_within(self, bound: f64) -> bool {
        f64::abs(self) <= bound
    }
    #[inline(always)]
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        if self.is_within(bound) { inside } else { outside }
    }
    #[inline(always)]
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let n = self.to_bits();
        let (sin, cos) = if n & 1 == 0 { (sin, cos) } else { (cos, sin) };
        (Self::from_bits(sin.to_bits() ^ (n & 2) << 62), Self::from_bits(cos.to_bits() ^ ((n + 1) & 2) << 62))
    }
    #[cold]
    #[inline(never)]
    fn sin_cos_far(self) -> (Self, Self) {
        libm::sincos(self)
    }
    #[cold]
    #[inline(never)]
    fn sin_cos_apart(self) -> (Self, Self) {
        sin_cos(self)
    }
}

#[cfg(feature = "simd")]
impl Fused {
    /// Calls a function with all registers of the processor for fused products; `None` where it has none. The function
    /// is compiled once for each number of registers.
    #[inline(always)]
    pub(crate) fn vectorize_widest<T>(f: impl FnOnce() -> T) -> Option<T> {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V4::try_new() {
            return Some(simd.vectorize(f));
        }
        Self::vectorize(f)
    }

    /// Calls a function with the instructions of fused products; `None` where the processor has none.
    #[inline(always)]
    pub(crate) fn vectorize<T>(f: impl FnOnce() -> T) -> Option<T> {
        #[cfg(target_arch = "x86_64")]
        return Some(pulp::x86::V3::try_new()?.vectorize(f));
        #[cfg(not(target_arch = "x86_64"))]
        if cfg!(any(target_arch = "aarch64", target_feature = "fma")) { Some(f()) } else { None }
    }
}

impl Scalar for Fused {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.0
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        Self(math::powf(self.0, exponent))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(self.0.sign())
    }
    forward_inside!(recip, floor, sqrt, tan, asin, acos, atan, exp, ln, sinh, cosh, tanh);
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(math::mul_add(self.0, a.0, b.0))
    }
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        Self(math::mul_add(-self.0, a.0, b.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(Scalar::max(self.0, other.0))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(Scalar::min(self.0, other.0))
    }
    fn atan2(self, abscissa: Self) -> Self {
        Self(math::atan2(self.0, abscissa.0))
    }
    fn hypot(self, other: Self) -> Self {
        Self(math::hypot(self.0, other.0))
    }
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        Self(math::powi(self.0, exponent))
    }
    fn pow(self, exponent: Self) -> Self {
        Self(math::powf(self.0, exponent.0))
    }
    #[inline(always)]
    fn is_negative(self) -> bool {
        self.0 < 0.0
    }
    #[inline(always)]
    fn is_within(self, bound: f64) -> bool {
        self.0.is_within(bound)
    }
    #[inline(always)]
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        if self.is_within(bound) { inside } else { outside }
    }
    #[inline(always)]
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let (sin, cos) = self.0.quarter_turns(sin.0, cos.0);
        (Self(sin), Self(cos))
    }
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    #[inline(always)]
    fn vectorized<T>(f: impl FnOnce() -> T) -> T {
        // A function out of line has the processor's own instructions only if it says so.
        match pulp::x86::V3::try_new() {
            Some(simd) => simd.vectorize(f),
            None => f(),
        }
    }
    #[inline(always)]
    fn sin_cos_far(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos_far();
        (Self(sin), Self(cos))
    }
    #[inline(always)]
    fn sin_cos_apart(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos_apart();
        (Self(sin), Self(cos))
    }
}
