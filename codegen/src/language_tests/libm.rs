//! Doubles with the sines and cosines of the system's C library, which C programs use too.

use std::ops::{Add, Div, Mul, Neg, Sub};

use qrm_core::Scalar;

use crate::verify::Number;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Libm(pub(super) f64);

macro_rules! operators {
    ($($operator:ident $name:ident),*) => {
        $(impl $operator for Libm {
            type Output = Self;
            fn $name(self, other: Self) -> Self { Self(self.0.$name(other.0)) }
        })*
    };
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Libm {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! forward {
    ($($name:ident),*) => {
        $(fn $name(self) -> Self { Self(f64::$name(self.0)) })*
    };
}

impl Scalar for Libm {
    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    fn to_f64(self) -> f64 {
        self.0
    }
    fn sin_cos(self) -> (Self, Self) {
        (Self(self.0.sin()), Self(self.0.cos()))
    }
    forward!(sqrt, tan, asin, acos, atan, exp, ln, sinh, cosh, tanh, floor, abs);
    fn powf(self, exponent: f64) -> Self {
        Self(self.0.powf(exponent))
    }
    fn sign(self) -> Self {
        Self(Scalar::sign(self.0))
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        b - self * a
    }
    fn max(self, other: Self) -> Self {
        Self(Scalar::max(self.0, other.0))
    }
    fn min(self, other: Self) -> Self {
        Self(Scalar::min(self.0, other.0))
    }
    fn atan2(self, abscissa: Self) -> Self {
        Self(self.0.atan2(abscissa.0))
    }
    fn hypot(self, other: Self) -> Self {
        Self(self.0.hypot(other.0))
    }
    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }
    fn pow(self, exponent: Self) -> Self {
        Self(self.0.powf(exponent.0))
    }
    fn is_negative(self) -> bool {
        self.0 < 0.0
    }
    fn is_within(self, bound: f64) -> bool {
        self.0.abs() <= bound
    }
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        if self.is_within(bound) { inside } else { outside }
    }
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let (sin, cos) = self.0.quarter_turns(sin.0, cos.0);
        (Self(sin), Self(cos))
    }
    fn sin_cos_far(self) -> (Self, Self) {
        self.sin_cos()
    }
    fn sin_cos_apart(self) -> (Self, Self) {
        self.sin_cos()
    }
}

impl Number for Libm {
    fn decimal(number: f64) -> Self {
        Self(number)
    }
}
