//! Compares steps with the time scales of loads and drives, whose changes a step must not skip.

use std::f64::consts::FRAC_PI_2;

use qrm_scene::time_scales::TimeScale;
use qrm_sim::integrate::StepBounds;

use crate::format::seconds;

/// The duration of a short pulse on each side of its centre, in multiples of its width.
const REACH: f64 = 6.0;

/// The bounds of the steps that a method chooses, so that it sees every time-dependent change that a formula shows.
pub(crate) fn step_bounds(scales: &[TimeScale], max_step: Option<f64>) -> StepBounds {
    let longest = |scale: &TimeScale| match scale {
        TimeScale::Period(rate) => Some(FRAC_PI_2 / rate),
        TimeScale::Moment { .. } => None,
    };
    let longest = scales.iter().filter_map(longest).chain(max_step).fold(f64::INFINITY, f64::min);
    let times = scales.iter().flat_map(|scale| match *scale {
        TimeScale::Period(_) => Vec::new(),
        TimeScale::Moment { time, width } => vec![time - width, time, time + width],
    });
    StepBounds::new(longest, &times.collect::<Vec<_>>())
}

/// The reason why fixed steps skip a time-dependent change in a run to an end time.
pub(crate) fn passed_over(scales: &[TimeScale], step: f64, end_time: f64) -> Option<String> {
    scales.iter().find_map(|scale| match *scale {
        TimeScale::Period(rate) if rate * step > FRAC_PI_2 => Some(format!(
            "a load or drive turns by {:.2} rad in a step, and steps longer than {:.1e} s do not see how",
            rate * step,
            FRAC_PI_2 / rate
        )),
        TimeScale::Moment { time, width }
            if width < step && time + REACH * width >= 0.0 && time - REACH * width <= end_time =>
        {
            Some(format!(
                "a load or drive changes within {width:.1e} s around t = {}, and steps of {} pass over it",
                seconds(time),
                seconds(step)
            ))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shorter_than_a_step_is_named() {
        let blow = [TimeScale::Moment { time: 0.3, width: 1e-4 }];
        assert!(passed_over(&blow, 1e-3, 1.0).is_some() && passed_over(&blow, 1e-5, 1.0).is_none());
        assert!(passed_over(&blow, 1e-3, 0.29).is_none());
        let turn = [TimeScale::Period(100.0)];
        assert!(passed_over(&turn, 0.02, 1.0).is_some() && passed_over(&turn, 0.015, 1.0).is_none());
    }
}
