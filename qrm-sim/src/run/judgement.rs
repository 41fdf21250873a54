//! The judgement on the results of a motion, during or after a run.

use std::f64::consts::TAU;

use qrm_core::Description;

use super::error_estimate::{ErrorEstimates, rounding};
use super::outcome::Outcome;
use crate::solve::largest;

/// The largest difference between energy and work, relative to the largest kinetic energy.
const TOLERABLE_IMBALANCE: f64 = 1e-3;
/// The error of a coordinate that is accepted by default, relative to the range of its motion.
const TOLERABLE_ERROR: f64 = 1e-3;
/// The smallest range, relative to the coordinate or to one radian: a coordinate may hardly move.
const SMALLEST_RANGE: f64 = 1e-2;
/// The range, relative to the largest coordinate or to one radian, below which a coordinate is at rest.
const REST: f64 = 1e-12;
/// The largest ratio of the errors of a run to those of its steps.
const ACCUMULATION: f64 = 1e4;
const ACCUMULATION_PER_STEP: f64 = 10.0;
/// The multiple of the rounding errors that is always accepted.
const ROUNDING: f64 = 10.0;

/// A reason not to trust the results of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum RejectionReason {
    /// The change of the energy differs from the work of the loads without potential.
    Energy {
        /// The largest difference, in J.
        imbalance: f64,
        /// Whether there was no such work.
        is_conservative: bool,
    },
    /// The estimated error of a coordinate is too large.
    Error {
        /// The coordinate.
        coordinate: usize,
        /// The estimated error of the coordinate.
        error: f64,
        /// The largest error that is accepted.
        accepted: f64,
    },
    /// The companion run for the error estimate failed.
    CompanionFailed,
    /// Closing the loops after a step moved a coordinate too far.
    Correction {
        /// The coordinate.
        coordinate: usize,
        /// The size of the correction.
        correction: f64,
        /// The largest residual before it.
        residual: f64,
    },
    /// The stop condition may have become true before the end of the run.
    ConditionUndecided {
        /// The time, in s.
        t: f64,
        /// The distance from true at that time.
        missing: f64,
    },
    /// Multipliers grow without bound at a singular position.
    UnboundedForces {
        /// The time, in s.
        t: f64,
    },
}

/// The numbers on which a motion is judged.
pub(crate) struct Evidence<'a> {
    pub(crate) energy_imbalance: f64,
    /// Whether no load without potential did work.
    pub(crate) is_conservative: bool,
    pub(crate) largest_kinetic_energy: f64,
    pub(crate) largest_energy: f64,
    pub(crate) ranges: &'a [[f64; 2]],
    pub(crate) tolerance: Option<f64>,
    /// Steps so far.
    pub(crate) steps: u64,
    pub(crate) estimated_errors: Option<&'a [f64]>,
    pub(crate) companion_failed: bool,
    pub(crate) corrections: &'a [f64],
    /// The largest residual before a correction.
    pub(crate) residual: f64,
    /// The time at which multipliers grow without bound, if they do.
    pub(crate) unbounded_at: Option<f64>,
}

impl Evidence<'_> {
    /// The reasons not to trust the results.
    pub(crate) fn rejection_reasons(&self, description: &Description) -> Vec<RejectionReason> {
        let mut rejection_reasons = Vec::new();
        let imbalance = self.energy_imbalance;
        if !is_at_rest(description, self.ranges)
            && !is_balanced(imbalance, self.largest_kinetic_energy, self.largest_energy)
        {
            rejection_reasons.push(RejectionReason::Energy { imbalance, is_conservative: self.is_conservative });
        }
        let accepted = accepted_errors(description, self.ranges, self.tolerance, self.steps);
        match self.estimated_errors {
            Some(errors) => rejection_reasons.extend(worst(errors, &accepted).map(|coordinate| {
                RejectionReason::Error { coordinate, error: errors[coordinate], accepted: accepted[coordinate] }
            })),
            None if self.companion_failed => rejection_reasons.push(RejectionReason::CompanionFailed),
            None => {}
        }
        let tolerable = accepted_errors(description, self.ranges, None, self.steps);
        rejection_reasons.extend(worst(self.corrections, &tolerable).map(|coordinate| RejectionReason::Correction {
            coordinate,
            correction: self.corrections[coordinate],
            residual: self.residual,
        }));
        rejection_reasons.extend(self.unbounded_at.map(|t| RejectionReason::UnboundedForces { t }));
        rejection_reasons
    }
}

