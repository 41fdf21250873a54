//! Values of a motion at any time.

use std::f64::consts::PI;

use crate::motion::{Motion, Shape};

use super::no_animation::NoAnimation;

/// A time of a motion: the preceding frame, and the fraction of the way to the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    frame: usize,
    fraction: f64,
}

impl Moment {
    /// The moment at `time`, or at the nearer end.
    pub(super) fn at(times: &[f64], time: f64) -> Self {
        let after = times.partition_point(|t| *t <= time).clamp(1, times.len() - 1);
        let (from, to) = (times[after - 1], times[after]);
        Self { frame: after - 1, fraction: ((time - from) / (to - from)).clamp(0.0, 1.0) }
    }

    /// The moment of a frame.
    pub(super) fn from_frame(frame: usize) -> Self {
        Self { frame, fraction: 0.0 }
    }
}

/// Interpolates a track.
pub(super) fn value(track: &[f64], moment: Moment) -> f64 {
    let (from, to) = ends(track, moment);
    from + moment.fraction * (to - from)
}

/// Interpolates a track of angles, along the shorter way between frames.
pub(super) fn angle(track: &[f64], moment: Moment) -> f64 {
    let (from, to) = ends(track, moment);
    from + moment.fraction * ((to - from + PI).rem_euclid(2.0 * PI) - PI)
}

fn ends(track: &[f64], moment: Moment) -> (f64, f64) {
    let at = |frame: usize| track[frame.min(track.len() - 1)];
    (at(moment.frame), at(moment.frame + 1))
}

/// Checks that everything drawn has one value per frame, and that all nodes exist.
pub(super) fn check(motion: &Motion) -> Result<(), NoAnimation> {
    let frames = motion.times.len();
    let rises = motion.times.windows(2).all(|pair| pair[0] < pair[1]);
    if frames < 2 || !rises {
        return Err(NoAnimation::NotRising);
    }
    let nodes = motion.nodes.iter().flat_map(|n| [("node", n.name.as_str(), &n.x), ("node", n.name.as_str(), &n.y)]);
    let arrows =
        motion.arrows.iter().flat_map(|a| [("arrow", a.name.as_str(), &a.x), ("arrow", a.name.as_str(), &a.y)]);
    let turns = motion.shapes.iter().filter_map(|shape| Some(("shape", shape.name(), shape.angle()?)));
    for (kind, name, track) in nodes.chain(arrows).chain(turns) {
        if track.len() != frames && track.len() != 1 {
            return Err(NoAnimation::Inconsistent(format!("{kind} `{name}`")));
        }
        if track.iter().any(|value| !value.is_finite()) {
            return Err(NoAnimation::NotFinite);
        }
    }
    if motion.shapes.iter().flat_map(Shape::sizes).any(|size| !size.is_finite()) {
        return Err(NoAnimation::NotFinite);
    }
    let of_shapes = motion.shapes.iter().flat_map(Shape::nodes).map(|node| ("a shape".to_owned(), *node));
    let of_arrows = motion.arrows.iter().map(|arrow| (format!("arrow `{}`", arrow.name), arrow.node));
    match of_shapes.chain(of_arrows).find(|(_, node)| *node >= motion.nodes.len()) {
        Some((what, _)) => Err(NoAnimation::Inconsistent(what)),
        None => Ok(()),
    }
}
