//! Double-double numbers as a plain number type for automatic differentiation.

use std::cmp::Ordering;
use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use qrm_core::{DoubleDouble, Scalar};

/// A double-double number, about 32 digits.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct Wide(pub(super) DoubleDouble);

impl From<f64> for Wide {
    fn from(value: f64) -> Self {
        Self(value.into())
    }
}

macro_rules! operators {
    ($($operator:ident $name:ident, $assignment:ident $assign:ident);*) => {
        $(
            impl $operator for Wide {
                type Output = Self;
                fn $name(self, other: Self) -> Self { Self(self.0.$name(other.0)) }
            }
            impl $operator<&Self> for Wide {
                type Output = Self;
                fn $name(self, other: &Self) -> Self { self.$name(*other) }
            }
            impl $operator<f64> for Wide {
                type Output = Self;
                fn $name(self, other: f64) -> Self { self.$name(Self::from(other)) }
            }
            impl $assignment for Wide {
                fn $assign(&mut self, other: Self) { *self = self.$name(other); }
            }
            impl $assignment<f64> for Wide {
                fn $assign(&mut self, other: f64) { *self = self.$name(other); }
            }
        )*
    };
}

operators!(
    Add add, AddAssign add_assign;
    Sub sub, SubAssign sub_assign;
    Mul mul, MulAssign mul_assign;
    Div div, DivAssign div_assign
);

/// The traits require remainders, but no formula uses them.
macro_rules! no_remainder {
    ($($other:ty),*) => {
        $(
            impl Rem<$other> for Wide {
                type Output = Self;
                fn rem(self, _: $other) -> Self { Self::from(f64::NAN) }
            }
        )*
    };
}

no_remainder!(Wide, &Wide, f64);

impl RemAssign for Wide {
    fn rem_assign(&mut self, other: Self) {
        *self = *self % other;
    }
}

impl RemAssign<f64> for Wide {
    fn rem_assign(&mut self, other: f64) {
        *self = *self % other;
    }
}

impl Neg for Wide {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl PartialEq<f64> for Wide {
    fn eq(&self, other: &f64) -> bool {
        *self == Self::from(*other)
    }
}

impl PartialOrd<f64> for Wide {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.partial_cmp(&Self::from(*other))
    }
}

impl Zero for Wide {
    fn zero() -> Self {
        Self::from(0.0)
    }
    fn is_zero(&self) -> bool {
        self.0.hi() == 0.0
    }
}

impl One for Wide {
    fn one() -> Self {
        Self::from(1.0)
    }
}

impl Num for Wide {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        <f64 as Num>::from_str_radix(text, radix).map(Self::from)
    }
}

impl Signed for Wide {
    fn abs(&self) -> Self {
        Self(Scalar::abs(self.0))
    }
    fn abs_sub(&self, other: &Self) -> Self {
        if self > other { *self - *other } else { Self::zero() }
    }
    fn signum(&self) -> Self {
        Self(self.0.sign())
    }
    fn is_positive(&self) -> bool {
        self.0.hi() > 0.0
    }
    fn is_negative(&self) -> bool {
        self.0.hi() < 0.0
    }
}

impl Inv for Wide {
    type Output = Self;
    fn inv(self) -> Self {
        Self(self.0.recip())
    }
}

impl Sum for Wide {
    fn sum<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Self::zero(), Add::add)
    }
}

impl Product for Wide {
    fn product<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Self::one(), Mul::mul)
    }
}

impl FromPrimitive for Wide {
    fn from_i64(n: i64) -> Option<Self> {
        f64::from_i64(n).map(Self::from)
    }
    fn from_u64(n: u64) -> Option<Self> {
        f64::from_u64(n).map(Self::from)
    }
    fn from_f64(n: f64) -> Option<Self> {
        Some(Self::from(n))
    }
}

impl fmt::Display for Wide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.hi().fmt(f)
    }
}

impl DualStruct for Wide {
    type Real = f64;
    type Inner = Self;
    fn re(&self) -> f64 {
        self.0.hi()
    }
    fn from_inner(inner: &Self) -> Self {
        *inner
    }
}

impl Mappable<Wide> for Wide {
    type Output<O> = O;
    fn map_dual<M: Fn(Wide) -> O, O>(self, map: M) -> O {
        map(self)
    }
}

macro_rules! forward {
    ($($name:ident),*) => {
        $(fn $name(&self) -> Self { Self(Scalar::$name(self.0)) })*
    };
}

/// Functions that no formula calls.
macro_rules! unused {
    ($($name:ident),*) => {
        $(fn $name(&self) -> Self { Self::from(f64::NAN) })*
    };
}

impl DualNum for Wide {
    type Primitive = f64;
    const NDERIV: usize = 0;
    type InnerDual = Self;

    fn from_re(re: Self) -> Self {
        re
    }
    fn scale(self, factor: &Self) -> Self {
        self * factor
    }
    fn powi(&self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }
    fn powf(&self, exponent: f64) -> Self {
        Self(self.0.powf(exponent))
    }
    fn log(&self, base: f64) -> Self {
        DualNum::ln(self) / DualNum::ln(&Self::from(base))
    }
    fn sin_cos(&self) -> (Self, Self) {
        let (sine, cosine) = self.0.sin_cos();
        (Self(sine), Self(cosine))
    }
    fn atan2(&self, abscissa: Self) -> Self {
        Self(self.0.atan2(abscissa.0))
    }
    forward!(recip, sqrt, exp, ln, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh);
    unused!(cbrt, exp2, exp_m1, log2, log10, ln_1p, asinh, acosh, atanh, sph_j0, sph_j1, sph_j2);
}
