//! The error estimates of a run from the differences of its companion.

use std::f64::consts::TAU;

use super::super::differences::Difference;
use super::super::error_estimate::{ErrorEstimates, rounding};
use super::{Companion, ESTIMATES_EXTREMES, HAS_SECOND, SECOND_COMPANION_STEPS};

/// The divisor of the difference that gives the error of the finer run. For errors of order p it is `(3/2)^p - 1`, 4.06
/// for order 4; in long steps the ratio is smaller.
const RICHARDSON_FACTOR: f64 = 2.0;
/// The divisor of the difference from the second companion. For errors of order 4 that is `(5/3)^4 - 1` of the error,
/// 6.72: the error by the first companion is then the larger one, and pages, which have no second one, show it too.
const RICHARDSON_FACTOR_OF_SECOND: f64 = 4.0;
/// The divisor for steps so long that errors follow no order. Ratios from 0.43 to 4.06 were measured, and estimates
/// should hold within a factor of 3 in both directions.
const RATIO_OF_LONG_STEPS: f64 = 1.37;
/// The smallest difference at an extreme, relative to the largest one: smaller ones agree by chance, unless they are
/// below `NO_CHANCE`, as those of a position where its rate is zero.
const SMALLEST_AT_EXTREME: f64 = 1.0 / 32.0;
const NO_CHANCE: f64 = 1e-5;
/// The factor of the largest difference in any row near singular positions, for quantities that depend on accelerations
/// or multipliers: there differences are irregular rounding errors, and those of other rows may be larger.
const IRREGULAR_FACTOR: f64 = 16.0;
/// The ratio of the largest rounding error of multipliers in rows, at the distance `4e-3` from a singular position, to
/// that at the position, which is interpolated from states at `1e-2`: it falls with the fourth power of the distance.
const ROUNDING_FACTOR: f64 = 40.0;
/// The smallest difference, relative to the largest coordinate or to a turn, that indicates long steps.
const LONG: f64 = 1e-5;

impl Companion {
    /// The errors after this number of steps, the larger of those by two companions; `None` if the companion failed or
    /// was never compared with the run.
    pub(crate) fn errors(&self, steps: u64) -> Option<ErrorEstimates> {
        let mut errors = self.own_errors(steps)?;
        if HAS_SECOND && let Some(second) = self.second.as_ref().and_then(|second| second.own_errors(steps)) {
            errors.increase_to(&second);
        }
        Some(errors)
    }

    fn own_errors(&self, steps: u64) -> Option<ErrorEstimates> {
        if self.failed || !self.differences.has_met {
            return None;
        }
        let differences = &self.differences;
        let floors = self.floors(steps);
        let ratio = self.ratio();
        let errors = |own: &dyn Fn(&Difference) -> f64| -> Vec<f64> {
            let differences = differences.each.iter().map(own).zip(&self.before).zip(&floors);
            differences.map(|((own, before), floor)| ((own + before) / ratio).max(*floor)).collect()
        };
        Some(ErrorEstimates {
            quantities: differences.quantities,
            start: self.start,
            largest: self.with_irregular(errors(&|difference| difference.largest)),
            at_extremes: if ESTIMATES_EXTREMES {
                [0, 1].map(|end| errors(&|difference| at_extreme(difference, end)))
            } else {
                [const { Vec::new() }; 2]
            },
            rivals: if ESTIMATES_EXTREMES {
                [0, 1].map(|end| {
                    let errors = errors(&|difference| difference.rivals[end].1);
                    differences.each.iter().map(|difference| difference.rivals[end].0).zip(errors).collect()
                })
            } else {
                [const { Vec::new() }; 2]
            },
            at_end: errors(&|difference| difference.latest),
            of_end_time: self.of_end_time.filter(|_| ESTIMATES_EXTREMES).map(|[difference, of_condition]| {
                (difference / ratio).max(rounding(self.at.t, steps)).max(of_condition)
            }),
            at_event: (self.at.t, self.at_event.clone()),
        })
    }

    /// The largest errors in any row, which are larger than differences where these are irregular.
    fn with_irregular(&self, mut errors: Vec<f64>) -> Vec<f64> {
        if self.integrator.solver().is_irregular() {
            let of_forces = errors.iter_mut().zip(&self.by_forces).zip(&self.differences.each);
            for ((error, _), difference) in of_forces.filter(|((_, by_forces), _)| **by_forces) {
                let size = difference.range[0].abs().max(difference.range[1].abs());
                *error = (IRREGULAR_FACTOR * *error).max(ROUNDING_FACTOR * self.rounding_at_poles * size);
            }
        }
        errors
    }

    /// The ratio of differences to errors.
    pub(super) fn ratio(&self) -> f64 {
        if !self.integrator.is_fixed() {
            return 1.0;
        }
        if HAS_SECOND && self.steps == SECOND_COMPANION_STEPS {
            return RICHARDSON_FACTOR_OF_SECOND;
        }
        let of_coordinates = &self.differences.each[..self.layout.n];
        let total = of_coordinates.iter().zip(&self.before).map(|(own, before)| own.largest + before);
        let size = size(of_coordinates);
        if total.fold(0.0, f64::max) > LONG * size.min(TAU) { RATIO_OF_LONG_STEPS } else { RICHARDSON_FACTOR }
    }

    /// The errors below which a difference carries no information: the rounding errors of both runs may agree.
    fn floors(&self, steps: u64) -> Vec<f64> {
        let groups = self.differences.quantities.groups().into_iter().map(|group| &self.differences.each[group]);
        groups
            .flat_map(|group| {
                let rounding = rounding(size(group), steps);
                group.iter().map(move |difference| rounding.max(difference.noise))
            })
            .collect()
    }
}

/// The difference that counts at the smallest or the largest value.
fn at_extreme(difference: &Difference, end: usize) -> f64 {
    let (_, own) = difference.at_extremes[end];
    if own > NO_CHANCE * difference.largest { own.max(SMALLEST_AT_EXTREME * difference.largest) } else { own }
}

/// The largest value of any of some quantities.
fn size(of: &[Difference]) -> f64 {
    of.iter().flat_map(|difference| difference.range).fold(0.0, |size, value| size.max(value.abs()))
}
