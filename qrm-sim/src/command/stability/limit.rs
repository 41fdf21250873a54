//! The step beyond which a run really blows up.

use std::io;

use serde::Serialize;

use super::super::progress::interrupted;
use super::super::setup::Setup;
use super::survey::Survey;
use crate::motion::{Method, Scheme};
use crate::observer::{Observer, Row};
use crate::outcome::Status;
use crate::simulate::{End, Request};

/// The longest steps of RK4.
#[derive(Serialize)]
pub(super) struct Limit {
    /// What the linearized equations allow; infinite if nothing decays or oscillates.
    #[serde(rename = "predicted_step")]
    pub(super) predicted: f64,
    /// The longest step of a run that did not blow up, and the shortest of one that did, both near each other.
    #[serde(rename = "steps_by_trial")]
    pub(super) found: Option<(f64, f64)>,
    /// How far the runs went.
    pub(super) until: f64,
}

/// Runs are no longer than this many steps.
const MOST_STEPS: f64 = 1e6;
/// From one trial to the next while looking for a step that blows up.
const STRIDE: f64 = 1.1;
/// Trials in either direction.
const TRIALS: i32 = 12;
/// Halvings of the stride.
const HALVINGS: usize = 6;
/// A rate that grows beyond its largest value by this factor is not that of the motion.
const BEYOND: f64 = 1.1;

impl Limit {
    /// Tries steps around the predicted limit.
    pub(super) fn find(setup: &Setup, survey: &Survey) -> Self {
        let predicted = survey.longest_step();
        let until = survey.outcome.end_time.min(0.5 * MOST_STEPS * predicted);
        let mut limit = Self { predicted, found: None, until };
        if !predicted.is_finite() || survey.problem.is_some() {
            return limit;
        }
        let holds = |h: f64| h < until && holds(setup, survey, h, until.min(MOST_STEPS * h));
        // Downward to one that holds, upward to the first that does not.
        let Some(start) = (1..TRIALS).map(|k| predicted * 0.5_f64.powi(k)).find(|h| holds(*h)) else { return limit };
        let Some(end) = (1..TRIALS).map(|k| start * STRIDE.powi(k)).find(|h| !holds(*h)) else { return limit };
        let (mut low, mut high) = (end / STRIDE, end);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if holds(middle) { low = middle } else { high = middle }
        }
        limit.found = Some((low, high));
        limit
    }
}

/// Whether a run with this step gets to the end, no rate far beyond those of the motion.
fn holds(setup: &Setup, survey: &Survey, step: f64, until: f64) -> bool {
    let method = Method { scheme: Scheme::Rk4, ..setup.method };
    let request = Request { method, step: Some(step), end: Some(End::Time(until)), estimate_error: false };
    let mut watch = Watch { bounds: survey.rates.iter().map(|rate| BEYOND * rate).collect(), is_beyond: false };
    let outcome = setup.scene.simulate(&setup.replace(), &request, &mut watch);
    !watch.is_beyond && outcome.is_ok_and(|outcome| matches!(outcome.status, Status::Completed))
}

/// An observer that ends a run whose rates leave their bounds.
struct Watch {
    bounds: Vec<f64>,
    is_beyond: bool,
}

impl Observer for Watch {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.is_beyond |= row.qd.iter().zip(&self.bounds).any(|(rate, bound)| rate.abs() > *bound);
        Ok(())
    }

    fn goes_on(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(!self.is_beyond && !interrupted())
    }

    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}
