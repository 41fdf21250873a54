//! Double-double numbers in generated functions and tapes.

use super::DoubleDouble;
use crate::Scalar;

impl Scalar for DoubleDouble {
    fn from_f64(value: f64) -> Self {
        value.into()
    }
    fn from_number(value: f64) -> Self {
        Self::fraction(value).unwrap_or(value.into())
    }
    fn to_f64(self) -> f64 {
        self.hi()
    }
    fn pi() -> Self {
        Self::PI
    }
    fn sqrt(self) -> Self {
        self.square_root()
    }
    fn sin_cos(self) -> (Self, Self) {
        self.sine_and_cosine()
    }
    fn asin(self) -> Self {
        self.atan2(((Self::ONE - self) * (Self::ONE + self)).sqrt())
    }
    fn acos(self) -> Self {
        ((Self::ONE - self) * (Self::ONE + self)).sqrt().atan2(self)
    }
    fn atan(self) -> Self {
        self.atan2(Self::ONE)
    }
    fn exp(self) -> Self {
        self.exponential()
    }
    fn ln(self) -> Self {
        self.logarithm()
    }
    fn sinh(self) -> Self {
        self.hyperbolic_sine()
    }
    fn cosh(self) -> Self {
        let power = self.exp();
        (power + power.recip()).scaled(0.5)
    }
    fn tanh(self) -> Self {
        self.hyperbolic_tangent()
    }
    fn powf(self, exponent: f64) -> Self {
        self.pow(exponent.into())
    }
    fn floor(self) -> Self {
        let whole = Scalar::floor(self.hi);
        // The double is an integer, so the second part may still reduce it.
        if whole == self.hi { Self::from(whole) + Scalar::floor(self.lo).into() } else { whole.into() }
    }
    fn sign(self) -> Self {
        self.hi.sign().into()
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        b - self * a
    }
    fn abs(self) -> Self {
        if self.is_negative() { -self } else { self }
    }
    fn max(self, other: Self) -> Self {
        if self > other || self.to_f64().is_nan() { self } else { other }
    }
    fn min(self, other: Self) -> Self {
        if self < other || self.to_f64().is_nan() { self } else { other }
    }
    fn atan2(self, abscissa: Self) -> Self {
        self.angle_from(abscissa)
    }
    fn hypot(self, other: Self) -> Self {
        (self * self + other * other).sqrt()
    }
    fn powi(self, exponent: i32) -> Self {
        self.whole_power(exponent)
    }
    fn pow(self, exponent: Self) -> Self {
        self.power(exponent)
    }
    fn is_negative(self) -> bool {
        self.hi < 0.0
    }
    fn is_within(self, bound: f64) -> bool {
        self.abs() <= bound.into()
    }
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        if self.is_within(bound) { inside } else { outside }
    }
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let n = self.hi.to_bits();
        let (sin, cos) = if n & 1 == 0 { (sin, cos) } else { (cos, sin) };
        (if n & 2 == 0 { sin } else { -sin }, if (n + 1) & 2 == 0 { cos } else { -cos })
    }
    fn sin_cos_far(self) -> (Self, Self) {
        self.sin_cos()
    }
    fn sin_cos_apart(self) -> (Self, Self) {
        self.sin_cos()
    }
}