impl Outcome {
    /// The reasons not to trust the results.
    pub fn rejection_reasons(&self, description: &Description) -> Vec<RejectionReason> {
        let evidence = Evidence {
            energy_imbalance: self.energy_imbalance,
            is_conservative: self.energy_drift.is_some(),
            largest_kinetic_energy: self.largest_kinetic_energy,
            largest_energy: self.largest_energy,
            ranges: &self.ranges,
            tolerance: self.tolerance,
            steps: self.counts.accepted,
            estimated_errors: self.errors.as_ref().map(ErrorEstimates::coordinates),
            companion_failed: self.companion_failed,
            corrections: &self.corrections,
            residual: self.stats.residual_before_correction,
            unbounded_at: self.stats.unbounded_at,
        };
        let mut reasons = evidence.rejection_reasons(description);
        let undecided = self.condition_undecided;
        reasons.extend(undecided.map(|(t, missing)| RejectionReason::ConditionUndecided { t, missing }));
        reasons
    }
}

impl RejectionReason {
    /// Describes the reason in words, with the names of the mechanism.
    pub fn text(&self, tolerance: Option<f64>, description: &Description) -> String {
        let coordinate = |i: usize| (description.coordinates[i].name, description.coordinates[i].unit);
        match *self {
            Self::Energy { imbalance, is_conservative: true } => {
                format!("the energy changed by {imbalance:.1e} J although every load has a potential")
            }
            Self::Energy { imbalance, is_conservative: false } => {
                format!("the energy changed by {imbalance:.1e} J more than the loads without potential did work")
            }
            Self::Error { coordinate: i, error, accepted } => {
                let (name, unit) = coordinate(i);
                let what = if tolerance.is_some() { "the tolerance" } else { "a run without a tolerance" };
                format!(
                    "the estimated error of `{name}`, {error:.1e} {unit}, is beyond the {accepted:.0e} that {what} \
                     stands for"
                )
            }
            Self::CompanionFailed if tolerance.is_some() => {
                "the run that estimates the error, with shorter steps, broke off".to_owned()
            }
            Self::CompanionFailed => {
                "the run that estimates the error broke off, so the step is near the limit of what is stable".to_owned()
            }
            Self::Correction { coordinate: i, correction, residual } => {
                let (name, unit) = coordinate(i);
                format!(
                    "closing the loops after a step moved `{name}` by {correction:.1e} {unit}, from residuals up to \
                     {residual:.1e}"
                )
            }
            Self::ConditionUndecided { t, missing } => format!(
                "the condition that ends the run may have become true at t = {t:.6} s: it was {missing:.1e} short \
                 there, within the error of the motion"
            ),
            Self::UnboundedForces { t } => format!(
                "forces grow without bound at t = {t:.6} s, where the mechanism is singular: no finite force makes it \
                 pass this position so"
            ),
        }
    }
}

/// The coordinate with the largest ratio of error to accepted error, if it exceeds one.
pub(crate) fn worst(errors: &[f64], accepted: &[f64]) -> Option<usize> {
    let ratios: Vec<f64> = errors.iter().zip(accepted).map(|(error, accepted)| error / accepted).collect();
    // Written so that an error that is not a number counts as too large.
    let is_beyond = |i: &usize| !(errors[*i] <= accepted[*i]);
    (0..ratios.len()).filter(is_beyond).max_by(|a, b| ratios[*a].total_cmp(&ratios[*b]))
}

/// Whether no coordinate has moved by more than rounding errors: there is no kinetic energy to compare with.
fn is_at_rest(description: &Description, ranges: &[[f64; 2]]) -> bool {
    let has_angle = (0..ranges.len()).any(|i| description.is_angle(i));
    let least = if has_angle { 1.0 } else { 0.0 };
    let size = ranges.iter().flatten().fold(least, |size: f64, q| size.max(q.abs()));
    ranges.iter().all(|[low, high]| high - low <= REST * size)
}

