//! The arguments of a function inside a step: polynomials of the part of the step.

use qrm_core::{Interval, Mechanism};

use crate::integrate::{quintic, quintic_coefficients};
use crate::solve::Solver;
use crate::state::State;

/// The largest degree of a polynomial, plus one.
pub(super) const TERMS: usize = 6;

/// Rounding errors of an argument, in parts of it.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The largest rounding error of a rate by differences of coordinates, in parts of it.
const MOST_ROUNDING: f64 = 1e-11;

/// The largest difference of an argument from its polynomial that is small, in parts of its size.
const SMALL: f64 = 1e-11;

/// The polynomials of some arguments of a function between the ends of a step, where the part `s` is 0 and 1.
///
/// Coordinates are the polynomials of degree 5 through both ends, with their rates and accelerations. Rates are their
/// derivatives. Accelerations and multipliers follow from the state: their polynomials go through those of six states.
#[derive(Clone, Debug)]
pub(crate) struct ArgumentPolynomials {
    pub(super) arguments: Vec<Argument>,
}

/// The polynomial of an argument.
#[derive(Clone, Debug)]
pub(crate) struct Argument {
    /// Its number, as in `TapeSeries`.
    pub(super) number: usize,
    /// The coefficients in powers of `s`.
    pub(super) coefficients: [f64; TERMS],
    /// The largest difference from the motion, if it is to count.
    pub(super) error: f64,
}

impl ArgumentPolynomials {
    /// The polynomials between two states; `None` if accelerations are not determined between them.
    pub(crate) fn between(
        mechanism: &dyn Mechanism,
        solver: Option<&mut Solver>,
        [from, to]: [&State; 2],
        arguments: &[usize],
    ) -> Option<Self> {
        let (n, h) = (from.q.len(), to.t - from.t);
        let states = match solver {
            Some(solver) => Some(states(mechanism, solver, [from, to])?),
            None => None,
        };
        let polynomials = arguments.iter().map(|&argument| {
            let derived = |value: &dyn Fn(&State) -> f64| {
                states.as_ref().map_or([0.0; TERMS], |states| through(std::array::from_fn(|i| value(&states[i]))))
            };
            let polynomial = match argument {
                0 => [from.t, h, 0.0, 0.0, 0.0, 0.0],
                i if i <= n => quintic_coefficients(h, [from, to], i - 1),
                i if i <= 2 * n => rate(h, [from, to], i - 1 - n),
                i if i <= 3 * n => derived(&|at| at.qdd[i - 1 - 2 * n]),
                i => derived(&|at| at.multipliers[i - 1 - 3 * n]),
            };
            Argument { number: argument, coefficients: polynomial, error: 0.0 }
        });
        Some(Self { arguments: polynomials.collect() })
    }

    /// Compares the polynomials with the state in the middle of the step, where their error is largest.
    ///
    /// The differences become their errors. Returns whether these are small.
    pub(crate) fn compare_with(&mut self, middle: &State) -> bool {
        let mut are_small = true;
        for Argument { number, coefficients, error } in &mut self.arguments {
            *error = (moved_to(0.5, *coefficients)[0] - argument(middle, *number)).abs();
            are_small &= *error <= SMALL * coefficients.iter().map(|coefficient| coefficient.abs()).sum::<f64>();
        }
        are_small
    }

    /// The intervals of the arguments in the step.
    pub(crate) fn ranges(&self) -> Vec<Interval> {
        let range = |own: &Argument| coefficient_within(&moved_to(0.5, own.coefficients), (0.5, own.error), 0);
        self.arguments.iter().map(range).collect()
    }

    /// A copy of the polynomials with their errors; these ones forget them.
    pub(crate) fn take_errors(&mut self) -> Self {
        let with_errors = self.clone();
        self.arguments.iter_mut().for_each(|argument| argument.error = 0.0);
        with_errors
    }
}

/// The number of a state that is an argument: time, coordinates, rates, accelerations and multipliers in order.
pub(crate) fn argument(at: &State, number: usize) -> f64 {
    let n = at.q.len();
    match number {
        0 => at.t,
        i if i <= n => at.q[i - 1],
        i if i <= 2 * n => at.qd[i - 1 - n],
        i if i <= 3 * n => at.qdd[i - 1 - 2 * n],
        i => at.multipliers[i - 1 - 3 * n],
    }
}

