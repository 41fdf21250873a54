//! A periodic motion by two lengths of steps.

use nalgebra::DVector;

use super::error::NoSteadyMotion;
use super::multipliers::{Multiplier, multipliers};
use super::newton::{Equations, Found, Plane};
use super::return_map::{Orbit, ReturnMap, largest_of};

/// A solution by the steps of the method, and one by steps half as long.
pub(super) struct Solution {
    pub(super) found: Found,
    pub(super) accurate: Found,
    pub(super) multipliers: Vec<Multiplier>,
}

/// The rounding error of period and start.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// The error of the time of a corner or jump of loads, in parts of the period.
const CROSSED: f64 = 1e-12;

impl Solution {
    /// Solves the equations from a guess, on a plane if there is one.
    ///
    /// # Errors
    /// Newton's method does not converge, or a motion cannot be followed.
    pub(super) fn new(map: &ReturnMap, guess: Orbit, plane: Option<&Plane>) -> Result<Self, NoSteadyMotion> {
        let found = Equations { map, is_halved: false, plane }.solve(guess)?;
        Self::refine(map, found, plane)
    }

    /// Adds the solution by steps half as long to one that was found.
    ///
    /// # Errors
    /// Newton's method does not converge, or a motion cannot be followed.
    pub(super) fn refine(map: &ReturnMap, found: Found, plane: Option<&Plane>) -> Result<Self, NoSteadyMotion> {
        let accurate = Equations { map, is_halved: true, plane }.solve(found.orbit.clone())?;
        let multipliers = multipliers(map, &found, &accurate)?;
        Ok(Self { found, accurate, multipliers })
    }

    pub(super) fn iterations(&self) -> u32 {
        self.found.iterations + self.accurate.iterations
    }

    /// The largest error of a multiplier, relative to sizes of at least one.
    pub(super) fn multiplier_error(&self) -> f64 {
        self.multipliers.iter().map(|m| m.error / m.value.norm().max(1.0)).fold(0.0, f64::max)
    }

    /// The estimated errors of the unknowns.
    pub(super) fn errors(&self, map: &ReturnMap) -> DVector<f64> {
        let Self { found, accurate, .. } = self;
        // The time of a corner or a jump is not known better.
        let mechanism = map.mechanism(&found.orbit);
        let late = if mechanism.description().has_corners { CROSSED * found.orbit.period } else { 0.0 };
        let rates = [&found.at.end.qd, &found.at.end.qdd].map(|rates| largest_of(rates));
        let [own, other] = [found, accurate].map(|found| map.unknowns(&found.orbit));
        let last_step = |column: usize| {
            let steps = [found, accurate].map(|found| found.last_step.get(column).map_or(0.0, |step| step.abs()));
            steps[0].max(steps[1])
        };
        let sizes = map.unknown_sizes();
        DVector::from_fn(sizes.len(), |column, _| {
            let rate = match map.places().get(column) {
                None => 0.0,
                Some(_) if map.phase() == Some(column) => 1.0,
                Some(place) => rates[usize::from(place.is_rate)],
            };
            let error = (own[column] - other[column]).abs().max(last_step(column)).max(ROUNDING * own[column].abs());
            (error * sizes[column]).max(late * rate)
        })
    }

    /// The estimated errors of the period, and of the given coordinates and rates at the start. Others have none.
    pub(super) fn start_errors(&self, map: &ReturnMap) -> (f64, [Vec<f64>; 2]) {
        let count = self.found.orbit.start.q.len();
        let mut errors = [vec![0.0; count], vec![0.0; count]];
        let mut of_period = 0.0;
        let unknowns = self.errors(map);
        for (column, place) in map.places().iter().enumerate() {
            if map.phase() == Some(column) {
                of_period = unknowns[column];
            } else {
                errors[usize::from(place.is_rate)][place.coordinate] = unknowns[column];
            }
        }
        (of_period, errors)
    }
}
