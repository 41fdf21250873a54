//! Numbers that count what is done with them.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use qrm_core::Scalar;

thread_local! {
    static DONE: Cell<usize> = const { Cell::new(0) };
}

/// Additions, multiplications, divisions and roots while something runs; sines and cosines are counted apart, by
/// nobody.
pub(crate) fn operations<T>(run: impl Fn() -> T) -> usize {
    DONE.set(0);
    std::hint::black_box(run());
    DONE.get()
}

fn note(count: usize) {
    DONE.set(DONE.get() + count);
}

/// A double that counts; changes of sign cost nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counting(pub(crate) f64);

macro_rules! operators {
    ($($operator:ident $name:ident),*) => {
        $(impl $operator for Counting {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                note(1);
                Self(self.0.$name(other.0))
            }
        })*
    };
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Counting {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! one_each {
    ($($name:ident),*) => {
        $(fn $name(self) -> Self {
            note(1);
            Self(self.0.$name())
        })*
    };
}

macro_rules! two_each {
    ($($name:ident $of:ident),*) => {
        $(fn $name(self, other: Self) -> Self {
            note(1);
            Self(self.0.$of(other.0))
        })*
    };
}

impl Scalar for Counting {
    fn to_f64(self) -> f64 {
        self.0
    }

    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    fn sin_cos(self) -> (Self, Self) {
        (Self(self.0.sin()), Self(self.0.cos()))
    }
    fn powf(self, exponent: f64) -> Self {
        note(1);
        Self(self.0.powf(exponent))
    }
    fn sign(self) -> Self {
        note(1);
        Self(self.0.sign())
    }
    one_each!(sqrt, asin, acos, atan, exp, ln, sinh, cosh, tanh);
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        b - self * a
    }
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    fn floor(self) -> Self {
        note(1);
        Self(self.0.floor())
    }
    fn powi(self, exponent: i32) -> Self {
        note(1);
        Self(self.0.powi(exponent))
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
    two_each!(max max, min min, atan2 atan2, hypot hypot, pow powf);
}
