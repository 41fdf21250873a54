//! Bounds of an event between states.

use qrm_core::{Interval, Mechanism, Tape, TapeSeries};

use super::arguments::{Argument, ArgumentPolynomials, TERMS, moved_to};

/// The order of the Taylor expansion whose remainder is bounded.
const ORDER: usize = 4;
/// The smallest and the largest margin of intervals that are tried, in widths of those that are asked for.
const LEAST_MARGIN: f64 = 1.0 / 64.0;
const MOST_MARGIN: f64 = 1e4;
/// Rounding errors of an argument, in parts of it.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Bounds of an event with the parameters of a mechanism, in intervals.
#[derive(Clone, Debug)]
pub(super) struct EventBounds {
    series: TapeSeries,
    /// The arguments of the event, as `TapeSeries` numbers them; they are also the places of a row.
    pub(super) arguments: Vec<usize>,
    /// Intervals of the arguments within which the event is negative; empty if none are known.
    negative: Vec<Interval>,
    /// The margin of the next such intervals, in widths of those that are asked for.
    margin: f64,
}

/// Bounds of the event and of its derivatives by the part of a step; all numbers where they are not known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    pub(super) value: Interval,
    pub(super) slope: Interval,
    pub(super) curvature: Interval,
}

impl EventBounds {
    /// `None` if the tape has no event.
    pub(super) fn new(tape: &Tape, mechanism: &dyn Mechanism) -> Option<Self> {
        let parameters = mechanism.parameters();
        let replace = |i: usize| Some(Interval::point(parameters[i]));
        let series = TapeSeries::new(tape, tape.event.as_ref()?, replace, [ORDER, 0]);
        Some(Self { series, arguments: tape.event_arguments(), negative: Vec::new(), margin: 1.0 })
    }

    /// The value at a part of a step.
    pub(super) fn at(&mut self, motion: &ArgumentPolynomials, s: f64) -> Interval {
        self.expand(motion, s, 0.0, 0)
    }

    /// The rounding error of the value at a part of a step; zero where it may jump, or has no value.
    pub(super) fn rounding(&mut self, motion: &ArgumentPolynomials, s: f64) -> f64 {
        let value = self.at(motion, s);
        if value.is_finite() && !self.series.may_jump() { value.width() } else { 0.0 }
    }

    /// The Taylor coefficients of the value at a part of a step, up to order 2.
    pub(super) fn coefficients(&mut self, motion: &ArgumentPolynomials, s: f64) -> [Interval; 3] {
        [0, 1, 2].map(|order| self.expand(motion, s, 0.0, order))
    }

    /// Bounds in a part of a step: the value's natural bound, and a Taylor expansion about the middle.
    ///
    /// The remainder has order [`ORDER`], or order 1 where the event may have a corner.
    pub(super) fn within(&mut self, motion: &ArgumentPolynomials, [begin, end]: [f64; 2]) -> Bound {
        let (middle, radius) = (0.5 * (begin + end), 0.5 * (end - begin));
        let natural = self.expand(motion, middle, radius, 0);
        if natural.hi() < 0.0 || !natural.is_finite() || self.series.may_jump() {
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

    /// Whether the event depends on accelerations or multipliers of `n` coordinates.
    pub(super) fn takes_forces(&self, n: usize) -> bool {
        self.arguments.last().is_some_and(|last| *last > 2 * n)
    }

    /// Whether the event is negative in all of a step, by its natural bound.
    pub(super) fn is_negative_in(&mut self, motion: &ArgumentPolynomials) -> bool {
        let range = |own: &Argument| coefficient_within(&moved_to(0.5, own.coefficients), (0.5, own.error), 0);
        let ranges: Vec<Interval> = motion.arguments.iter().map(range).collect();
        self.natural_bound(&ranges).is_none()
    }

    /// The natural bound where the arguments lie in intervals; `None` if the event is negative there.
    ///
    /// Larger intervals are tried, so that the answer is known for those that follow.
    fn natural_bound(&mut self, ranges: &[Interval]) -> Option<Interval> {
        let mut pairs = ranges.iter().zip(&self.negative);
        if self.negative.len() == ranges.len() && pairs.all(|(range, negative)| range.is_inside(*negative)) {
            return None;
        }
        if self.margin >= 1.0 {
            let reach = 0.5 + self.margin;
            let larger: Vec<Interval> = ranges.iter().map(|range| ball(range.mid(), reach * range.width())).collect();
            if self.evaluate(0, &larger).hi() < 0.0 {
                self.negative = larger;
                self.margin = (2.0 * self.margin).min(MOST_MARGIN);
                return None;
            }
        }
        let natural = self.evaluate(0, ranges);
        let is_negative = natural.hi() < 0.0;
        self.margin *= if is_negative { 2.0 } else { 0.5 };
        self.margin = self.margin.clamp(LEAST_MARGIN, MOST_MARGIN);
        (!is_negative).then_some(natural)
    }

    /// Whether the event may reach zero where each argument and its rate lie in intervals.
    ///
    /// `at` are arguments among them, `[before, after]` the largest times to there and from there on.
    pub(super) fn may_reach_zero(
        &mut self,
        [ranges, rates]: [&[Interval]; 2],
        at: &[Interval],
        [before, after]: [f64; 2],
    ) -> bool {
        let Some(natural) = self.natural_bound(ranges) else { return false };
        if !natural.is_finite() || self.series.may_jump() {
            return true;
        }
        let slope = self.evaluate(1, rates);
        (self.evaluate(0, at) + slope * Interval::new(-before, after)).hi() >= 0.0
    }

    /// The coefficient of an order, for all arguments within a distance from a part of the step.
    ///
    /// Those of lower orders are known.
    fn expand(&mut self, motion: &ArgumentPolynomials, s: f64, radius: f64, order: usize) -> Interval {
        for Argument { number, coefficients, error } in &motion.arguments {
            let coefficient = coefficient_within(&moved_to(s, *coefficients), (radius, *error), order);
            self.series.set(order, *number, &[coefficient]);
        }
        self.series.advance(order);
        self.series.result(order, 0)[0]
    }

    /// The coefficient of an order, from those of the arguments.
    fn evaluate(&mut self, order: usize, coefficients: &[Interval]) -> Interval {
        for (argument, coefficient) in self.arguments.iter().zip(coefficients) {
            self.series.set(order, *argument, &[*coefficient]);
        }
        self.series.advance(order);
        self.series.result(order, 0)[0]
    }
}

/// The interval of numbers within a radius, widened by rounding errors.
pub(super) fn ball(centre: f64, radius: f64) -> Interval {
    let reach = radius + ROUNDING * (centre.abs() + radius);
    Interval::new(centre - reach, centre + reach)
}

/// The Taylor coefficients of an order of a polynomial with an error, for all origins within a radius.
fn coefficient_within(polynomial: &[f64; TERMS], (radius, error): (f64, f64), order: usize) -> Interval {
    let Some((&centre, higher)) = polynomial[order.min(TERMS)..].split_first() else { return Interval::ZERO };
    let (mut reach, mut factor) = (if order == 0 { error } else { 0.0 }, 1.0);
    for (i, coefficient) in higher.iter().enumerate() {
        factor *= radius * (order + i + 1) as f64 / (i + 1) as f64;
        reach += factor * coefficient.abs();
    }
    // Coefficients of higher order that are zero stay exact.
    if centre == 0.0 && reach == 0.0 { Interval::ZERO } else { ball(centre, reach) }
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
