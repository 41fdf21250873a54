//! The outlines of gears, racks and belts.

use std::f64::consts::TAU;

use crate::motion::{RIM, TIP};

/// The depth of teeth below the pitch circle, in modules.
const ROOT: f64 = 1.0;
/// Half the width of a tooth at its root and at its tip, in pitches.
const FLANKS: [f64; 2] = [0.32, 0.13];

/// The outline of a gear in its own frame.
pub(super) fn gear(radius: f64, teeth: u32, phase: f64, is_internal: bool) -> Vec<[f64; 2]> {
    let module = 2.0 * radius / f64::from(teeth.max(1));
    let sign = if is_internal { -1.0 } else { 1.0 };
    let (root, tip) = (radius - sign * ROOT * module, radius + sign * TIP * module);
    let pitch = TAU / f64::from(teeth.max(1));
    let tooth = |number: u32| {
        let middle = phase + pitch * f64::from(number);
        corners(root, tip).map(|(radius, aside)| polar(radius, middle + aside * pitch))
    };
    (0..teeth).flat_map(tooth).collect()
}

/// The rim of a ring gear in its own frame.
pub(super) fn rim(radius: f64, teeth: u32) -> Vec<[f64; 2]> {
    let outside = radius + RIM * 2.0 * radius / f64::from(teeth.max(1));
    (0..90).map(|part| polar(outside, TAU * f64::from(part) / 90.0)).collect()
}

/// The outline of a rack in its own frame, between two ends, with its back.
pub(super) fn rack([from, to]: [f64; 2], across: f64, pitch: f64, phase: f64) -> Vec<[f64; 2]> {
    let (size, sign) = (pitch.abs(), pitch.signum());
    let module = size / (0.5 * TAU);
    let [root, tip, back] = [-ROOT, TIP, -RIM].map(|modules| across + sign * modules * module);
    let (first, last) = (((from - phase) / size).ceil(), ((to - phase) / size).floor());
    // The number of very fine teeth is limited.
    let count = (last - first + 1.0).clamp(0.0, 1000.0) as u32;
    let tooth = |number: u32| {
        let middle = phase + size * (first + f64::from(number));
        corners(root, tip).map(|(height, aside)| [(middle + aside * size).max(from).min(to), height])
    };
    let ends = [[to, root], [to, back], [from, back], [from, root]];
    (0..count).flat_map(tooth).chain(ends).collect()
}

/// The path of a belt around two pulleys; empty if one of them lies within the other.
pub(super) fn belt(first: [f64; 2], second: [f64; 2], [r, s]: [f64; 2], is_crossed: bool) -> Vec<[f64; 2]> {
    let (dx, dy) = (second[0] - first[0], second[1] - first[1]);
    let line = dy.atan2(dx);
    let opening = ((if is_crossed { r + s } else { r - s }) / dx.hypot(dy)).acos();
    if !opening.is_finite() {
        return Vec::new();
    }
    let arc = |centre: [f64; 2], radius: f64, from: f64, turn: f64| {
        (0..=32).map(move |part| {
            let [x, y] = polar(radius, from + turn * f64::from(part) / 32.0);
            [centre[0] + x, centre[1] + y]
        })
    };
    let around = TAU - 2.0 * opening;
    let far = if is_crossed {
        arc(second, s, line + 0.5 * TAU - opening, -around)
    } else {
        arc(second, s, line - opening, 2.0 * opening)
    };
    arc(first, r, line + opening, around).chain(far).collect()
}

/// The corners of a tooth: their heights, and their offsets from its middle in pitches.
fn corners(root: f64, tip: f64) -> [(f64, f64); 4] {
    [(root, -FLANKS[0]), (tip, -FLANKS[1]), (tip, FLANKS[1]), (root, FLANKS[0])]
}

fn polar(radius: f64, angle: f64) -> [f64; 2] {
    [radius * angle.cos(), radius * angle.sin()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn teeth_of_a_pair_leave_each_other_room() {
        let wheel = gear(0.2, 20, 0.0, false);
        let ring = gear(0.4, 40, 0.0, true);
        assert_eq!((wheel.len(), ring.len()), (80, 160));
        let radii = |outline: &[[f64; 2]]| {
            let radii = outline.iter().map(|[x, y]| x.hypot(*y));
            radii.fold((f64::INFINITY, 0.0_f64), |(low, high), r| (low.min(r), high.max(r)))
        };
        let (inside, outside) = (radii(&wheel), radii(&ring));
        assert!((inside.1 - 0.216).abs() < 1e-12 && (inside.0 - 0.18).abs() < 1e-12, "{inside:?}");
        assert!((outside.0 - 0.384).abs() < 1e-12 && (outside.1 - 0.42).abs() < 1e-12, "{outside:?}");
    }

    #[test]
    fn belts_touch_their_pulleys() {
        for is_crossed in [false, true] {
            let path = belt([0.0, 0.0], [3.0, 4.0], [1.0, 2.0], is_crossed);
            let on =
                |[x, y]: &[f64; 2]| (x.hypot(*y) - 1.0).abs() < 1e-12 || ((x - 3.0).hypot(y - 4.0) - 2.0).abs() < 1e-12;
            assert!(path.len() == 66 && path.iter().all(on), "{path:?}");
            // The straight parts are tangents of both pulleys.
            let [[ax, ay], [bx, by]] = [path[32], path[33]];
            assert!((ax * (bx - ax) + ay * (by - ay)).abs() < 1e-12, "{is_crossed}");
            assert!(((bx - 3.0) * (bx - ax) + (by - 4.0) * (by - ay)).abs() < 1e-12, "{is_crossed}");
        }
        assert!(belt([0.0, 0.0], [0.1, 0.0], [1.0, 2.0], false).is_empty());
    }
}
