//! Functions given by points: cubic splines, or lines.

mod slopes;
mod written;

use std::hash::{Hash, Hasher};

use crate::expression::Number;
use crate::function::Differentiable;
use slopes::{natural_slopes, periodic_slopes};

/// A piecewise polynomial of one variable: cubic with two continuous derivatives, or linear with corners. All its
/// numbers are doubles.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Spline {
    /// The name of the spline in formulae.
    pub name: String,
    /// The degree of its pieces, 1 or 3.
    degree: usize,
    /// The period, if the spline is periodic. Beyond their ends, other cubic splines continue as straight lines, and
    /// linear ones are constant.
    period: Option<f64>,
    /// The start of the spline, of its second piece, and of each later piece. Pieces are polynomials in the distance
    /// from there. Without a period the first two are equal, since the first piece lies before them.
    bases: Vec<f64>,
    /// The coefficients of each piece, constant term first.
    pieces: Vec<[f64; 4]>,
}

impl Spline {
    /// Creates the periodic spline through four points or more, whose last ordinate equals the first: it repeats after
    /// the last abscissa. `None` if abscissae do not increase, or a coefficient is not finite.
    pub fn periodic(name: &str, x: &[f64], y: &[f64]) -> Option<Self> {
        let slopes = periodic_slopes(x, y);
        let count = x.len() - 1;
        let spline = Self {
            name: name.to_owned(),
            degree: 3,
            period: Some(x[count] - x[0]),
            bases: x[..count].to_vec(),
            pieces: (0..count).map(|i| piece(x, y, &slopes, i)).collect(),
        };
        spline.is_sound(x).then_some(spline)
    }

    /// Creates the natural spline through two points or more, without curvature at its ends and straight beyond them.
    /// `None` if abscissae do not increase, or a coefficient is not finite.
    pub fn natural(name: &str, x: &[f64], y: &[f64]) -> Option<Self> {
        let slopes = natural_slopes(x, y);
        let last = x.len() - 1;
        let inner = natural_pieces(x, y);
        let line = |i: usize| [y[i], slopes[i], 0.0, 0.0];
        Self::open(name, 3, x, [vec![line(0)], inner, vec![line(last)]].concat())
    }

    /// Creates straight lines between two points or more, constant beyond the first and the last. `None` if abscissae
    /// do not increase, or a slope is not finite.
    pub fn linear(name: &str, x: &[f64], y: &[f64]) -> Option<Self> {
        let slope = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
        let last = x.len() - 1;
        let inner = (0..last).map(|i| [y[i], slope(i), 0.0, 0.0]);
        let [before, behind] = [y[0], y[last]].map(|end| std::iter::once([end, 0.0, 0.0, 0.0]));
        Self::open(name, 1, x, before.chain(inner).chain(behind).collect())
    }

    /// Creates a spline with a piece before its first point and another after its last one.
    fn open(name: &str, degree: usize, x: &[f64], pieces: Vec<[f64; 4]>) -> Option<Self> {
        let bases = std::iter::once(x[0]).chain(x.iter().copied()).collect();
        let spline = Self { name: name.to_owned(), degree, period: None, bases, pieces };
        spline.is_sound(x).then_some(spline)
    }

    fn is_sound(&self, x: &[f64]) -> bool {
        x.windows(2).all(|pair| pair[0] < pair[1]) && self.pieces.iter().flatten().all(|c| c.is_finite())
    }

    /// The derivative of this order; order 0 is the value itself.
    pub fn value<D: Differentiable>(&self, order: usize, x: D) -> D {
        let x = self.period.map_or(x, |period| {
            let turns = ((x.re() - self.first()) / period).floor();
            x - D::from(period) * D::from(turns)
        });
        let piece = self.breakpoints().partition_point(|breakpoint| *breakpoint <= x.re());
        let distance = x - decimal::<D>(self.bases[piece]);
        let coefficients = derived(self.pieces[piece], order);
        coefficients.iter().rev().fold(D::from(0.0), |sum, c| sum * distance + decimal::<D>(*c))
    }

    /// The positions of its corners.
    pub fn corners(&self) -> &[f64] {
        if self.degree == 1 { self.breakpoints() } else { &[] }
    }

    /// The number of its pieces.
    pub(crate) fn piece_count(&self) -> usize {
        self.pieces.len()
    }

    /// The start of the spline.
    fn first(&self) -> f64 {
        self.bases[0]
    }

    /// The start of the second piece and of each later piece.
    fn breakpoints(&self) -> &[f64] {
        &self.bases[1..]
    }

    /// The shortest distance between points.
    pub fn shortest_interval(&self) -> f64 {
        let end = self.period.map(|period| self.first() + period);
        let points: Vec<f64> = self.bases.iter().copied().chain(end).collect();
        let lengths = points.windows(2).map(|pair| pair[1] - pair[0]).filter(|length| *length > 0.0);
        lengths.fold(f64::INFINITY, f64::min)
    }

