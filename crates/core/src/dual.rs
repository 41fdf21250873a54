//! Dual numbers: values with derivatives.

use core::ops::{Add, Div, Mul, Neg, Sub};

use num_dual::DualNum;

use crate::scalar::Scalar;

/// A number of generated functions that wraps any dual number of the crate `num-dual`. The functions return derivatives
/// along with values, with respect to the seeds in the parts of `D`. Comparisons use the value alone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Dual<D>(pub D);

/// The requirements on a kind of dual numbers.
pub trait DualKind: DualNum<Primitive = f64> + Copy + Send + Sync + 'static {}

impl<D: DualNum<Primitive = f64> + Copy + Send + Sync + 'static> DualKind for D {}

macro_rules! operators {
    ($($operator:ident $name:ident),*) => {
        $(impl<D: DualKind> $operator for Dual<D> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self { Self(self.0.$name(other.0)) }
        })*
    };
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl<D: DualKind> Neg for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! forward {
    ($($name:ident),*) => {
        $(#[inline(always)] fn $name(self) -> Self { Self(self.0.$name()) })*
    };
}

impl<D: DualKind> Scalar for Dual<D> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self(D::from(value))
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.0.re()
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos();
        (Self(sin), Self(cos))
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        if self.0.re() == 0.0 && exponent > 2.0 {
            // The crate divides by zero here. The value and its derivatives up to the second are zero.
            return Self(self.0 * self.0 * 0.0);
        }
        Self(self.0.powf(exponent))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(D::from(Scalar::floor(self.0.re())))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(D::from(self.0.re().sign()))
    }
    fn tanh(self) -> Self {
        // sinh over cosh would overflow.
        let less_one = (self.abs().0 * -2.0).exp_m1();
        let size = Self(-less_one / (less_one + 2.0));
        if self.is_negative() { -size } else { size }
    }
    forward!(recip, sqrt, sin, cos, tan, asin, acos, atan, exp, ln, sinh, cosh);
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
        if self.is_negative() { -self } else { self }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.0.re() > other.0.re() || self.0.re().is_nan() { self } else { other }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.0.re() < other.0.re() || self.0.re().is_nan() { self } else { other }
    }
    fn atan2(self, abscissa: Self) -> Self {
        Self(self.0.atan2(abscissa.0))
    }
    fn hypot(self, other: Self) -> Self {
        (self * self + other * other).sqrt()
    }
    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }
    fn pow(self, exponent: Self) -> Self {
        Self(self.0.powd(exponent.0))
    }
    #[inline(always)]
    fn is_negative(self) -> bool {
        self.0.re() < 0.0
    }
    #[inline(always)]
    fn is_within(self, bound: f64) -> bool {
        self.0.re().is_within(bound)
    }
    #[inline(always)]
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        if self.is_within(bound) { inside } else { outside }
    }
    #[inline(always)]
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let n = self.0.re().to_bits();
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

#[cfg(test)]
mod tests {
    use num_dual::HyperDual64;

    use super::Dual;
    use crate::scalar::Scalar;

    #[test]
    fn powers_above_two_have_two_derivatives_at_zero() {
        for x in [0.0_f64, 4.0] {
            for power in [2.5, 3.5, 4.0] {
                let Dual(found) = Dual(HyperDual64::new(x, 1.0, 1.0, 0.0)).powf(power);
                let slope = power * x.powf(power - 1.0);
                let curve = power * (power - 1.0) * x.powf(power - 2.0);
                for (found, wanted) in
                    [(found.re, x.powf(power)), (found.eps1, slope), (found.eps2, slope), (found.eps1eps2, curve)]
                {
                    assert!((found - wanted).abs() <= 1e-14 * wanted, "{found} is not {wanted}");
                }
            }
        }
    }
}
