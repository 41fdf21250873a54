//! A double with a bound of its rounding error, carried along by the derivatives of the operations.

use std::ops::{Add, Div, Mul, Neg, Sub};

use qrm_core::{DoubleDouble, Scalar};

use super::number::Number;

/// Rounding errors of a function, in units of the value.
const UNIT: f64 = 2.0 * f64::EPSILON;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounded {
    value: f64,
    pub(crate) error: f64,
}

impl Bounded {
    /// A value that an operation has rounded, beside the errors that it took over.
    fn rounded(value: f64, error: f64) -> Self {
        // Errors of errors are far below the last place.
        Self { value, error: 1.001 * error + UNIT * value.abs() }
    }

    /// A function with this value and derivative.
    fn function(self, value: f64, derivative: f64) -> Self {
        Self::rounded(value, self.error * derivative.abs())
    }
}

impl Number for Bounded {
    fn value(self) -> DoubleDouble {
        self.value.into()
    }
}

impl Add for Bounded {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::rounded(self.value + other.value, self.error + other.error)
    }
}

impl Sub for Bounded {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Bounded {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let error = self.error * (other.value.abs() + other.error) + self.value.abs() * other.error;
        Self::rounded(self.value * other.value, error)
    }
}

impl Div for Bounded {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self::rounded(value, (self.error + value.abs() * other.error) / (other.value.abs() - other.error))
    }
}

impl Neg for Bounded {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl Scalar for Bounded {
    fn from_f64(value: f64) -> Self {
        Self { value, error: 0.0 }
    }
    fn to_f64(self) -> f64 {
        self.value
    }
    fn pi() -> Self {
        Self { value: std::f64::consts::PI, error: UNIT }
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.function(root, 0.5 / (self.value - self.error).sqrt())
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Scalar::sin_cos(self.value);
        (self.function(sin, cos.abs() + self.error), self.function(cos, sin.abs() + self.error))
    }
    fn asin(self) -> Self {
        self.function(self.value.asin(), 1.0 / (1.0 - self.value * self.value).sqrt())
    }
    fn acos(self) -> Self {
        self.function(self.value.acos(), 1.0 / (1.0 - self.value * self.value).sqrt())
    }
    fn atan(self) -> Self {
        self.function(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }
    fn exp(self) -> Self {
        let power = self.value.exp();
        self.function(power, power)
    }
    fn ln(self) -> Self {
        self.function(self.value.ln(), self.value.recip())
    }
    fn sinh(self) -> Self {
        self.function(self.value.sinh(), self.value.cosh())
    }
    fn cosh(self) -> Self {
        self.function(self.value.cosh(), self.value.sinh())
    }
    fn tanh(self) -> Self {
        let value = self.value.tanh();
        self.function(value, 1.0 - value * value)
    }
    fn powf(self, exponent: f64) -> Self {
        let value = self.value.powf(exponent);
        self.function(value, exponent * value / self.value)
    }
    fn floor(self) -> Self {
        let whole = Scalar::floor(self.value);
        let is_sure = Scalar::floor(self.value - self.error) == Scalar::floor(self.value + self.error);
        Self { value: whole, error: if is_sure { 0.0 } else { 1.0 } }
    }
    fn sign(self) -> Self {
        Self { value: self.value.sign(), error: if self.value.abs() > self.error { 0.0 } else { 2.0 } }
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        b - self * a
    }
    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }
    fn max(self, other: Self) -> Self {
        Self { value: Scalar::max(self.value, other.value), error: self.error.max(other.error) }
    }
    fn min(self, other: Self) -> Self {
        -(-self).max(-other)
    }
    fn atan2(self, abscissa: Self) -> Self {
        let square = self.value * self.value + abscissa.value * abscissa.value;
        let error = self.value.abs() * abscissa.error + abscissa.value.abs() * self.error;
        Self::rounded(self.value.atan2(abscissa.value), error / square)
    }
    fn hypot(self, other: Self) -> Self {
        Self::rounded(self.value.hypot(other.value), self.error + other.error)
    }
    fn powi(self, exponent: i32) -> Self {
        let (n, x) = (f64::from(exponent), self.value);
        let value = x.powi(exponent);
        // Multiplied and rounded once for each factor.
        Self::rounded(value, self.error * (n * x.powi(exponent - 1)).abs() + n.abs() * UNIT * value.abs())
    }
    fn pow(self, exponent: Self) -> Self {
        let value = self.value.powf(exponent.value);
        let by_exponent = if exponent.error > 0.0 { exponent.error * (value * self.value.ln()).abs() } else { 0.0 };
        Self::rounded(value, self.error * (exponent.value * value / self.value).abs() + by_exponent)
    }
    fn is_negative(self) -> bool {
        self.value < 0.0
    }
    fn is_within(self, bound: f64) -> bool {
        self.value.is_within(bound)
    }
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        if self.is_within(bound) { inside } else { outside }
    }
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let (sine, cosine) = self.value.quarter_turns(sin.value, cos.value);
        (Self { value: sine, ..sin }, Self { value: cosine, ..cos })
    }
    fn sin_cos_far(self) -> (Self, Self) {
        self.sin_cos()
    }
    fn sin_cos_apart(self) -> (Self, Self) {
        self.sin_cos()
    }
}