    /// The bits that identify the spline.
    fn bits(&self) -> impl Iterator<Item = u64> {
        let kind = [self.degree as f64, self.period.unwrap_or(0.0)].into_iter();
        kind.chain(self.bases.iter().copied()).chain(self.pieces.iter().flatten().copied()).map(f64::to_bits)
    }
}

/// The coefficients of each piece of the natural spline between its points, in powers of the distance from the start of
/// the piece, constant term first.
pub fn natural_pieces(x: &[f64], y: &[f64]) -> Vec<[f64; 4]> {
    let slopes = natural_slopes(x, y);
    (0..x.len() - 1).map(|i| piece(x, y, &slopes, i)).collect()
}

impl PartialEq for Spline {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.bits().eq(other.bits())
    }
}

impl Eq for Spline {}

impl Hash for Spline {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
        self.bits().for_each(|bits| bits.hash(state));
    }
}

impl PartialOrd for Spline {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Spline {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.name.cmp(&other.name).then_with(|| self.bits().cmp(other.bits()))
    }
}

/// Converts a double through its shortest decimal, as written in generated modules, into a number of full precision.
fn decimal<D: Differentiable>(value: f64) -> D {
    let has_more_digits = ((D::from(1.0) + 1e-20) - 1.0).re() != 0.0;
    let number = if has_more_digits { Number::parse(&format!("{:?}", value.abs())) } else { None };
    D::from(value) + number.map_or(0.0, |number| number.rest * value.signum())
}

/// The coefficients of a derivative.
fn derived(mut coefficients: [f64; 4], order: usize) -> [f64; 4] {
    for _ in 0..order {
        let [_, b, c, d] = coefficients;
        coefficients = [b, 2.0 * c, 3.0 * d, 0.0];
    }
    coefficients
}

/// The cubic between two points with these slopes.
fn piece(x: &[f64], y: &[f64], slopes: &[f64], i: usize) -> [f64; 4] {
    let h = x[i + 1] - x[i];
    let chord = (y[i + 1] - y[i]) / h;
    let (left, right) = (slopes[i], slopes[i + 1]);
    [y[i], left, (3.0 * chord - 2.0 * left - right) / h, (left + right - 2.0 * chord) / (h * h)]
}

#[cfg(test)]
mod tests {
    use num_dual::Dual2_64;

    use super::*;
    use crate::evaluate::evaluate;
    use crate::expression::{Expression, Node};

    /// The value with two derivatives.
    fn at(spline: &Spline, x: f64) -> [f64; 3] {
        let value: Dual2_64 = spline.value(0, Dual2_64::from_re(x).derivative());
        [value.re, value.v1, value.v2]
    }

    fn near(found: f64, expected: f64, allowed: f64) {
        assert!((found - expected).abs() <= allowed, "{found:?} instead of {expected:?}");
    }

    /// Second derivatives are equal on both sides of the middle and zero at the ends: 2 m0 + m1 = 3, 2 m0 + 6 m1 + m2 =
    /// 4.5, m1 + 2 m2 = -1.5.
    #[test]
    fn a_natural_spline_through_three_points() {
        let spline = Spline::natural("hill", &[-1.0, 0.0, 2.0], &[0.0, 1.0, 0.0]).expect("a spline");
        near(at(&spline, 0.0)[1], 0.5, 1e-15);
        for (x, y) in [(-1.0, 0.0), (0.0, 1.0), (2.0, 0.0)] {
            near(at(&spline, x)[0], y, 1e-15);
        }
        near(at(&spline, -1.0)[2], 0.0, 1e-14);
        // The spline is straight beyond its ends.
        let [y, slope, _] = at(&spline, 2.0);
        near(at(&spline, 5.0)[0], y + 3.0 * slope, 1e-14);
        near(at(&spline, -7.0)[2], 0.0, 0.0);
    }

    #[test]
    fn a_periodic_spline_comes_back() {
        let x: Vec<f64> = (0..=12).map(|i| f64::from(i) * 30.0 - 40.0).collect();
        let mut y: Vec<f64> = (0..12).map(|i| (f64::from(i) * 1.7).sin() + 0.1 * f64::from(i * (12 - i))).collect();
        y.push(y[0]);
        let spline = Spline::periodic("lift", &x, &y).expect("a spline");
        for turn in [-3.0, 0.0, 2.0] {
            for (x, y) in x.iter().zip(&y) {
                near(at(&spline, x + 360.0 * turn)[0], *y, 1e-13);
            }
        }
        // The value and both derivatives are continuous at every point.
        for x in &x {
            let (before, after) = (at(&spline, x - 1e-9), at(&spline, x + 1e-9));
            for (order, allowed) in [1e-8, 1e-10, 1e-10].into_iter().enumerate() {
                near(before[order], after[order], allowed);
            }
        }
    }

