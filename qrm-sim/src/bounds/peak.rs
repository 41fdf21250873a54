//! The search for the largest value of a function inside a step.
//!
//! Parts of the step whose bound exceeds no known value are excluded. Others are halved, until the function rises,
//! falls or has one peak. The function is then evaluated on the motion itself.

use qrm_core::{Interval, Mechanism};

use super::arguments::ArgumentPolynomials;
use super::function::{Bound, FunctionBounds};
use crate::solve::{NEAR, Solver};
use crate::state::State;

/// The shortest part of a step.
const SHORTEST: f64 = 1e-14;
/// The shortest part of a step, in parts of the time.
const RESOLUTION: f64 = 4.0 * f64::EPSILON;
/// The largest number of times that a step is halved for its motion to be a polynomial.
const MOST_HALVINGS: u32 = 5;
/// The part of a step in which a function without value is undefined: rounding errors take less.
const UNDEFINED: f64 = 1e-6;
/// The part of a step in which a pole is located, and the smallest distance from it at which values are compared.
const POLE: f64 = 1e-12;
const DISTANCE: f64 = 1e-9;
/// The ratio of distances from a pole, and the smallest ratio of the changes between them: values without bound change
/// more from one to the next, others less.
const NEARER: f64 = 16.0;
const GROWS: f64 = 0.8;
/// The relative change of a distance that hardly changes a value without bound.
const SHIFT: f64 = 1e-3;
/// The largest difference from zero that rounding errors of zero have.
const ZERO: f64 = 1e-200;
/// The smallest change of a value that is no rounding error, in parts of the value.
const ROUNDING: f64 = 1e-9;

/// The number of bounds that a state near a singular position counts for.
const BOUNDS_OF_STATE: u32 = 100;

/// The reason why the largest value is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PeakError {
    /// The function has no value at this time.
    Undefined(f64),
    /// The bounds do not tell.
    Undecided,
}

/// The search for values of a function above the largest known one; with the sign -1, for those below the smallest one.
pub(crate) struct PeakSearch<'s> {
    pub(crate) mechanism: &'s dyn Mechanism,
    pub(crate) bounds: &'s mut FunctionBounds,
    /// Completes states, if the function takes accelerations or multipliers.
    pub(crate) solver: Option<&'s mut Solver>,
    pub(crate) sign: f64,
    /// The states between which it searches.
    pub(crate) ends: [&'s State; 2],
    /// The best value and its time; infinite where the function has no bound.
    pub(crate) best: (f64, f64),
    /// Differences that do not count.
    pub(crate) tie: f64,
    /// How far the function may exceed its best value where bounds tell no more.
    pub(crate) open: f64,
    /// The number of bounds that may still be computed.
    pub(crate) left: &'s mut u32,
    /// The state at a time inside the step.
    pub(crate) at: &'s mut dyn FnMut(f64) -> Option<State>,
    /// The function at a state.
    pub(crate) value: &'s mut dyn FnMut(&State) -> f64,
}

