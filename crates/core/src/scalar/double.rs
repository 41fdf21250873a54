//! Doubles as numbers of generated functions.

use super::Scalar;
use crate::math;
use crate::sine::sin_cos;

macro_rules! forward {
    ($($name:ident),*) => {
        $(#[inline(always)] fn $name(self) -> Self { math::$name(self) })*
    };
}

impl Scalar for f64 {
    // Processors without fused products also have small caches.
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
        // Zero and NaN stay unchanged.
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
        if self > other || self.is_nan() { self } else { other }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other || self.is_nan() { self } else { other }
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
