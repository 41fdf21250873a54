//! Numbers of about 32 digits.

mod functions;
mod scalar;

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::{Scalar, math};

/// A number of about 32 digits: the sum of a double and a second one of at most half a unit in its last place.
///
/// Relative errors of operations and functions are below 1e-31; sines and cosines accept angles up to 1e15. In numbers
/// that are not finite the second part is zero.
///
/// The algorithms are those of Dekker (1971), Hida, Li and Bailey (2001), and Joldes, Muller and Popescu (2017).
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

impl DoubleDouble {
    /// The ratio of a circle's circumference to its diameter.
    pub const PI: Self = Self { hi: core::f64::consts::PI, lo: 1.224_646_799_147_353_2e-16 };
    const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// The exact sum of two doubles.
    pub fn sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        let part = hi - a;
        Self::rounded(hi, (a - (hi - part)) + (b - part))
    }

    /// The exact product of two doubles.
    pub fn product(a: f64, b: f64) -> Self {
        let hi = a * b;
        Self::rounded(hi, math::mul_add(a, b, -hi))
    }

    /// The simplest fraction of integers whose nearest double is `value`. The product of the integers is below 1e14;
    /// the result is `None` if there is no such fraction. A random double has one with a probability of a hundredth.
    ///
    /// The convergents of the continued fraction are tested: a fraction so simple is one of them.
    pub fn fraction(value: f64) -> Option<Self> {
        let (mut rest, [mut p, mut q]) = (value, [[1.0, 0.0], [0.0, 1.0]]);
        loop {
            let whole = Scalar::floor(rest);
            p = [math::mul_add(whole, p[0], p[1]), p[0]];
            q = [math::mul_add(whole, q[0], q[1]), q[0]];
            if !((p[0] * q[0]).abs() < 1e14) {
                return None;
            }
            if p[0] / q[0] == value {
                return Some(Self::from(p[0]) / Self::from(q[0]));
            }
            rest = (rest - whole).recip();
        }
    }

    /// The double nearest to the number.
    pub fn hi(self) -> f64 {
        self.hi
    }

    /// The difference between the number and the double nearest to it.
    pub fn lo(self) -> f64 {
        self.lo
    }

    /// The exact sum of two doubles; the first must not be smaller in size.
    fn ordered_sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        Self::rounded(hi, b - (hi - a))
    }

    fn rounded(hi: f64, lo: f64) -> Self {
        Self { hi, lo: if hi.is_finite() { lo } else { 0.0 } }
    }

    /// The number times a power of two, exactly.
    fn scaled(self, power: f64) -> Self {
        Self { hi: self.hi * power, lo: self.lo * power }
    }

    fn is_finite(self) -> bool {
        self.hi.is_finite()
    }
}

impl From<f64> for DoubleDouble {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (Self::sum(self.hi, other.hi), Self::sum(self.lo, other.lo));
        let high = Self::ordered_sum(high.hi, high.lo + low.hi);
        Self::ordered_sum(high.hi, high.lo + low.lo)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = Self::product(self.hi, other.hi);
        let low = math::mul_add(self.lo, other.hi, math::mul_add(self.hi, other.lo, self.lo * other.lo));
        Self::ordered_sum(high.hi, high.lo + low)
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        if first == 0.0 || !first.is_finite() {
            return first.into();
        }
        let rest = self - other * first.into();
        let second = rest.hi / other.hi;
        let rest = rest - other * second.into();
        Self::ordered_sum(first, second) + Self::from(rest.hi / other.hi)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}