impl PeakSearch<'_> {
    /// Searches between the states.
    ///
    /// # Errors
    /// The function is undefined there, or its bounds do not tell.
    pub(crate) fn search(&mut self) -> Result<(), PeakError> {
        self.search_parts(self.ends, MOST_HALVINGS)
    }

    /// Halves the step until the motion is a polynomial, and searches each part.
    fn search_parts(&mut self, [from, to]: [&State; 2], halvings: u32) -> Result<(), PeakError> {
        let h = to.t - from.t;
        if h <= RESOLUTION * to.t.abs() {
            return Ok(());
        }
        let (solver, arguments) = (self.solver.as_deref_mut(), &self.bounds.arguments);
        // Accelerations are not determined at a singular position.
        let Some(mut motion) = ArgumentPolynomials::between(self.mechanism, solver, [from, to], arguments) else {
            return Ok(());
        };
        let whole = self.bound(&motion, [0.0, 1.0]);
        if self.is_excluded(whole.value) {
            return Ok(());
        }
        if let Some(middle) = (self.at)(from.t + 0.5 * h) {
            self.note(&middle);
            if !motion.compare_with(&middle) && halvings > 0 {
                self.search_parts([from, &middle], halvings - 1)?;
                return self.search_parts([&middle, to], halvings - 1);
            }
        }
        motion.take_errors();
        self.search_polynomials(&motion, [from.t, h], whole)
    }

    fn search_polynomials(
        &mut self,
        motion: &ArgumentPolynomials,
        [begin, h]: [f64; 2],
        whole: Bound,
    ) -> Result<(), PeakError> {
        let shortest = SHORTEST.max(RESOLUTION * begin.abs().max((begin + h).abs()) / h);
        let time = |s: f64| begin + s * h;
        let mut parts = vec![([0.0, 1.0], whole)];
        while let Some(([low, high], bound)) = parts.pop() {
            let (middle, width) = (0.5 * (low + high), high - low);
            if self.is_excluded(bound.value) {
                continue;
            }
            let [slope, curvature] = [bound.slope, bound.curvature].map(|of| of * Interval::point(self.sign));
            if slope.lo() > 0.0 || slope.hi() < 0.0 {
                self.note_at(time(if slope.lo() > 0.0 { high } else { low }));
                continue;
            }
            if curvature.hi() < 0.0 {
                let (s, _) = self.bounds.turning_point(motion, [low, high], (self.sign, shortest));
                self.note_at(time(s));
                continue;
            }
            let is_finite = bound.value.is_finite();
            if !is_finite && width <= UNDEFINED {
                let values = [low, middle, high].map(|s| self.value_at(time(s)));
                if values.iter().all(|value| value.is_nan()) {
                    return Err(PeakError::Undefined(time(middle)));
                }
                let is_located = width <= POLE.max(shortest);
                if is_located && 2.0 * width > POLE.max(shortest) {
                    self.note_pole(time(middle), h * DISTANCE.max(NEARER * shortest));
                }
                if width <= shortest {
                    self.note_last([low, middle, high].map(time));
                    continue;
                }
            }
            // Halves would tell no more than numbers, where those have errors as large as the bound.
            let is_rounding = [low, middle, high].into_iter().all(|s| {
                let uncertainty = self.bounds.at(motion, s).width();
                uncertainty.is_finite() && bound.value.width() <= 2.0 * uncertainty
            });
            if is_finite && (is_rounding || width <= shortest) {
                self.note_last([low, middle, high].map(time));
                continue;
            }
            *self.left = self.left.saturating_sub(2);
            if *self.left == 0 {
                return Err(PeakError::Undecided);
            }
            // The half with the larger bound is searched first.
            let mut halves = [[low, middle], [middle, high]].map(|part| (part, self.bound(motion, part)));
            let top = |(_, bound): &([f64; 2], Bound)| (bound.value * Interval::point(self.sign)).hi();
            if top(&halves[0]) > top(&halves[1]) {
                halves.swap(0, 1);
            }
            parts.extend(halves);
        }
        Ok(())
    }

    fn bound(&mut self, motion: &ArgumentPolynomials, part: [f64; 2]) -> Bound {
        let (sign, most) = (self.sign, self.best.0 + self.tie.max(ZERO));
        self.bounds.within(motion, part, |natural| (natural * Interval::point(sign)).hi() <= most)
    }

    /// Whether no value within a bound is better than the best one.
    fn is_excluded(&self, bound: Interval) -> bool {
        (bound * Interval::point(self.sign)).hi() <= self.best.0 + self.tie.max(ZERO)
    }

    fn value_at(&mut self, t: f64) -> f64 {
        self.state_at(t).map_or(f64::NAN, |at| (self.value)(&at))
    }

    fn note_at(&mut self, t: f64) {
        if let Some(at) = self.state_at(t) {
            self.note(&at);
        }
    }

    /// Notes values in a part that is looked into no more.
    fn note_last(&mut self, times: [f64; 3]) {
        let mut values = times.map(|t| self.sign * self.value_at(t));
        for (value, t) in values.into_iter().zip(times) {
            if value > self.best.0 && value.is_finite() {
                self.best = (value, t);
            }
        }
        // As much as the function changes next to its best value, it may change inside.
        values.sort_by(|a, b| b.total_cmp(a));
        let [top, second, _] = values;
        if top == self.best.0 && second.is_finite() {
            self.open = self.open.max(top - second);
        }
    }

    /// The state at a time; one near a singular position takes as long as many bounds.
    fn state_at(&mut self, t: f64) -> Option<State> {
        let [from, to] = self.ends;
        let beyond = if t < from.t { Some(from) } else { (t > to.t).then_some(to) };
        if let Some(end) = beyond {
            let mut at = end.moved_along(t - end.t);
            if let Some(solver) = &mut self.solver {
                solver.complete(self.mechanism, &mut at).ok()?;
            }
            return Some(at);
        }
        let at = (self.at)(t)?;
        if let Some(solver) = &mut self.solver
            && solver.singularity_fraction(self.mechanism, NEAR, t, (&at.q, &at.qd)).is_some()
        {
            *self.left = self.left.saturating_sub(BOUNDS_OF_STATE).max(1);
        }
        Some(at)
    }

    fn note(&mut self, at: &State) {
        if at.t < self.ends[0].t || at.t > self.ends[1].t {
            return;
        }
        let value = self.sign * (self.value)(at);
        if value > self.best.0 && value.is_finite() {
            self.best = (value, at.t);
        }
    }

    /// Looks whether the function grows without bound towards a time, on either side.
    fn note_pole(&mut self, t: f64, distance: f64) {
        // Rounding errors of forces grow towards singular positions, as values at poles do.
        let windows = if self.bounds.takes_forces(self.ends[0].q.len()) { 1 } else { 4 };
        for side in [-1.0, 1.0] {
            let mut value = |distance: f64| self.sign * self.value_at(t + side * distance);
            let distances: [f64; 8] = std::array::from_fn(|k| distance * NEARER.powi(k as i32));
            let values = distances.map(&mut value);
            let grows = |values: &[f64]| {
                values.windows(3).all(|values| {
                    let (growth, before) = (values[0] - values[1], values[1] - values[2]);
                    growth > GROWS * before && before > ROUNDING * values[1].abs()
                })
            };
            // The pole of the motion is near that of its polynomials. Rounding errors differ at a neighbouring time as much
            // as between distances.
            let mut is_pole = |k: usize| {
                let (near, far) = (values[k], values[k + 1]);
                grows(&values[k..k + 5]) && (value(distances[k] * (1.0 + SHIFT)) - near).abs() < 0.1 * (near - far)
            };
            if (0..windows).any(&mut is_pole) {
                self.best = (f64::INFINITY, t);
            } else {
                self.note_at(t + side * distance);
            }
        }
    }
}
