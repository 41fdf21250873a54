//! Sine and cosine of intervals.

use core::f64::consts::FRAC_PI_2;

use super::Interval;

/// The leading 33 bits of a quarter turn; its products with integers below 2^20 are exact.
const QUARTER: f64 = f64::from_bits(FRAC_PI_2.to_bits() & !((1 << 20) - 1));
/// The difference between the double nearest to a quarter turn and `QUARTER`, exactly.
const REST: f64 = FRAC_PI_2 - QUARTER;
/// Bounds of a quarter turn minus the nearest double, 6.1232339957367658...e-17.
const TAIL: [f64; 2] = [6.123_233_995_736_76e-17, 6.123_233_995_736_77e-17];
/// Terms of the series.
const TERMS: u32 = 13;

impl Interval {
    /// Sine and cosine.
    ///
    /// Whole quarter turns are subtracted in parts that bound the quarter turn. If the remaining angle exceeds 1.5 in
    /// size, both results are [-1, 1]. Otherwise the sine is monotonic and the cosine has its maximum at zero, so the
    /// ends suffice. They are evaluated by Taylor polynomials with Lagrange's remainder.
    #[must_use]
    pub fn sin_cos(self) -> (Self, Self) {
        let any = Self::new(-1.0, 1.0);
        if !self.is_finite() || self.lo < -1e6 || self.hi > 1e6 {
            return (any, any);
        }
        // Any number of quarter turns is valid; the nearest one gives the tightest result.
        let turns = whole((0.5 * self.lo + 0.5 * self.hi) / FRAC_PI_2);
        let count = Self::point(turns as f64);
        let rest = self
            - Self::point(turns as f64 * QUARTER)
            - count * Self::point(REST)
            - count * Self::new(TAIL[0], TAIL[1]);
        if !(rest.lo >= -1.5 && rest.hi <= 1.5) {
            return (any, any);
        }
        let [(low_sine, low_cosine), (high_sine, high_cosine)] = [rest.lo, rest.hi].map(series);
        let sine = Self { lo: low_sine.lo, hi: high_sine.hi };
        let top = if rest.contains(0.0) { 1.0 } else { low_cosine.hi.max(high_cosine.hi) };
        let cosine = Self { lo: low_cosine.lo.min(high_cosine.lo), hi: top };
        let (sine, cosine) = match turns & 3 {
            0 => (sine, cosine),
            1 => (cosine, -sine),
            2 => (-sine, -cosine),
            _ => (-cosine, sine),
        };
        let bounded = |value: Self| value.intersection(any).unwrap_or(any);
        (bounded(sine), bounded(cosine))
    }
}

/// The nearest integer of a number below 2^53 in size.
fn whole(value: f64) -> i64 {
    (if value < 0.0 { value - 0.5 } else { value + 0.5 }) as i64
}

/// Sine and cosine of a double of at most 1.5 in size, by their Taylor series in doubles.
///
/// Horner's scheme computes `v_k = 1 - c_k v_(k+1)` with `c_k <= 0.12` from the third term on; with the unit roundoff
/// `u`, the error of `v_3` is below `1.2 u`, and the remainder of the series below `1e-20`. The sine is `y - y w` with
/// `w = y^2/6 v_3 <= 0.375`, whose relative error is `4.3 u`: with both roundings that is `3 u |y|`. The cosine is
/// `(1 - y^2/2) + w` with `w = y^4/24 v_3 <= 0.22`, whose relative error is `6 u`: with three roundings, that of
/// `y^2/2` up to `1.13 u`, that is `3.6 u`.
fn series(y: f64) -> (Interval, Interval) {
    let square = y * y;
    let (mut sine, mut cosine) = (1.0, 1.0);
    for k in (2..=TERMS).rev() {
        let even = f64::from(2 * k);
        sine = 1.0 - square * sine / (even * (even + 1.0));
        if k > 2 {
            cosine = 1.0 - square * cosine / (even * (even - 1.0));
        }
    }
    let sine = y - y * (square / 6.0 * sine);
    let cosine = (1.0 - 0.5 * square) + square * square / 24.0 * cosine;
    (around(sine, 1.5 * f64::EPSILON * y.abs()), around(cosine, 1.8 * f64::EPSILON))
}

/// The interval of the numbers within a distance.
fn around(value: f64, distance: f64) -> Interval {
    Interval::outward(value - distance, value + distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DoubleDouble, Scalar};

    /// Whether an interval contains a double-double number.
    fn holds(interval: Interval, value: DoubleDouble) -> bool {
        let above = (value - interval.lo.into()).to_f64();
        above >= 0.0 && (DoubleDouble::from(interval.hi) - value).to_f64() >= 0.0
    }

    #[test]
    fn values_of_32_digits_are_contained() {
        for k in -40_000..40_000 {
            let angle = f64::from(k) * 0.003_7;
            let (sine, cosine) = Interval::point(angle).sin_cos();
            let (exact_sine, exact_cosine) = DoubleDouble::from(angle).sin_cos();
            assert!(holds(sine, exact_sine) && holds(cosine, exact_cosine), "{angle}");
            assert!(sine.width().max(cosine.width()) < 4e-15, "{angle}");
        }
    }

    #[test]
    fn the_parts_of_a_quarter_turn_bound_it() {
        let rest = (DoubleDouble::pi() * 0.5.into() - QUARTER.into() - REST.into()).to_f64();
        assert!(TAIL[0] < rest && rest < TAIL[1]);
        assert_eq!(QUARTER + REST, FRAC_PI_2);
    }

    #[test]
    fn an_interval_has_the_extremes_between_its_ends() {
        let (sine, cosine) = Interval::new(-0.5, 0.75).sin_cos();
        assert!(cosine.hi == 1.0 && cosine.contains(0.75_f64.cos()) && cosine.lo > 0.73);
        assert!(sine.contains(-(0.5_f64.sin())) && sine.contains(0.75_f64.sin()) && sine.width() < 1.17);
        let (sine, _) = Interval::new(1.0, 2.0).sin_cos();
        assert!(sine.hi == 1.0 && sine.lo > 0.84 && sine.contains(1.0_f64.sin()));
        assert_eq!(Interval::new(0.0, 4.0).sin_cos().0, Interval::new(-1.0, 1.0));
    }
}
