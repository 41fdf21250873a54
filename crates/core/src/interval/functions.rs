//! Exponential function, logarithm and inverse trigonometric functions of intervals.

use core::f64::consts::LN_2;

use super::Interval;

/// Terms of the series of the exponential function.
const TERMS: u32 = 18;
/// The largest number of doublings within the range of doubles.
const MOST_DOUBLINGS: i32 = 1000;

/// All of these functions are monotonic, so their values at the ends suffice.
///
/// The inverse functions begin with the double of the standard library, without an assumption about its error. The
/// distance from the exact value follows from the function itself.
impl Interval {
    /// Exponential function.
    #[must_use]
    pub fn exp(self) -> Self {
        self.by_ends(exp)
    }

    /// Hyperbolic tangent.
    #[must_use]
    pub fn tanh(self) -> Self {
        self.by_ends(|end| {
            let falling = exp(-2.0 * end.abs());
            let size = (Self::ONE - falling) / (Self::ONE + falling);
            if end < 0.0 { -size } else { size }
        })
    }

    /// Natural logarithm; all real numbers if the interval contains one that is not positive.
    #[must_use]
    pub fn ln(self) -> Self {
        if self.lo <= 0.0 { Self::ENTIRE } else { self.by_ends(ln) }
    }

    /// Inverse tangent.
    #[must_use]
    pub fn atan(self) -> Self {
        self.by_ends(|end| atan(Self::point(end)))
    }

    /// Inverse sine; all real numbers unless the interval lies inside (-1, 1).
    #[must_use]
    pub fn asin(self) -> Self {
        self.by_ends(|end| {
            let end = Self::point(end);
            atan(end / ((Self::ONE - end) * (Self::ONE + end)).sqrt())
        })
    }

    /// Angle of the vectors with ordinate `self` and this abscissa; all real numbers if they enclose zero or lie on
    /// both sides of the negative half-axis.
    #[must_use]
    pub fn atan2(self, abscissa: Self) -> Self {
        let quarter = Self::pi() * Self::point(0.5);
        if abscissa.lo > 0.0 {
            (self / abscissa).atan()
        } else if self.lo > 0.0 {
            quarter - (abscissa / self).atan()
        } else if self.hi < 0.0 {
            -quarter - (abscissa / self).atan()
        } else if self == Self::ZERO && abscissa.hi < 0.0 {
            Self::pi()
        } else {
            Self::ENTIRE
        }
    }

    fn by_ends(self, f: impl Fn(f64) -> Self) -> Self {
        if self.is_finite() { Self::new(f(self.lo).lo, f(self.hi).hi) } else { Self::ENTIRE }
    }
}

fn exp(x: f64) -> Interval {
    let doublings = (x / LN_2).round();
    if doublings.abs() > f64::from(MOST_DOUBLINGS) {
        return if x < 0.0 { Interval::new(0.0, 2.0_f64.powi(-MOST_DOUBLINGS)) } else { Interval::ENTIRE };
    }
    // The logarithm of 2 lies within one unit in the last place of its double.
    let rest = Interval::point(x) - Interval::point(doublings) * Interval::outward(LN_2, LN_2);
    if rest.magnitude() > 0.5 {
        return Interval::ENTIRE;
    }
    // Lagrange's remainder is the next term times a number below the square root of e.
    let mut sum = Interval::new(0.6, 1.65);
    for k in (1..=TERMS).rev() {
        sum = Interval::ONE + rest / Interval::point(f64::from(k)) * sum;
    }
    sum * Interval::point(2.0_f64.powi(doublings as i32))
}

fn ln(x: f64) -> Interval {
    let near = Interval::point(x.ln());
    // The logarithm of `1 + z` lies between `z - z^2` and `z`.
    let z = Interval::point(x) * (-near).exp() - Interval::ONE;
    if z.magnitude() > 0.1 { Interval::ENTIRE } else { near + z - z.square() * Interval::new(0.0, 1.0) }
}

fn atan(x: Interval) -> Interval {
    if !x.is_finite() {
        return x;
    }
    let near = Interval::point(x.mid().atan());
    let (sine, cosine) = near.sin_cos();
    // The tangent `w` of the distance; its inverse tangent is `w` times a number between `1 - w^2` and one.
    let w = (x * cosine - sine) / (cosine + x * sine);
    if w.magnitude() > 0.1 {
        Interval::ENTIRE
    } else {
        near + w * (Interval::ONE - w.square() * Interval::new(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DoubleDouble, Scalar};

    #[test]
    fn values_of_32_digits_are_contained() {
        let holds = |interval: Interval, value: DoubleDouble, at: f64| {
            let inside = (value - interval.lo.into()).to_f64() >= 0.0
                && (DoubleDouble::from(interval.hi) - value).to_f64() >= 0.0;
            assert!(inside, "{interval:?} at {at}");
            assert!(
                interval.width() <= 1e-14 * value.to_f64().abs().max(1.0) * at.abs().max(1.0),
                "{interval:?} at {at}"
            );
        };
        for k in -3000..3000 {
            let x = f64::from(k) * 0.013;
            let (interval, number) = (Interval::point(x), DoubleDouble::from(x));
            holds(interval.exp(), number.exp(), x);
            holds(interval.atan(), number.atan(), x);
            holds(interval.tanh(), number.tanh(), x);
            let y = f64::from(k % 77) * 0.3 + 0.1;
            holds(Interval::point(y).atan2(interval), DoubleDouble::from(y).atan2(number), x);
            if x > 0.0 {
                holds(interval.ln(), number.ln(), x);
            }
            let part = x / 40.0;
            holds(Interval::point(part).asin(), DoubleDouble::from(part).asin(), part);
        }
    }

    #[test]
    fn what_has_no_value_is_everything() {
        for unknown in [
            Interval::new(0.0, 1.0).ln(),
            Interval::new(0.0, 1.0).asin(),
            Interval::new(0.0, 2.0).asin(),
            Interval::point(1e4).exp(),
            Interval::new(0.0, 1.0).atan2(Interval::new(-1.0, 1.0)),
            Interval::new(-0.1, 1.0).atan2(Interval::point(-1.0)),
        ] {
            assert_eq!(unknown, Interval::ENTIRE);
        }
        assert!(Interval::new(0.0, 1.0).exp().contains(std::f64::consts::E));
        assert_eq!(Interval::point(-1e6).exp(), Interval::new(0.0, 2.0_f64.powi(-MOST_DOUBLINGS)));
    }
}