/// The polynomial of a rate: the derivative of the coordinate's, or, in steps so short that differences of coordinates
/// are rounding errors, the polynomial of degree 3 through rates and accelerations at both ends.
fn rate(h: f64, [from, to]: [&State; 2], i: usize) -> [f64; TERMS] {
    let rounding = f64::EPSILON * from.q[i].abs().max(to.q[i].abs()) / h;
    if rounding <= MOST_ROUNDING * from.qd[i].abs().max(to.qd[i].abs()) {
        let [_, c1, c2, c3, c4, c5] = quintic_coefficients(h, [from, to], i);
        return [c1, 2.0 * c2, 3.0 * c3, 4.0 * c4, 5.0 * c5, 0.0].map(|c| c / h);
    }
    let (change, [a0, a1]) = (to.qd[i] - from.qd[i], [from, to].map(|at| h * at.qdd[i]));
    [from.qd[i], a0, 3.0 * change - 2.0 * a0 - a1, a0 + a1 - 2.0 * change, 0.0, 0.0]
}

/// The states at equal parts of a step, both ends among them, with their accelerations and multipliers.
fn states(mechanism: &dyn Mechanism, solver: &mut Solver, [from, to]: [&State; 2]) -> Option<[State; TERMS]> {
    let mut states = std::array::from_fn(|i| quintic(from, to, from.t + node(i) * (to.t - from.t)));
    states[0].clone_from(from);
    states[TERMS - 1].clone_from(to);
    for state in &mut states[1..TERMS - 1] {
        solver.complete(mechanism, state).ok()?;
    }
    Some(states)
}

fn node(i: usize) -> f64 {
    i as f64 / (TERMS - 1) as f64
}

/// The coefficients of the polynomial through values at equal parts, by divided differences.
fn through(mut values: [f64; TERMS]) -> [f64; TERMS] {
    for order in 1..TERMS {
        for i in (order..TERMS).rev() {
            values[i] = (values[i] - values[i - 1]) / node(order);
        }
    }
    let mut coefficients = [0.0; TERMS];
    for i in (0..TERMS).rev() {
        for k in (1..TERMS).rev() {
            coefficients[k] = coefficients[k - 1] - node(i) * coefficients[k];
        }
        coefficients[0] = values[i] - node(i) * coefficients[0];
    }
    coefficients
}

/// The coefficients in powers of the distance from another origin.
pub(super) fn moved_to(origin: f64, mut coefficients: [f64; TERMS]) -> [f64; TERMS] {
    for first in 0..TERMS - 1 {
        for k in (first..TERMS - 1).rev() {
            coefficients[k] += origin * coefficients[k + 1];
        }
    }
    coefficients
}

/// The interval of numbers within a radius, widened by rounding errors.
pub(crate) fn ball(centre: f64, radius: f64) -> Interval {
    let reach = radius + ROUNDING * (centre.abs() + radius);
    Interval::new(centre - reach, centre + reach)
}

/// The Taylor coefficients of an order of a polynomial with an error, for all origins within a radius.
pub(super) fn coefficient_within(polynomial: &[f64; TERMS], (radius, error): (f64, f64), order: usize) -> Interval {
    let Some((&centre, higher)) = polynomial[order.min(TERMS)..].split_first() else { return Interval::ZERO };
    let (mut reach, mut factor) = (if order == 0 { error } else { 0.0 }, 1.0);
    for (i, coefficient) in higher.iter().enumerate() {
        factor *= radius * (order + i + 1) as f64 / (i + 1) as f64;
        reach += factor * coefficient.abs();
    }
    // Coefficients of higher order that are zero stay exact.
    if centre == 0.0 && reach == 0.0 { Interval::ZERO } else { ball(centre, reach) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value([c0, c1, c2, c3, c4, c5]: [f64; TERMS], s: f64) -> f64 {
        c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    }

    #[test]
    fn a_polynomial_goes_through_its_values() {
        let values = [1.0, -2.0, 0.5, 3.0, 7.0, -1.0];
        let polynomial = through(values);
        for (i, expected) in values.into_iter().enumerate() {
            assert!((value(polynomial, node(i)) - expected).abs() < 1e-12, "{polynomial:?}");
        }
    }

    #[test]
    fn a_moved_polynomial_has_the_same_values() {
        let polynomial = [1.0, -2.0, 0.5, 3.0, 7.0, -1.0];
        let moved = moved_to(0.3, polynomial);
        assert!((value(moved, 0.4) - value(polynomial, 0.7)).abs() < 1e-14, "{moved:?}");
    }
}
