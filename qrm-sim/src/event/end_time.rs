//! The error of the time at which an event ends a motion.

use qrm_core::Mechanism;

use super::location::{slope, time_to_event};
use super::{EventFunction, POSSIBLE};
use crate::state::State;

/// The time over which the slope of an event is computed, relative to the time of the event.
const SHIFT: f64 = 1e-7;
/// Parts of the way from one motion to the other at which the event is compared.
const PARTS: [f64; 3] = [1.0 / 16.0, 1.0 / 256.0, 1.0 / 4096.0];
/// The smallest change of the event on the way, in rounding errors.
const MANY: f64 = 64.0;
/// How far from its end a jump of the event is looked for in a motion, relative to the time.
const LONGEST: f64 = 1e-3;

impl EventFunction<'_> {
    /// The time between the events of two motions; `None` if it is not known.
    ///
    /// The first motion ended at its event, in the state `end`. The other one is in the state `other` at that time. Each
    /// state comes with the value of the event, which has a rounding error. The time is that over which
    /// `g' t + g'' t^2/2` changes by the difference of the values. Coordinates and rates of the motions differ by `floors` at least.
    pub(crate) fn time_between(
        &self,
        mechanism: &dyn Mechanism,
        [(end, end_value), (other, other_value)]: [(&State, f64); 2],
        rounding: f64,
        floors: &[f64],
    ) -> Option<f64> {
        let value_of = |at: &State| self.value_at_position(mechanism, at);
        let value = &mut |at: &State| value_of(at);
        let h = SHIFT * end.t.abs().max(f64::MIN_POSITIVE);
        let mut slopes = |h: f64| Some([slope(end, -h, value)?, slope(end, h, value)?]);
        let ([before, after], [nearer_before, nearer_after]) = (slopes(h)?, slopes(0.25 * h)?);
        // At a corner the difference of slopes does not depend on the distance.
        let bend = (after - before).abs();
        let is_corner = bend > 0.1 * before.abs().max(after.abs()) && (nearer_after - nearer_before).abs() > 0.5 * bend;
        // The differences of single numbers may cancel by chance.
        let n = end.q.len();
        let single = |i: usize| {
            let mut mixed = end.clone();
            let floor = floors.get(i).copied().unwrap_or(0.0);
            let (own, other) =
                if i < n { (&mut mixed.q[i], other.q[i]) } else { (&mut mixed.qd[i - n], other.qd[i - n]) };
            *own += (other - *own).abs().max(floor);
            Some((value_of(&mixed)? - end_value).abs())
        };
        let apart: f64 = (0..2 * n).filter_map(single).sum();
        // Next to a pole the difference says less than that of a part of the way.
        let smallest = MANY * self.rounding(mechanism, end);
        let of_part = |part: f64| {
            let mut mixed = end.clone();
            let numbers = mixed.q.iter_mut().chain(&mut mixed.qd).zip(other.q.iter().chain(&other.qd));
            numbers.for_each(|(own, other)| *own += part * (other - *own));
            let change = (value_of(&mixed)? - end_value).abs();
            (change > smallest).then_some(change / part)
        };
        let of_parts = PARTS.into_iter().filter_map(of_part).fold(0.0, f64::max);
        let difference = (other_value - end_value).abs().max(0.5 * apart).max(of_parts) + rounding;
        let curvature = (bend / h - 4.0 * rounding / (h * h)).max(0.0);
        let time_of = |difference: f64| time_of_change((0.5 * (before + after)).abs(), curvature, difference);
        // Where the slope changes as much as it is, time is no multiple of the difference.
        let time = time_of(difference).max(time_of(POSSIBLE * difference) / POSSIBLE);
        let longest = LONGEST * end.t.abs();
        let to_event = time_to_event(other, longest, value).zip(time_to_event(end, longest, value));
        let between = to_event.map(|(of_other, of_end)| (of_other - of_end).abs());
        if time.is_finite() && after != 0.0 && !is_corner {
            // Far from linear, as next to a pole, the slope tells little.
            return Some(between.map_or(time, |between| time.max(between)));
        }
        // The event jumps, or stays as it is.
        let time = between?;
        Some(if before == 0.0 { time } else { time + rounding / before.abs() })
    }

    /// The rounding error of the value at a state; zero where it may jump.
    pub(crate) fn rounding(&self, mechanism: &dyn Mechanism, at: &State) -> f64 {
        self.with_bounds(mechanism, |bounds| bounds.function.rounding_at(at)).unwrap_or(0.0)
    }
}

/// The longest time over which a value changes by an amount, with a slope and a curvature that are not negative and of
/// unknown signs.
fn time_of_change(slope: f64, curvature: f64, amount: f64) -> f64 {
    let square = slope * slope - 2.0 * curvature * amount;
    if square >= 0.0 {
        2.0 * amount / (slope + square.sqrt())
    } else {
        (slope + (slope * slope + 2.0 * curvature * amount).sqrt()) / curvature
    }
}
