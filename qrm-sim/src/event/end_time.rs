//! The error of the time at which an event ends a motion.

use qrm_core::Mechanism;

use super::EventFunction;
use super::location::{slope, time_to_event};
use crate::state::State;

/// The time over which the slope of an event is computed, relative to the time of the event.
const SHIFT: f64 = 1e-7;
/// How far from its end a jump of the event is looked for in a motion, relative to the time.
const LONGEST: f64 = 1e-3;

impl EventFunction<'_> {
    /// The time between the events of two motions; `None` if it is not known.
    ///
    /// The first motion ended at its event, in the state `end`. The other one is in the state `other` at that time. Each
    /// state comes with the value of the event, which has a rounding error. For a difference `d` of the values, the time
    /// is the smaller of `d/|g'|` and `sqrt(2 d/|g''|)`.
    pub(crate) fn time_between(
        &self,
        mechanism: &dyn Mechanism,
        [(end, end_value), (other, other_value)]: [(&State, f64); 2],
        rounding: f64,
    ) -> Option<f64> {
        let value = &mut |at: &State| self.value_at_position(mechanism, at);
        let h = SHIFT * end.t.abs().max(f64::MIN_POSITIVE);
        let mut slopes = |h: f64| Some([slope(end, -h, value)?, slope(end, h, value)?]);
        let ([before, after], [nearer_before, nearer_after]) = (slopes(h)?, slopes(0.25 * h)?);
        // At a corner the difference of slopes does not depend on the distance.
        let bend = (after - before).abs();
        let is_corner = bend > 0.1 * before.abs().max(after.abs()) && (nearer_after - nearer_before).abs() > 0.5 * bend;
        let difference = (other_value - end_value).abs() + rounding;
        let by_slope = difference / (0.5 * (before + after)).abs();
        let curvature = (bend / h - 4.0 * rounding / (h * h)).max(0.0);
        let time = by_slope.min((2.0 * difference / curvature).sqrt());
        if time.is_finite() && after != 0.0 && !is_corner {
            return Some(time);
        }
        // The event jumps, or stays as it is.
        let longest = LONGEST * end.t.abs();
        let time = (time_to_event(other, longest, value)? - time_to_event(end, longest, value)?).abs();
        Some(if before == 0.0 { time } else { time + rounding / before.abs() })
    }

    /// The rounding error of the value at a state; zero where it may jump.
    pub(crate) fn rounding(&self, mechanism: &dyn Mechanism, at: &State) -> f64 {
        self.with_bounds(mechanism, |bounds| bounds.function.rounding_at(at)).unwrap_or(0.0)
    }
}
