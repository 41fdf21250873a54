//! The step length above which a run actually becomes unstable.

use std::io;

use qrm_sim::integrate::{MethodSettings, RK4};
use qrm_sim::run::{End, Observer, Request, Row, Status, simulate};

use super::survey::Survey;
use crate::error::Error;
use crate::progress::{Progress, interrupted};
use crate::setup::Setup;

/// The longest steps of RK4.
pub(super) struct Limit {
    /// The longest step according to the linearized equations; infinite if nothing decays or oscillates.
    pub(super) predicted: f64,
    /// The longest stable step and the shortest unstable one that were found, close to each other.
    pub(super) found: Option<(f64, f64)>,
    /// The end time of the runs.
    pub(super) until: f64,
}

/// The largest number of steps of a run.
const MAX_STEPS: f64 = 1e6;
/// The ratio of consecutive trials in the search for an unstable step.
const FACTOR: f64 = 1.1;
/// The number of trials in each direction.
const TRIALS: i32 = 12;
/// The number of bisections of the interval.
const HALVINGS: usize = 6;
/// The ratio to the largest rate of the motion above which a run is unstable.
const BEYOND: f64 = 1.1;
/// The ratio to the largest rate below which a coordinate is at rest.
const RESTING: f64 = 1e-2;

/// The number of steps within which an instability becomes visible.
const STEPS: f64 = 100.0;
/// The largest multiple of its length to which the motion is extended for that.
const FARTHEST: f64 = 20.0;

impl Limit {
    /// Tests steps around the predicted limit, over the time of a hundred steps.
    ///
    /// # Errors
    /// The motion could not be followed at all.
    pub(super) fn find(setup: &Setup, survey: &Survey) -> Result<Self, Error> {
        let (end, wanted) = (survey.outcome.end_time, STEPS * survey.longest_step());
        let is_sound = survey.problem.is_none() && wanted.is_finite();
        let longer = (is_sound && wanted > end).then(|| Survey::until(setup, Some(wanted.min(FARTHEST * end))));
        let longer = longer.transpose()?.filter(|longer| longer.problem.is_none());
        Ok(Self::around(setup, longer.as_ref().unwrap_or(survey)))
    }

    fn around(setup: &Setup, survey: &Survey) -> Self {
        let predicted = survey.longest_step();
        let until = survey.outcome.end_time.min(0.5 * MAX_STEPS * predicted);
        let mut limit = Self { predicted, found: None, until };
        if !predicted.is_finite() || survey.problem.is_some() {
            return limit;
        }
        let spinner = Progress::spinner();
        let holds = |h: f64| {
            spinner.show(format!("steps of {h:.2e} s by trial"));
            h < until && holds(setup, survey, h, until.min(MAX_STEPS * h))
        };
        // Search downward for a stable step, then upward for the first unstable one.
        let Some(start) = (1..TRIALS).map(|k| predicted * 0.5_f64.powi(k)).find(|h| holds(*h)) else { return limit };
        let Some(end) = (1..TRIALS).map(|k| start * FACTOR.powi(k)).find(|h| !holds(*h)) else { return limit };
        let (mut low, mut high) = (end / FACTOR, end);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if holds(middle) { low = middle } else { high = middle }
        }
        limit.found = Some((low, high));
        limit
    }
}

/// Whether a run with this step reaches the end with rates in the range of the motion.
fn holds(setup: &Setup, survey: &Survey, step: f64, until: f64) -> bool {
    let settings = MethodSettings { method: RK4, ..setup.settings };
    let request = Request { settings, step: Some(step), end: Some(End::Time(until)), ..Request::default() };
    let largest = survey.rates.iter().copied().fold(0.0, f64::max);
    let bounds = survey.rates.iter().map(|rate| BEYOND * rate.max(RESTING * largest)).collect();
    let mut watch = Watch { bounds, is_beyond: false };
    let outcome = simulate(&*setup.mechanism(), &request, &mut watch);
    !watch.is_beyond && outcome.is_ok_and(|outcome| matches!(outcome.status, Status::Completed))
}

/// An observer that ends a run whose rates leave their range.
struct Watch {
    bounds: Vec<f64>,
    is_beyond: bool,
}

impl Observer for Watch {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.is_beyond |= row.qd.iter().zip(&self.bounds).any(|(rate, bound)| rate.abs() > *bound);
        Ok(())
    }

    fn keep_running(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(!self.is_beyond && !interrupted())
    }
}
