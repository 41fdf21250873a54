//! Bounds of a function along the motion, in intervals.

use qrm_core::{Interval, Mechanism, Tape, TapeFunction, TapeSeries};

use super::arguments::{Argument, ArgumentPolynomials, argument, ball, coefficient_within, moved_to};
use super::rows::RowBoxes;
use crate::state::State;

/// The order of the Taylor expansion whose remainder is bounded.
const ORDER: usize = 4;

/// The largest number of iterations for a maximum.
const MOST_ITERATIONS: usize = 30;

/// Bounds of a function of a tape with the parameters of a mechanism, in intervals.
#[derive(Clone, Debug)]
pub(crate) struct FunctionBounds {
    series: TapeSeries,
    /// The arguments of the function, as `TapeSeries` numbers them; they are also the places of a row.
    pub(crate) arguments: Vec<usize>,
}

/// Bounds of a function and of its derivatives by the part of a step; all numbers where they are not known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    pub(crate) value: Interval,
    pub(crate) slope: Interval,
    pub(crate) curvature: Interval,
}

impl FunctionBounds {
    /// Bounds of the first result of a function of a tape.
    pub(crate) fn new(tape: &Tape, function: &TapeFunction, mechanism: &dyn Mechanism) -> Self {
        let parameters = mechanism.parameters();
        let series = TapeSeries::new(tape, function, |i| Some(Interval::point(parameters[i])), [ORDER, 0]);
        Self { arguments: series.arguments(), series }
    }

    /// The degree of the function as a polynomial of its arguments and their sines and cosines; `None` if the function is
    /// no such polynomial.
    pub(crate) fn degree(&self) -> Option<u32> {
        self.series.degree()
    }

    /// The value at a part of a step.
    pub(crate) fn at(&mut self, motion: &ArgumentPolynomials, s: f64) -> Interval {
        self.expand(motion, s, 0.0, 0)
    }

    /// The rounding error of the value at a part of a step; zero where it may jump, or has no value.
    pub(crate) fn rounding(&mut self, motion: &ArgumentPolynomials, s: f64) -> f64 {
        let value = self.at(motion, s);
        self.rounding_of(value)
    }

    /// The rounding error of the value at a state; zero where it may jump, or has no value.
    pub(crate) fn rounding_at(&mut self, state: &State) -> f64 {
        let numbers: Vec<Interval> = self.arguments.iter().map(|i| Interval::point(argument(state, *i))).collect();
        let value = self.evaluate(0, &numbers);
        self.rounding_of(value)
    }

    /// The natural bound near a row, at a distance in parts of its numbers.
    pub(crate) fn near(&mut self, row: &[f64], distance: f64) -> Interval {
        let numbers: Vec<Interval> = self.arguments.iter().map(|i| ball(row[*i], distance * row[*i].abs())).collect();
        self.evaluate(0, &numbers)
    }

    fn rounding_of(&self, value: Interval) -> f64 {
        if value.is_finite() && !self.series.may_jump() { value.width() } else { 0.0 }
    }

    /// Bounds in a part of a step: the value's natural bound, and a Taylor expansion about the middle unless the
    /// natural bound is enough.
    ///
    /// The remainder has order [`ORDER`], or order 1 where the function may have a corner.
    pub(crate) fn within(
        &mut self,
        motion: &ArgumentPolynomials,
        [begin, end]: [f64; 2],
        is_enough: impl Fn(Interval) -> bool,
    ) -> Bound {
        let (middle, radius) = (0.5 * (begin + end), 0.5 * (end - begin));
        let natural = self.expand(motion, middle, radius, 0);
        if is_enough(natural) || !natural.is_finite() || self.series.may_jump() {
            return Bound { value: natural, slope: Interval::ENTIRE, curvature: Interval::ENTIRE };
        }
        let last = if self.series.obstacle().is_none() { ORDER } else { 1 };
        let remainder = (1..=last).map(|order| self.expand(motion, middle, radius, order)).last();
        let mut coefficients = [remainder.unwrap_or(Interval::ENTIRE); ORDER + 1];
        for (order, coefficient) in coefficients[..last].iter_mut().enumerate() {
            *coefficient = self.expand(motion, middle, 0.0, order);
        }
        let [value, slope, curvature] = [0, 1, 2].map(|derivative| sum(&coefficients[..=last], derivative, radius));
        Bound { value: value.intersection(natural).unwrap_or(natural), slope, curvature }
    }