/// Whether energy and work agree.
pub(crate) fn is_balanced(imbalance: f64, largest_kinetic_energy: f64, largest_energy: f64) -> bool {
    imbalance <= TOLERABLE_IMBALANCE * largest_kinetic_energy + 1e-12 * largest_energy
}

/// The accepted error of each coordinate after a number of steps: a fraction of the range of its motion, for an angle
/// of one turn at most. Rounding errors are accepted too, except those of angles so large that they lose their digits.
pub(crate) fn accepted_errors(
    description: &Description,
    ranges: &[[f64; 2]],
    tolerance: Option<f64>,
    steps: u64,
) -> Vec<f64> {
    let fraction = accepted_fraction(tolerance, steps);
    let sizes: Vec<f64> = ranges.iter().map(|[low, high]| low.abs().max(high.abs())).collect();
    let rounding = ROUNDING * rounding(largest(&sizes).1, steps);
    let accepted = |(i, [low, high]): (usize, &[f64; 2])| {
        if description.is_angle(i) {
            let scale = (high - low).clamp(SMALLEST_RANGE, TAU);
            fraction * scale + rounding.min(TOLERABLE_ERROR * scale)
        } else {
            fraction * (high - low).max(SMALLEST_RANGE * sizes[i]) + rounding
        }
    };
    ranges.iter().enumerate().map(accepted).collect()
}

/// The accepted error of a coordinate relative to its range.
pub fn accepted_fraction(tolerance: Option<f64>, steps: u64) -> f64 {
    let accumulation = ACCUMULATION.max(ACCUMULATION_PER_STEP * steps as f64);
    tolerance.map_or(TOLERABLE_ERROR, |tolerance| (accumulation * tolerance).min(TOLERABLE_ERROR))
}

#[cfg(test)]
mod tests {
    use qrm_core::QuantityDescription;

    use super::*;

    const DESCRIPTION: Description = {
        const fn coordinate(name: &'static str, unit: &'static str) -> QuantityDescription {
            QuantityDescription { name, unit, doc: "" }
        }
        Description {
            name: "two",
            doc: "",
            source: "",
            derivation: "",
            coordinates: &[coordinate("a", "rad"), coordinate("x", "m")],
            constraints: &[],
            outputs: &[],
            parameters: &[],
            left_out: &[],
            has_corners: false,
            friction: &[],
            until: "",
        }
    };