    /// A sine through points every five degrees: the error decreases with the fourth power of their distance.
    #[test]
    fn a_fine_spline_is_near_the_function_behind_it() {
        let error = |count: i32| {
            let x: Vec<f64> = (0..=count).map(|i| 360.0 / f64::from(count) * f64::from(i)).collect();
            let mut y: Vec<f64> = x.iter().map(|x| x.to_radians().sin()).collect();
            y[count as usize] = y[0];
            let spline = Spline::periodic("wave", &x, &y).expect("a spline");
            (0..1000)
                .map(|i| f64::from(i) * 0.36)
                .map(|x| (at(&spline, x)[0] - x.to_radians().sin()).abs())
                .fold(0.0, f64::max)
        };
        let ratio = error(36) / error(72);
        assert!((ratio - 16.0).abs() < 0.5, "{ratio}");
    }

    #[test]
    fn lines_pass_through_their_points_and_stay_at_their_ends() {
        let lines = Spline::linear("cut", &[0.0, 2.0, 3.0, 7.0], &[1.0, 5.0, 5.0, -3.0]).expect("lines");
        for (x, y) in
            [(-9.0, 1.0), (0.0, 1.0), (0.5, 2.0), (2.0, 5.0), (2.5, 5.0), (5.0, 1.0), (7.0, -3.0), (99.0, -3.0)]
        {
            near(at(&lines, x)[0], y, 1e-15);
        }
        assert!(lines.corners().len() == 4 && at(&lines, 6.0)[1..] == [-2.0, 0.0]);
        assert!(Spline::linear("steep", &[0.0, 1e-300], &[0.0, 1e300]).is_none());
    }

    /// A distant first point costs the others no digits.
    #[test]
    fn lines_before_a_point_leave_no_rounding_errors_behind_it() {
        let lines = Spline::linear("pulse", &[0.3, 0.5, 0.5 + 1e-9, 0.7], &[0.0, 1e9, 0.0, 0.0]).expect("lines");
        let mut formula = Expression::<()>::new();
        let argument = formula.push(Node::Name(()), 0..0);
        lines.append(0, &mut formula, argument, &(0..0));
        assert!([-1.0, 0.2, 0.6, 0.8].iter().all(|x| evaluate(&formula, |()| *x) == 0.0));
    }

    #[test]
    fn the_steps_are_the_spline() {
        let x = [0.0, 20.0, 75.0, 180.0, 360.0];
        let periodic = Spline::periodic("lift", &x, &[0.0, 2.0, 5.0, 1.0, 0.0]).expect("a spline");
        let natural = Spline::natural("lift", &x, &[0.0, 2.0, 5.0, 1.0, -3.0]).expect("a spline");
        let linear = Spline::linear("lift", &x, &[1.0, 2.0, 2.0, 0.0, -3.0]).expect("lines");
        for spline in [periodic, natural, linear] {
            for order in 0..=4 {
                let mut formula = Expression::<()>::new();
                let argument = formula.push(Node::Name(()), 0..0);
                spline.append(order, &mut formula, argument, &(0..0));
                // At a corner the slope has two values.
                let is_defined = |x: &f64| order == 0 || !spline.corners().contains(x);
                for x in (-90..90).map(|i| f64::from(i) * 10.0).chain(x).filter(is_defined) {
                    let expected = spline.value(order, x);
                    near(evaluate(&formula, |()| x), expected, 1e-12 * (1.0 + expected.abs()));
                }
            }
        }
    }

    /// Distances of points differ by a factor of ten thousand.
    #[test]
    fn points_may_stand_close_together() {
        let x = [0.0, 1e-4, 2e-4, 1.0, 2.0];
        let y = [0.0, 1.0, 0.5, -1.0, 0.0];
        for spline in [Spline::natural("close", &x, &y), Spline::periodic("close", &x, &y)] {
            let spline = spline.expect("a spline");
            near(spline.shortest_interval(), 1e-4, 1e-18);
            for (x, y) in x.iter().zip(y) {
                near(at(&spline, *x)[0], y, 1e-12);
            }
        }
    }

    #[test]
    fn the_last_interval_of_a_period_counts() {
        let spline = Spline::periodic("late", &[0.0, 1.0, 2.0, 3.0, 3.5], &[0.0, 1.0, 1.0, 2.0, 0.0]);
        near(spline.expect("a spline").shortest_interval(), 0.5, 0.0);
    }

    #[test]
    fn numbers_that_no_double_tells_apart_give_no_spline() {
        assert!(Spline::natural("same", &[0.0, 1.0, 1.0], &[0.0, 1.0, 2.0]).is_none());
        assert!(Spline::natural("huge", &[0.0, 1.0, 2.0], &[0.0, 1e308, -1e308]).is_none());
        assert!(Spline::periodic("line", &[0.0, 1.0, 2.0, 3.0], &[1.0, 1.0, 1.0, 1.0]).is_some());
        assert!(
            Spline::natural("line", &[0.0, 1.0], &[0.0, 2.0]).is_some_and(|line| at(&line, 0.25) == [0.5, 2.0, 0.0])
        );
    }
}
