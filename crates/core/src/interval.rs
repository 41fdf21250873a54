//! Intervals with outward rounding.

#[cfg(feature = "std")]
mod functions;
mod sine;

use core::f64::consts::PI;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// The set of all real numbers between two doubles, ends included.
///
/// The result of an operation contains the results for all numbers in its operands. Doubles are rounded to nearest, so
/// an exact result lies between the neighbours of the rounded one, even below the normal range. If an end overflows, or
/// a result is undefined for some number, the result is [`Interval::ENTIRE`], which proves nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    lo: f64,
    hi: f64,
}

impl Interval {
    /// Zero: sums and products with finite intervals keep it exact.
    pub const ZERO: Self = Self { lo: 0.0, hi: 0.0 };
    /// One.
    pub const ONE: Self = Self { lo: 1.0, hi: 1.0 };
    /// All real numbers.
    pub const ENTIRE: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    /// The interval between two doubles; all real numbers where they are not finite or not in order.
    #[must_use]
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi && lo.is_finite() && hi.is_finite() { Self { lo, hi } } else { Self::ENTIRE }
    }

    /// The interval that contains one double only.
    #[must_use]
    pub fn point(value: f64) -> Self {
        Self::new(value, value)
    }

    /// All numbers that round to a double, among them the decimal from which it was read.
    ///
    /// Integers and multiples of 1/1024, of moderate size, are the only decimals of at most 15 digits that doubles
    /// represent exactly: their interval is a point.
    #[must_use]
    pub fn rounded(value: f64) -> Self {
        let is_short = |value: f64| value.abs() < 1e7 && (value as i64) as f64 == value;
        if is_short(value) || is_short(value * 1024.0) { Self::point(value) } else { Self::outward(value, value) }
    }

    /// The ratio of a circle's circumference to its diameter.
    #[must_use]
    pub fn pi() -> Self {
        // The nearest double is below pi.
        Self { lo: PI, hi: PI.next_up() }
    }

    /// The lower end.
    #[must_use]
    pub const fn lo(self) -> f64 {
        self.lo
    }

    /// The upper end.
    #[must_use]
    pub const fn hi(self) -> f64 {
        self.hi
    }

    /// Whether both ends are finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Whether the interval contains a double.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        self.lo <= value && value <= self.hi
    }

    /// Whether the interval lies strictly inside another.
    #[must_use]
    pub fn is_inside(self, other: Self) -> bool {
        other.lo < self.lo && self.hi < other.hi
    }

    /// An upper bound of the width.
    #[must_use]
    pub fn width(self) -> f64 {
        if self.lo == self.hi { 0.0 } else { (self.hi - self.lo).next_up() }
    }

    /// A double inside, near the middle.
    #[must_use]
    pub fn mid(self) -> f64 {
        0.5 * self.lo + 0.5 * self.hi
    }

    /// The largest absolute value of its numbers.
    #[must_use]
    pub fn magnitude(self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// The smallest interval that contains both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// The intersection; `None` if it is empty.
    #[must_use]
    pub fn intersection(self, other: Self) -> Option<Self> {
        let (lo, hi) = (self.lo.max(other.lo), self.hi.min(other.hi));
        (lo <= hi).then_some(Self { lo, hi })
    }

    /// Square root; all real numbers if the interval contains a negative one.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn sqrt(self) -> Self {
        if !self.is_finite() || self.lo < 0.0 {
            return Self::ENTIRE;
        }
        Self::outward(self.lo.sqrt(), self.hi.sqrt())
            .intersection(Self { lo: 0.0, hi: f64::MAX })
            .unwrap_or(Self::ENTIRE)
    }

    /// Square.
    #[must_use]
    pub fn square(self) -> Self {
        let square = self * self;
        if self.is_finite() && self.contains(0.0) { Self { lo: 0.0, ..square } } else { square }
    }

    /// The interval that contains all numbers which round to ends between these.
    fn outward(lo: f64, hi: f64) -> Self {
        Self::new(lo.next_down(), hi.next_up())
    }

    /// The interval that contains all numbers which round to ends between these, for a result that is not negative if
    /// no operand is: then it has no negative numbers.
    fn outward_from(operands: [Self; 2], lo: f64, hi: f64) -> Self {
        let is_negative = operands[0].lo < 0.0 || operands[1].lo < 0.0;
        Self::new(if is_negative { lo.next_down() } else { lo.next_down().max(0.0) }, hi.next_up())
    }
}

