//! Transmission angles of four-bar linkages in the scene's own motion.

use qrm_pictures::Recording;
use qrm_scene::document::FourBar;
use qrm_scene::evaluate::State;

use super::Topic;
use super::mobility::{side_vector, sides_from_input};
use super::motion::Input;
use crate::setup::Setup;

/// A line for each four-bar linkage with the smallest transmission angle of the motion, and the position.
pub(super) fn report_lines(setup: &Setup, input: &Input, recording: &Recording) -> Vec<Topic> {
    let values = setup.parameters();
    let states = recording.states();
    let line = |four_bar: &FourBar| {
        let output = sides_from_input(setup, four_bar)?[1];
        let row = |(t, q, qd): &(f64, Vec<f64>, Vec<f64>)| {
            let state = State::plain(&setup.scene, &values, *t, q, qd);
            Some((*t, sine(setup, &state, four_bar, output)?))
        };
        let sines: Vec<(f64, f64)> = states.iter().map(row).collect::<Option<_>>()?;
        let (sine, t) = smallest(&sines)?;
        let [coupler, output] = [2, output].map(|side| four_bar.links[side].as_str());
        let angle = format!("{:.2} deg", sine.clamp(0.0, 1.0).asin().to_degrees());
        Some(format!("transmission angle between `{coupler}` and `{output}`: at least {angle}, at {}", input.at(t)))
    };
    let lines: Vec<String> = setup.scene.four_bars.iter().filter_map(line).collect();
    if lines.is_empty() { Vec::new() } else { vec![Topic::new("four-bar", lines)] }
}

/// The sine of the angle from the coupler to the output of a linkage.
fn sine(setup: &Setup, state: &State<f64>, four_bar: &FourBar, output: usize) -> Option<f64> {
    let [[ax, ay], [bx, by]] = [side_vector(setup, state, four_bar, 2)?, side_vector(setup, state, four_bar, output)?];
    let lengths = ax.hypot(ay) * bx.hypot(by);
    (lengths > 0.0).then(|| (ax * by - ay * bx) / lengths)
}

/// The smallest size of a quantity that is known at some times, and its time: between rows it is a parabola.
fn smallest(rows: &[(f64, f64)]) -> Option<(f64, f64)> {
    let crossing = rows.windows(2).find(|pair| pair[0].1 * pair[1].1 <= 0.0);
    if let Some([(t0, a), (t1, b)]) = crossing {
        let part = if a == b { 0.0 } else { a / (a - b) };
        return Some((0.0, t0 + part * (t1 - t0)));
    }
    let place = (0..rows.len()).min_by(|i, j| rows[*i].1.abs().total_cmp(&rows[*j].1.abs()))?;
    let (t, value) = rows[place];
    let own = (value.abs(), t);
    let [Some((t0, a)), Some((t2, c))] = [place.checked_sub(1).and_then(|i| rows.get(i)), rows.get(place + 1)] else {
        return Some(own);
    };
    // Newton's divided differences.
    let [a, b, c] = [*a, value, *c].map(f64::abs);
    let [left, right] = [(b - a) / (t - t0), (c - b) / (t2 - t)];
    let curvature = (right - left) / (t2 - t0);
    if curvature.is_nan() || curvature <= 0.0 {
        return Some(own);
    }
    let slope = left + curvature * (t - t0);
    let shift = (-slope / (2.0 * curvature)).clamp(t0 - t, t2 - t);
    Some((b + slope * shift + curvature * shift * shift, t + shift))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_size_lies_between_rows() {
        let rows = |f: fn(f64) -> f64| [0.0, 0.1, 0.3, 0.6].map(|t| (t, f(t)));
        let (value, t) = smallest(&rows(|t| 0.5 + (t - 0.2) * (t - 0.2))).expect("rows");
        assert!((value - 0.5).abs() < 1e-12 && (t - 0.2).abs() < 1e-12, "{value} {t}");
        let (value, t) = smallest(&rows(|t| -0.5 - (t - 0.2) * (t - 0.2))).expect("rows");
        assert!((value - 0.5).abs() < 1e-12 && (t - 0.2).abs() < 1e-12, "{value} {t}");
        assert_eq!(smallest(&rows(|t| 2.0 * t - 0.4)).map(|(value, _)| value), Some(0.0));
        assert_eq!(smallest(&rows(|t| 1.0 + t)), Some((1.0, 0.0)));
        assert_eq!(smallest(&[]), None);
    }
}
