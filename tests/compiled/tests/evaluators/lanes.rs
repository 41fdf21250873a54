//! Four numbers at once, of which the first is the one that is asked for; what the others do must not change it.

use std::ops::{Add, Div, Mul, Neg, Sub};

use qrm_core::{DoubleDouble, Scalar, sin_cos};

use super::number::Number;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes([f64; 4]);

impl Lanes {
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    fn pairs(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl Number for Lanes {
    fn input(value: f64) -> Self {
        Self([value, value + 0.3, -value, 1e7 * value])
    }
    fn value(self) -> DoubleDouble {
        self.0[0].into()
    }
}

macro_rules! operators {
    ($($operator:ident $name:ident),*) => {
        $(impl $operator for Lanes {
            type Output = Self;
            fn $name(self, other: Self) -> Self { self.pairs(other, f64::$name) }
        })*
    };
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Lanes {
    type Output = Self;
    fn neg(self) -> Self {
        self.each(f64::neg)
    }
}

macro_rules! of_one {
    ($($name:ident),*) => { $(fn $name(self) -> Self { self.each(f64::$name) })* };
}

macro_rules! of_two {
    ($($name:ident),*) => { $(fn $name(self, other: Self) -> Self { self.pairs(other, <f64 as Scalar>::$name) })* };
}

impl Scalar for Lanes {
    fn from_f64(value: f64) -> Self {
        Self([value; 4])
    }
    fn to_f64(self) -> f64 {
        self.0[0]
    }
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
    of_one!(sqrt, asin, acos, atan, exp, ln, sinh, cosh, tanh, abs);
    of_two!(max, min, atan2, hypot, pow);
    fn powf(self, exponent: f64) -> Self {
        self.each(|x| x.powf(exponent))
    }
    fn powi(self, exponent: i32) -> Self {
        self.each(|x| x.powi(exponent))
    }
    fn floor(self) -> Self {
        self.each(|x| x.floor())
    }
    fn sign(self) -> Self {
        self.each(|x| x.sign())
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        b - self * a
    }
    fn is_negative(self) -> bool {
        self.0.iter().all(|x| *x < 0.0)
    }
    fn is_within(self, bound: f64) -> bool {
        self.0.iter().all(|x| x.abs() <= bound)
    }
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        Self(std::array::from_fn(|i| if self.0[i].abs() <= bound { inside.0[i] } else { outside.0[i] }))
    }
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let each: [(f64, f64); 4] = std::array::from_fn(|i| self.0[i].quarter_turns(sin.0[i], cos.0[i]));
        (Self(each.map(|(sin, _)| sin)), Self(each.map(|(_, cos)| cos)))
    }
    fn sin_cos_far(self) -> (Self, Self) {
        let each = self.0.map(Scalar::sin_cos_far);
        (Self(each.map(|(sin, _)| sin)), Self(each.map(|(_, cos)| cos)))
    }
    fn sin_cos_apart(self) -> (Self, Self) {
        self.sin_cos()
    }
}
