//! The cheapest method for an accuracy.

use super::study::{Cut, Measured, Sample, Study};
use crate::error::Message;
use crate::format::milliseconds;
use crate::methods::series_name;
use qrm_sim::integrate::RK4;
use qrm_sim::solve::Projection;

/// The goals: errors of the coordinates, or errors relative to the size of a column.
const GOALS: [f64; 5] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-11];

/// The largest credible ratio of an error to the method's own estimate.
const INCREDIBLE: f64 = 1e3;

/// The method to which others are compared.
fn yardstick() -> String {
    series_name(RK4, Projection::default())
}

impl Study {
    /// The goals, each with a sentence about it.
    pub(crate) fn recommendations(&self) -> Vec<(String, String)> {
        let size = self.reference.size();
        GOALS.map(|goal| (format!("{:.0e}", goal * size), self.cheapest(goal * size))).into()
    }

    /// Warnings about the measurements.
    pub(crate) fn warnings(&self, budget: &str) -> Vec<Message> {
        let cut = (self.cut == Some(Cut::Budget)).then(|| {
            Message::new("finer steps were not measured: there was no time left")
                .help(format!("give more with `--budget`, which was {budget}"))
        });
        cut.into_iter().chain(self.doubt()).collect()
    }

    /// A warning if fine steps agree with each other, but not with the reference: they may have missed a short event.
    fn doubt(&self) -> Option<Message> {
        let name = yardstick();
        let measured = |sample: &&Sample| sample.method == name && sample.result.is_ok();
        let finest = self.samples.iter().rfind(measured)?.result.as_ref().ok()?;
        let (error, estimate) = (finest.errors.judged(), finest.estimate?);
        let is_incredible = error > INCREDIBLE * estimate.max(self.reference.uncertainty.judged());
        is_incredible.then(|| {
            Message::new(format!(
                "the reference is in doubt: the shortest steps of {name} differ from it by {error:.1e}, but from \
                 longer ones by {estimate:.1e} only"
            ))
            .help(
                "a load may act for a very short time or distance, which long steps pass over, or the motion goes \
                 through a singular position",
            )
        })
    }

    fn cheapest(&self, goal: f64) -> String {
        let uncertainty = self.reference.uncertainty.judged();
        if goal < uncertainty {
            return format!("unknown: the reference is uncertain by {uncertainty:.1e}");
        }
        let needed = |method: &str| self.time_needed(method, goal);
        let time = |sample: &Sample| sample.result.as_ref().map_or(f64::INFINITY, |m| m.seconds[1]);
        let reaches = |sample: &&Sample| sample.result.as_ref().is_ok_and(|m| m.errors.judged() <= goal);
        let order = |a: &&Sample, b: &&Sample| {
            // Times of different methods are interpolated between measurements; for one method, its fastest measurement
            // counts.
            let of = |sample: &Sample| needed(&sample.method).unwrap_or(f64::INFINITY);
            of(a).total_cmp(&of(b)).then(time(a).total_cmp(&time(b)))
        };
        let Some(best) = self.samples.iter().filter(reaches).min_by(order) else {
            return match self.cut {
                Some(_) => "no method got there before the measurements ended".to_owned(),
                None => "no method gets there".to_owned(),
            };
        };
        let text = format!("{} at a {}: {}", best.method, best.setting.text(), milliseconds(time(best)));
        let other = yardstick();
        if best.method == other {
            return text;
        }
        let missed = if self.cut.is_some() { "was not measured so far" } else { "does not get there" };
        match (needed(&best.method), needed(&other)) {
            (Some(own), Some(others)) => format!(
                "{text}; between the measured points {} against {} for {other}: {:.2} of it",
                milliseconds(own),
                milliseconds(others),
                own / others
            ),
            _ => format!("{text}; {other} {missed}"),
        }
    }

    /// The time in which a method just reaches a goal, interpolated linearly between its points in the picture.
    fn time_needed(&self, method: &str, goal: f64) -> Option<f64> {
        let samples = self.samples.iter().filter(|sample| sample.method == method);
        let points: Vec<&Measured> = samples.filter_map(|sample| sample.result.as_ref().ok()).collect();
        let first = points.iter().position(|m| m.errors.judged() <= goal)?;
        let reached = points[first];
        let Some(before) = first.checked_sub(1).map(|i| points[i]) else { return Some(reached.seconds[1]) };
        let (e0, e1) = (before.errors.judged().ln(), reached.errors.judged().max(f64::MIN_POSITIVE).ln());
        let (t0, t1) = (before.seconds[1].ln(), reached.seconds[1].ln());
        Some((t0 + (t1 - t0) * (goal.ln() - e0) / (e1 - e0)).exp())
    }
}