    /// An angle of some turns and a length of 10 um, both accurate.
    fn trusted() -> Evidence<'static> {
        Evidence {
            energy_imbalance: 0.9e-3,
            is_conservative: true,
            largest_kinetic_energy: 1.0,
            largest_energy: 2.0,
            ranges: &[[-50.0, 50.0], [2e-5, 3e-5]],
            tolerance: None,
            steps: 1000,
            estimated_errors: Some(const { &[0.9e-3 * TAU, 0.9e-8] }),
            companion_failed: false,
            corrections: &[0.9e-3 * TAU, 0.9e-8],
            residual: 1e-6,
            unbounded_at: None,
        }
    }

    fn rejection_reasons(evidence: &Evidence) -> Vec<RejectionReason> {
        evidence.rejection_reasons(&DESCRIPTION)
    }

    #[test]
    fn rest_is_measured_by_the_size_of_the_largest_coordinate() {
        assert!(is_at_rest(&DESCRIPTION, &[[1000.0, 1000.0 + 5e-10], [0.0, 5e-10]]));
        assert!(!is_at_rest(&DESCRIPTION, &[[1000.0, 1000.0 + 5e-9], [0.0, 0.0]]));
        assert!(is_at_rest(&DESCRIPTION, &[[0.0, 5e-13], [0.0, 0.0]]));
        assert!(!is_at_rest(&DESCRIPTION, &[[0.0, 0.0], [0.0, 5e-12]]));
    }

    #[test]
    fn each_limit_alone_is_a_reason() {
        assert_eq!(rejection_reasons(&trusted()), []);
        let energy = Evidence { energy_imbalance: 1.1e-3, ..trusted() };
        assert_eq!(rejection_reasons(&energy), [RejectionReason::Energy { imbalance: 1.1e-3, is_conservative: true }]);
        let angle = Evidence { estimated_errors: Some(&[1.1e-3 * TAU, 0.0]), ..trusted() };
        assert!(
            matches!(rejection_reasons(&angle)[..], [RejectionReason::Error { coordinate: 0, .. }]),
            "however many turns"
        );
        let length = Evidence { estimated_errors: Some(&[0.0, 1.1e-8]), ..trusted() };
        assert!(
            matches!(rejection_reasons(&length)[..], [RejectionReason::Error { coordinate: 1, .. }]),
            "however short"
        );
        let unknown = Evidence { estimated_errors: Some(&[0.0, f64::NAN]), ..trusted() };
        assert!(matches!(rejection_reasons(&unknown)[..], [RejectionReason::Error { coordinate: 1, .. }]));
        let failed = Evidence { estimated_errors: None, companion_failed: true, ..trusted() };
        assert_eq!(rejection_reasons(&failed), [RejectionReason::CompanionFailed]);
        assert_eq!(rejection_reasons(&Evidence { estimated_errors: None, ..trusted() }), []);
        let pole = Evidence { unbounded_at: Some(0.5), ..trusted() };
        assert_eq!(rejection_reasons(&pole), [RejectionReason::UnboundedForces { t: 0.5 }]);
        let moved = Evidence { corrections: &[0.0, 1.1e-8], ..trusted() };
        assert!(matches!(rejection_reasons(&moved)[..], [RejectionReason::Correction { coordinate: 1, .. }]));
    }

    #[test]
    fn an_angle_without_digits_is_a_reason() {
        let ranges = &[[1e16, 1e16], [2e-5, 3e-5]];
        let large = Evidence { ranges, estimated_errors: Some(&[14.0, 0.0]), corrections: &[], ..trusted() };
        assert!(matches!(rejection_reasons(&large)[..], [RejectionReason::Error { coordinate: 0, .. }]));
    }

    #[test]
    fn only_steps_of_a_length_of_their_own_can_be_too_long() {
        let text = |tolerance| RejectionReason::CompanionFailed.text(tolerance, &DESCRIPTION);
        assert!(text(None).contains("the limit of what is stable"), "{}", text(None));
        assert!(text(Some(1e-9)).contains("shorter steps"), "{}", text(Some(1e-9)));
    }

    #[test]
    fn a_tolerance_is_held_to_its_word() {
        let errors =
            |error: &'static [f64; 2]| Evidence { tolerance: Some(1e-9), estimated_errors: Some(error), ..trusted() };
        // 1e4 times the tolerance, of a range of 1e-5 m.
        assert_eq!(rejection_reasons(&errors(&[0.0, 0.9e-10])), []);
        assert!(matches!(
            rejection_reasons(&errors(&[0.0, 1.1e-10]))[..],
            [RejectionReason::Error { coordinate: 1, .. }]
        ));
        // Many steps accumulate more.
        assert_eq!(rejection_reasons(&Evidence { steps: 10_000, ..errors(&[0.0, 9e-10]) }), []);
        assert_eq!(rejection_reasons(&Evidence { steps: 10_000, ..errors(&[0.0, 1.1e-9]) }).len(), 1);
    }

    #[test]
    fn what_hardly_moves_is_not_measured_by_its_range() {
        let ranges = &[[1.0, 1.0], [0.5, 0.5 + 1e-9]];
        let still = Evidence { ranges, estimated_errors: Some(&[0.9e-5, 0.9e-5 * 0.5]), corrections: &[], ..trusted() };
        assert_eq!(rejection_reasons(&still), []);
        let off = Evidence { estimated_errors: Some(&[1.1e-5, 0.0]), ..still };
        assert!(matches!(rejection_reasons(&off)[..], [RejectionReason::Error { coordinate: 0, .. }]));
    }
}
