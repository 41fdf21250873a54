//! The largest value of an event inside a step.

use qrm_core::Mechanism;

use super::EventFunction;
use crate::maximum::{peak_between, vertex_beside};
use crate::state::State;

/// The number of parts of a step in which the event is looked at for its largest value.
const PARTS: usize = 4;
/// How far from an end of the step a larger value is looked for, if the largest one is there; relative to half a part.
const INSIDE: f64 = 1e-2;
/// The distance of the values for the second derivative, relative to the interval that is searched.
const APART: f64 = 1e-3;

/// The largest value of an event inside a step.
pub(crate) struct Largest {
    pub(crate) t: f64,
    pub(crate) value: f64,
    /// Half of the second derivative by time; zero if it is not known.
    pub(crate) half_curvature: f64,
}

impl EventFunction<'_> {
    /// The largest value of the event inside a step, not at its ends; `at` computes states of the motion inside.
    pub(crate) fn largest_inside(
        &self,
        mechanism: &dyn Mechanism,
        [from, to]: [&State; 2],
        at: &mut dyn FnMut(f64) -> Option<State>,
    ) -> Option<Largest> {
        let mut value = |t: f64| self.value(mechanism, &at(t)?).filter(|value| value.is_finite());
        let time = |i: usize| from.t + i as f64 / PARTS as f64 * (to.t - from.t);
        let ends = [from, to].map(|end| self.value(mechanism, end).filter(|value| value.is_finite()));
        let inner = (1..PARTS).map(|i| value(time(i)));
        let values: Vec<f64> = [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect::<Option<_>>()?;
        let place = (0..=PARTS).max_by(|a, b| values[*a].total_cmp(&values[*b]))?;
        let ends = [time(place.saturating_sub(1)), time((place + 1).min(PARTS))];
        let mut first = (time(place), values[place]);
        if place == 0 || place == PARTS {
            let inside = first.0 + INSIDE * (0.5 * (ends[0] + ends[1]) - first.0);
            first = (inside, value(inside)?);
            if first.1 <= values[place] {
                return None;
            }
        }
        let peak = peak_between(ends, first, &mut value)?;
        let (t, largest) = vertex_beside(peak, ends, &mut value);
        let apart = (APART * (ends[1] - ends[0])).min(t - from.t).min(to.t - t);
        let curvature = |(before, after): (f64, f64)| (0.5 * (before + after) - largest) / (apart * apart);
        let neighbours = value(t - apart).zip(value(t + apart));
        let half_curvature = neighbours.filter(|_| apart > 0.0).map_or(0.0, curvature);
        Some(Largest { t, value: largest, half_curvature })
    }
}
