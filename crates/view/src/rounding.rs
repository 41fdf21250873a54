//! Rounds a motion to the digits that a screen can show.

use crate::motion::Motion;

/// The finest visible difference, relative to the visible range.
const FINEST: f64 = 1e-6;

/// The largest absolute value of a curve that consists of rounding errors.
const NOTHING: f64 = 1e-15;

/// Rounds each number of the motion to the visible precision of its range.
pub(crate) fn rounded(motion: &Motion) -> Motion {
    let mut motion = motion.clone();
    let of_axis = |values: &mut dyn Iterator<Item = f64>| span(values);
    let width = of_axis(&mut motion.nodes.iter().flat_map(|node| node.x.iter().copied()));
    let height = of_axis(&mut motion.nodes.iter().flat_map(|node| node.y.iter().copied()));
    let size = width.max(height);
    for node in &mut motion.nodes {
        round(&mut node.x, size);
        round(&mut node.y, size);
    }
    for shape in &mut motion.shapes {
        if let Some(angle) = shape.angle_mut() {
            round(angle, 1.0);
        }
    }
    let forces = motion.arrows.iter().flat_map(|arrow| arrow.x.iter().chain(&arrow.y));
    let strongest = forces.fold(0.0, |most: f64, force| most.max(force.abs()));
    for arrow in &mut motion.arrows {
        round(&mut arrow.x, strongest);
        round(&mut arrow.y, strongest);
    }
    for curve in motion.plots.iter_mut().flat_map(|plot| &mut plot.curves) {
        if curve.values.iter().all(|value| value.abs() < NOTHING) {
            curve.values.fill(0.0);
        }
        let range = span(&mut curve.values.iter().copied());
        round(&mut curve.values, range);
    }
    let duration = span(&mut motion.times.iter().copied());
    round(&mut motion.times, duration);
    motion
}

/// The difference between the largest and the smallest value.
fn span(values: &mut dyn Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    high - low
}

/// Rounds to enough decimals for a range; constants keep all their digits.
fn round(values: &mut [f64], range: f64) {
    let resolution = range * FINEST;
    if !(resolution > 1e-300 && resolution.is_finite()) {
        return;
    }
    let decimals = (-resolution.log10()).ceil().max(0.0) as usize;
    for value in values {
        // Adding zero turns -0 into 0.
        *value = format!("{value:.decimals$}").parse().unwrap_or(*value) + 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::round;

    #[test]
    fn small_motions_far_away_are_kept() {
        let mut values = [1000.24000123, 1000.24001123];
        round(&mut values, 0.01);
        assert_eq!(values, [1000.24000123, 1000.24001123]);
        round(&mut values, 10.0);
        assert_eq!(values, [1000.24, 1000.24001]);
    }
}