    /// Whether the function rises in all of a step, by the natural bound of its slope.
    pub(crate) fn rises(&mut self, motion: &ArgumentPolynomials) -> bool {
        let natural = self.expand(motion, 0.5, 0.5, 0);
        natural.is_finite() && !self.series.may_jump() && self.expand(motion, 0.5, 0.5, 1).lo() > 0.0
    }

    /// The place where the slope of the function times a sign falls through zero in a part of the step, and half of the
    /// second derivative there, by Newton's method.
    pub(crate) fn turning_point(
        &mut self,
        motion: &ArgumentPolynomials,
        [mut low, mut high]: [f64; 2],
        (sign, shortest): (f64, f64),
    ) -> (f64, f64) {
        let (mut s, mut half_curvature) = (0.5 * (low + high), 0.0);
        for _ in 0..MOST_ITERATIONS {
            let slope;
            [_, slope, half_curvature] = [0, 1, 2].map(|order| self.expand(motion, s, 0.0, order).mid());
            if sign * slope > 0.0 {
                low = s
            } else {
                high = s
            }
            let newton = s - 0.5 * slope / half_curvature;
            let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
            let moved = (next - s).abs();
            s = next;
            if moved <= shortest {
                break;
            }
        }
        (s, half_curvature)
    }

    /// Whether the function may jump among the arguments of the last bound.
    pub(crate) fn may_jump(&self) -> bool {
        self.series.may_jump()
    }

    /// Whether the function is smooth among the arguments of the last bound.
    pub(crate) fn is_smooth(&self) -> bool {
        self.series.obstacle().is_none()
    }

    /// Whether the function depends on accelerations or multipliers of `n` coordinates.
    pub(crate) fn takes_forces(&self, n: usize) -> bool {
        self.arguments.last().is_some_and(|last| *last > 2 * n)
    }

    /// The coefficient of an order, for all arguments within a distance from a part of the step; coefficients of lower
    /// orders are known.
    fn expand(&mut self, motion: &ArgumentPolynomials, s: f64, radius: f64, order: usize) -> Interval {
        for Argument { number, coefficients, error } in &motion.arguments {
            let coefficient = coefficient_within(&moved_to(s, *coefficients), (radius, *error), order);
            self.series.set(order, *number, &[coefficient]);
        }
        self.series.advance(order);
        self.series.result(order, 0)[0]
    }

    /// The coefficient of an order among rows; coefficients of lower orders are known.
    pub(crate) fn among(&mut self, boxes: &RowBoxes, order: usize) -> Interval {
        let coefficients = boxes.coefficients(order, &self.arguments);
        self.evaluate(order, &coefficients)
    }

    /// The coefficient of an order, from the coefficients of the arguments.
    pub(crate) fn evaluate(&mut self, order: usize, coefficients: &[Interval]) -> Interval {
        for (argument, coefficient) in self.arguments.iter().zip(coefficients) {
            self.series.set(order, *argument, &[*coefficient]);
        }
        self.series.advance(order);
        self.series.result(order, 0)[0]
    }
}

/// A derivative of a Taylor expansion, for all arguments within a radius; all numbers beyond its order.
fn sum(coefficients: &[Interval], derivative: usize, radius: f64) -> Interval {
    let Some(first) = coefficients.get(derivative) else { return Interval::ENTIRE };
    let mut sum = *first * Interval::point(falling_factorial(derivative, derivative));
    let mut power = 1.0;
    for (k, coefficient) in coefficients.iter().enumerate().skip(derivative + 1) {
        power = (power * radius).next_up();
        let powers = Interval::new(if (k - derivative).is_multiple_of(2) { 0.0 } else { -power }, power);
        sum = sum + *coefficient * powers * Interval::point(falling_factorial(k, derivative));
    }
    sum
}

/// `k (k - 1) ... (k - count + 1)`.
fn falling_factorial(k: usize, count: usize) -> f64 {
    (0..count).map(|i| (k - i) as f64).product()
}
