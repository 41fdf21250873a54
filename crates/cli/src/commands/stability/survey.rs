//! The linearized equations along a motion.

use qrm_sim::analysis::{Spectrum, spectrum};
use qrm_sim::columns::Kind;
use qrm_sim::run::{End, Outcome, Status};

use crate::error::Error;
use crate::progress::Progress;
use crate::run_report::RunReport;
use crate::setup::Setup;
use qrm_pictures::Recording;

/// The linearized equations along a motion.
pub(super) struct Survey {
    /// States at equal intervals of time.
    pub(super) samples: Vec<Sample>,
    /// Largest absolute rates of the coordinates.
    pub(super) rates: Vec<f64>,
    pub(super) outcome: Outcome,
    /// An error if the motion could not be followed to its end.
    pub(super) problem: Option<Error>,
}

/// A state and the linearized equations there.
pub(super) struct Sample {
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) spectrum: Spectrum,
}

impl Survey {
    /// Follows the motion to its end, or to `end`.
    pub(super) fn until(setup: &Setup, end: Option<f64>) -> Result<Self, Error> {
        let mut observer = (Progress::new(), Recording::new(setup.description));
        let outcome = match end {
            Some(t) => setup.simulate_until(Some(End::Time(t)), true, &mut observer)?,
            None => setup.simulate(true, &mut observer)?,
        };
        let recording = observer.1;
        let states = recording.states();
        let mechanism = setup.mechanism();
        let sample = |(t, q, qd): (f64, Vec<f64>, Vec<f64>)| {
            spectrum(&*mechanism, t, &q, &qd).map(|spectrum| Sample { t, q, spectrum })
        };
        let samples: Vec<Sample> = states.into_iter().filter_map(sample).collect();
        if samples.is_empty() {
            return Err(Error::run("the equations of motion cannot be linearized anywhere"));
        }
        let largest = |i: usize| {
            let extremes = recording.extremes(Kind::Rate(i));
            extremes.map_or(0.0, |e| e.minimum.0.abs().max(e.maximum.0.abs()))
        };
        let rates = (0..setup.description.coordinates.len()).map(largest).collect();
        let report = RunReport::new(setup, &outcome, &recording);
        let problem = match outcome.status {
            // The motion is complete even if the stop condition is never satisfied.
            Status::StopNotReached { .. } => report.distrusted(),
            _ => report.problem(),
        };
        Ok(Self { samples, rates, outcome, problem })
    }

    /// The longest step of RK4 that is stable along the whole motion.
    pub(super) fn longest_step(&self) -> f64 {
        self.samples.iter().map(|sample| sample.spectrum.longest_step).fold(f64::INFINITY, f64::min)
    }

    /// The number of steps of RK4 required by stability alone.
    pub(super) fn steps_for_stability(&self) -> f64 {
        let wanted = |sample: &Sample| 1.0 / sample.spectrum.longest_step;
        let part = |pair: &[Sample]| 0.5 * (pair[1].t - pair[0].t) * (wanted(&pair[0]) + wanted(&pair[1]));
        self.samples.windows(2).map(part).fold(0.0, |sum, steps| sum + steps)
    }

    /// The sample in which a number is largest.
    pub(super) fn largest(&self, number: impl Fn(&Spectrum) -> f64) -> &Sample {
        let by = |sample: &&Sample| number(&sample.spectrum);
        self.samples.iter().max_by(|a, b| by(a).total_cmp(&by(b))).unwrap_or(&self.samples[0])
    }

    /// The samples in which the smallest singular value of C_q has a minimum below a fraction of its largest value,
    /// with the actual fraction.
    pub(super) fn singular(&self, part: f64) -> Vec<(&Sample, f64)> {
        let value = |i: usize| self.samples[i].spectrum.smallest_singular_value;
        let most = (0..self.samples.len()).map(value).fold(0.0, f64::max);
        let last = self.samples.len() - 1;
        let is_minimum = |i: &usize| (*i == 0 || value(*i) < value(i - 1)) && (*i == last || value(*i) <= value(i + 1));
        let near = (0..=last).filter(is_minimum).filter(|i| value(*i) < part * most);
        near.map(|i| (&self.samples[i], value(i) / most)).collect()
    }
}
