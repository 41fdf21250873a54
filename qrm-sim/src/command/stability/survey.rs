//! The linearized equations along a motion.

use super::super::progress::Progress;
use super::super::setup::Setup;
use super::super::{Failure, account};
use crate::album::{Album, state};
use crate::outcome::{Outcome, Status};
use crate::simulate::End;
use crate::spectrum::Spectrum;

/// What was seen of a motion.
pub(super) struct Survey {
    /// States at equal distances, with what the linearized equations are like there.
    pub(super) samples: Vec<Sample>,
    /// Largest rates of the coordinates, without sign.
    pub(super) rates: Vec<f64>,
    pub(super) outcome: Outcome,
    /// Why the motion could not be followed to its end.
    pub(super) problem: Option<String>,
}

/// A state.
pub(super) struct Sample {
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) spectrum: Spectrum,
}

impl Survey {
    /// Follows the motion to its end, or to another one.
    pub(super) fn until(setup: &Setup, end: Option<f64>) -> Result<Self, Failure> {
        let mut observer = (Progress::new(), Album::new(&setup.description));
        let outcome = match end {
            Some(t) => setup.simulate_until(Some(End::Time(t)), true, &mut observer)?,
            None => setup.simulate(true, &mut observer)?,
        };
        let (_, album) = observer;
        let n = setup.description.coordinates.len();
        let states: Vec<(f64, Vec<f64>, Vec<f64>)> = album.frames.iter().map(|frame| state(frame, n)).collect();
        let spectra = setup.scene.spectra(&setup.replace(), &states);
        let samples: Vec<Sample> = states
            .into_iter()
            .zip(spectra)
            .filter_map(|((t, q, _), spectrum)| Some(Sample { t, q, spectrum: spectrum? }))
            .collect();
        if samples.is_empty() {
            return Err(Failure::Run("error: the equations of motion cannot be linearized anywhere".to_owned()));
        }
        let largest = |c: &qrm_core::QuantityDescription| {
            let extremes = album.extremes(&format!("{}_dot", c.name));
            extremes.map_or(0.0, |e| e.minimum.0.abs().max(e.maximum.0.abs()))
        };
        let rates = setup.description.coordinates.iter().map(largest).collect();
        let summary = account::summary(setup, &outcome, &album);
        let problem = match outcome.status {
            // Where the stop condition is never met, the motion was followed all the same.
            Status::StopNotReached { .. } => account::distrusted(&summary),
            _ => account::problem(&outcome, &summary),
        };
        Ok(Self { samples, rates, outcome, problem })
    }

    /// The longest step that RK4 can take everywhere.
    pub(super) fn longest_step(&self) -> f64 {
        self.samples.iter().map(|sample| sample.spectrum.longest_step).fold(f64::INFINITY, f64::min)
    }

    /// How many steps of RK4 stability alone asks for.
    pub(super) fn steps_for_stability(&self) -> f64 {
        let wanted = |sample: &Sample| 1.0 / sample.spectrum.longest_step;
        let part = |pair: &[Sample]| 0.5 * (pair[1].t - pair[0].t) * (wanted(&pair[0]) + wanted(&pair[1]));
        self.samples.windows(2).map(part).fold(0.0, |sum, steps| sum + steps)
    }

    /// Where a number is largest.
    pub(super) fn largest(&self, number: impl Fn(&Spectrum) -> f64) -> &Sample {
        let by = |sample: &&Sample| number(&sample.spectrum);
        self.samples.iter().max_by(|a, b| by(a).total_cmp(&by(b))).unwrap_or(&self.samples[0])
    }

    /// Where the smallest singular value of C_q has a minimum below a part of its largest value, each with that part.
    pub(super) fn singular(&self, part: f64) -> Vec<(&Sample, f64)> {
        let value = |i: usize| self.samples[i].spectrum.smallest_singular_value;
        let most = (0..self.samples.len()).map(value).fold(0.0, f64::max);
        let last = self.samples.len() - 1;
        let is_minimum = |i: &usize| (*i == 0 || value(*i) < value(i - 1)) && (*i == last || value(*i) <= value(i + 1));
        let near = (0..=last).filter(is_minimum).filter(|i| value(*i) < part * most);
        near.map(|i| (&self.samples[i], value(i) / most)).collect()
    }
}
