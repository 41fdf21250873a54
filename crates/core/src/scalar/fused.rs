//! Doubles with fused products as numbers of generated functions.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::Scalar;
use crate::math;
use crate::sine::sin_cos;

/// A double whose products and sums are rounded together, for processors with such an instruction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Fused(pub f64);

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

#[cfg(feature = "simd")]
impl Fused {
    /// Calls a function with all fused-product registers of the processor; `None` if it has none. The function is
    /// compiled once for each number of registers.
    #[inline(always)]
    pub(crate) fn vectorize_widest<T>(f: impl FnOnce() -> T) -> Option<T> {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V4::try_new() {
            return Some(simd.vectorize(f));
        }
        Self::vectorize(f)
    }

    /// Calls a function with fused-product instructions; `None` if the processor has none.
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
        // A function that is not inlined has the target features only if it declares them.
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
