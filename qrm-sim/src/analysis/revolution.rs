//! The quasi-static motion of a driven coordinate over a turn or a length: positions, forces of static equilibrium,
//! limit positions.

mod sample_series;
mod series;
mod turn_sweep;

use std::f64::consts::TAU;

use qrm_core::Mechanism;

use crate::position::LimitPosition;
use turn_sweep::{GAP, NEAR, Step, TurnSweep};

pub use series::{Series, Vertex};
pub use turn_sweep::NoRevolution;

/// The number of positions in a turn.
const SAMPLES: usize = 720;

/// A revolution of the driven coordinate, or its range of motion.
#[derive(Clone, Debug)]
pub struct Revolution {
    /// The driven coordinate.
    pub coordinate: usize,
    /// The start of the turn.
    pub start: f64,
    /// The direction in which the scene starts: 1 or -1.
    pub direction: f64,
    /// The range of the driven coordinate and the constraints that limit it; `None` if the coordinate turns fully.
    pub range: Option<Range>,
    /// The change points, where branches cross, in the order of the turn: the mechanism may leave one of them on
    /// another branch than the one followed here.
    pub change_points: Vec<f64>,
    /// Whether all coordinates return after a turn, angles up to whole turns.
    pub returns: bool,
    /// The course of each output at rest.
    pub outputs: Vec<Series>,
    /// The course of the generalized force on the driven coordinate that balances the loads, but those left out.
    pub balance: Series,
    /// The course of the effective inertia at the driven coordinate.
    pub inertia: Series,
}

/// The range of a driven coordinate, with the constraints that limit it.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The smallest value; `None` if the coordinate can make a whole turn, or move as far as a length is examined.
    pub low: Option<(f64, Option<usize>)>,
    /// The largest value; `None` likewise.
    pub high: Option<(f64, Option<usize>)>,
}

/// Moves the driven coordinate through a revolution, or along its range. `left_out` is the work of the loads that the
/// balance leaves out, at a position and for a displacement of the coordinates.
///
/// # Errors
/// No coordinate can be driven in this way.
pub fn revolution(
    mechanism: &dyn Mechanism,
    left_out: &dyn Fn(&[f64], &[f64]) -> f64,
) -> Result<Revolution, NoRevolution> {
    let sweep = TurnSweep::new(mechanism)?;
    let driven = sweep.driven;
    let description = mechanism.description();
    let mut positions = vec![sweep.start.clone()];
    let mut change_points = Vec::new();
    let mut visit = |step| match step {
        Step::To(position) => positions.push(*position),
        Step::ChangePoint(angle) => change_points.push(angle),
    };
    let followed = sweep.follow(sweep.direction, SAMPLES, &mut visit);
    let (range, is_locked, returns) = match followed {
        Ok(end) if description.is_angle(driven) => {
            let is_periodic = |i: usize| {
                let unit = description.coordinates[i].unit;
                let size = if description.is_angle(i) { 1.0 } else { end.q[i].abs().max(sweep.start.q[i].abs()) };
                wrap_angle(end.q[i] - sweep.start.q[i], unit).abs() <= 1e-9 * size
            };
            (None, [false; 2], (0..end.q.len()).all(is_periodic))
        }
        ahead => {
            let mut behind = Vec::new();
            let mut visit = |step| match step {
                Step::To(position) => behind.push(*position),
                Step::ChangePoint(angle) => change_points.push(angle),
            };
            let back = sweep.follow(-sweep.direction, SAMPLES, &mut visit).err();
            behind.extend(back.as_ref().map(|limit| limit.position.clone()));
            behind.reverse();
            let ahead = ahead.err();
            let is_at_start =
                |limit: &LimitPosition| sweep.is_near(limit.position.q[driven], sweep.start.q[driven], GAP);
            if [&ahead, &back].into_iter().all(|limit| limit.as_ref().is_some_and(is_at_start)) {
                return Err(NoRevolution::Singular);
            }
            positions.extend(ahead.as_ref().map(|limit| limit.position.clone()));
            positions.splice(0..0, behind);
            let end = |limit: &LimitPosition| (limit.position.q[driven], sweep.drive.open_beyond(limit));
            let (ahead, back) = (ahead.as_ref().map(end), back.as_ref().map(end));
            let is_locked = [back.is_some(), ahead.is_some()];
            let (low, high) = if sweep.direction > 0.0 { (back, ahead) } else { (ahead, back) };
            (Some(Range { low, high }), is_locked, false)
        }
    };
    let (count, rounding) = (description.outputs.len(), sweep.rounding_of_outputs());
    // The positions on both sides may find the same change point.
    change_points.dedup_by(|a, b| sweep.is_near(*a, *b, NEAR));
    Ok(Revolution {
        coordinate: driven,
        start: sweep.start.q[driven],
        direction: sweep.direction,
        outputs: (0..count)
            .map(|i| sweep.sample_series(&positions, returns, rounding[i], |at| sweep.outputs(&at.q)[i]))
            .collect(),
        balance: sweep.sample_between_locks(&positions, is_locked, returns, |at| {
            sweep.drive.balance(&at.q).1[driven] + left_out(&at.q, &sweep.drive.tangent(at, driven))
        }),
        inertia: sweep.sample_between_locks(&positions, is_locked, returns, |at| sweep.inertia(at)),
        range,
        change_points,
        returns,
    })
}

/// Whether the driven coordinate can make a full revolution.
pub fn can_revolve(mechanism: &dyn Mechanism) -> bool {
    TurnSweep::new(mechanism).is_ok_and(|sweep| sweep.follow(sweep.direction, SAMPLES / 8, &mut |_| ()).is_ok())
}

/// The difference of two values in a unit; whole turns are removed from angles.
pub fn wrap_angle(difference: f64, unit: &str) -> f64 {
    if unit == "rad" { difference - TAU * (difference / TAU).round() } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_are_no_difference() {
        for (difference, wrapped) in [(7.0, 7.0 - TAU), (-4.0, TAU - 4.0), (3.0, 3.0), (-3.0, -3.0)] {
            assert!((wrap_angle(difference, "rad") - wrapped).abs() < 1e-15);
            assert_eq!(wrap_angle(difference, "m"), difference);
        }
    }
}