/// The smallest and the largest of four numbers.
fn ends(values: [f64; 4]) -> [f64; 2] {
    [values.into_iter().fold(f64::INFINITY, f64::min), values.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        if !self.is_finite() || !other.is_finite() {
            return Self::ENTIRE;
        }
        match (self == Self::ZERO, other == Self::ZERO) {
            (true, _) => other,
            (_, true) => self,
            _ => Self::outward_from([self, other], self.lo + other.lo, self.hi + other.hi),
        }
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        // Products of finite numbers are never NaN.
        if !self.is_finite() || !other.is_finite() {
            return Self::ENTIRE;
        }
        if self == Self::ZERO || other == Self::ZERO {
            return Self::ZERO;
        }
        let [lo, hi] = ends([self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi]);
        Self::outward_from([self, other], lo, hi)
    }
}

impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        // Quotients of finite numbers by others than zero are never NaN.
        if !self.is_finite() || !other.is_finite() || other.contains(0.0) {
            return Self::ENTIRE;
        }
        if self == Self::ZERO {
            return self;
        }
        let [lo, hi] = ends([self.lo / other.lo, self.lo / other.hi, self.hi / other.lo, self.hi / other.hi]);
        Self::outward_from([self, other], lo, hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn next(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 8.0
    }

    #[test]
    fn exact_results_are_contained() {
        let mut state = 1;
        for _ in 0..100_000 {
            let [a, b] = [next(&mut state), next(&mut state)];
            let [x, y] = [Interval::point(a), Interval::point(b)];
            // The rounding errors of a product and of a sum are doubles.
            let (product, sum) = (a * b, a + b);
            let product_error = a.mul_add(b, -product);
            let part = sum - a;
            let sum_error = (a - (sum - part)) + (b - part);
            let holds = |i: Interval, value: f64, error: f64| {
                (i.lo < value || (i.lo == value && error >= 0.0)) && (value < i.hi || (i.hi == value && error <= 0.0))
            };
            assert!(holds(x * y, product, product_error) && holds(x + y, sum, sum_error), "{a} {b}");
            // The products `q b` enclose `a` for the ends `q` of a quotient.
            let quotient = x / y;
            assert!((quotient * y).contains(a) && quotient.width() <= 4.0 * f64::EPSILON * (a / b).abs(), "{a} {b}");
            let [low, high] = [quotient.lo.mul_add(b, -a), quotient.hi.mul_add(b, -a)];
            assert!(low * high <= 0.0, "{a} / {b}");
            let root = Interval::point(a.abs()).sqrt();
            assert!(root.lo.mul_add(root.lo, -a.abs()) <= 0.0 && root.hi.mul_add(root.hi, -a.abs()) >= 0.0, "{a}");
        }
    }

    #[test]
    fn what_is_not_known_is_everything() {
        let [zero, one] = [Interval::new(-1.0, 1.0), Interval::point(1.0)];
        let huge = Interval::point(f64::MAX);
        for unknown in
            [one / zero, zero.sqrt(), huge * huge, huge + huge, Interval::new(2.0, 1.0), Interval::point(f64::NAN)]
        {
            assert_eq!(unknown, Interval::ENTIRE);
            assert_eq!(unknown * Interval::point(0.0), Interval::ENTIRE);
            assert_eq!(unknown + one, Interval::ENTIRE);
        }
    }

    #[test]
    fn products_that_underflow_are_contained() {
        let tiny = Interval::point(1e-300);
        let product = tiny * tiny;
        assert!(product.lo == 0.0 && product.hi > 0.0);
        let product = tiny * -tiny;
        assert!(product.lo < 0.0 && product.hi > 0.0);
    }

    #[test]
    fn rounding_adds_no_negative_numbers() {
        let [zero_to_one, two] = [Interval::new(0.0, 1.0), Interval::point(2.0)];
        let sum = zero_to_one * two + zero_to_one.square() / two;
        assert!(sum.lo == 0.0 && sum.hi > 2.5 && sum.sqrt().is_finite());
    }

    #[test]
    fn a_product_has_the_extremes_of_its_ends() {
        let product = Interval::new(-2.0, 3.0) * Interval::new(-5.0, 1.0);
        assert!(Interval::new(-15.0, 10.0).is_inside(product) && product.width() < 25.0 + 1e-13);
        assert!(!Interval::new(-15.1, 10.0).is_inside(product));
        assert_eq!(Interval::new(0.0, 1.0).intersection(Interval::new(2.0, 3.0)), None);
    }
}
