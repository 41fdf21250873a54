//! The positions in which a mechanism can be assembled.

use std::f64::consts::{PI, TAU};

use qrm_core::{Description, Mechanism};

use crate::position::{Start, assemble_from_guesses};

/// The number of guesses without a new position after which the search ends.
const PATIENCE: u32 = 400;
/// The largest number of branches that are searched for: their number may double with each loop.
pub const MAX_BRANCHES: usize = 64;
/// The largest number of guesses.
const MAX_GUESSES: u32 = 20_000;
/// Lengths are guessed up to this multiple of the largest length in the first position.
const REACH: f64 = 2.0;
/// Positions closer than this, in rad or relative to the largest length, are equal.
const SAME: f64 = 1e-6;

/// Finds the positions in which a mechanism can be assembled with the given coordinates of a start. The first is the
/// position to which the start's guesses lead, if any; the others are sorted by their coordinates.
///
/// Guesses are distributed evenly over all angles and over lengths of the size of the first position (an additive
/// recurrence with the generalized golden ratio), so that the result is reproducible. A position that very few guesses
/// lead to may be missed. Angles are those nearest to the first position. The search ends when `keep_running` returns
/// false, or with [`MAX_BRANCHES`] positions.
pub fn branches(mechanism: &dyn Mechanism, start: &Start, mut keep_running: impl FnMut() -> bool) -> Vec<Vec<f64>> {
    let description = mechanism.description();
    let own = assemble_from_guesses(mechanism, start).ok().map(|(q, _)| q);
    let center = own.clone().unwrap_or_else(|| start.q.clone());
    let lengths = (0..center.len()).filter(|&i| !description.is_angle(i)).map(|i| center[i].abs());
    let reach = lengths.fold(0.0, f64::max);
    let reach = if reach > 0.0 { reach } else { 1.0 };
    let free: Vec<usize> = (0..center.len()).filter(|&i| !start.given[i]).collect();
    let ratio = golden_ratio(free.len());
    let (mut found, mut since) = (Vec::from_iter(own), 0);
    let first = found.len();
    for number in 1..=MAX_GUESSES {
        let mut guess = start.clone();
        for (place, &i) in free.iter().enumerate() {
            let part = (0.5 + f64::from(number) * ratio.powi(-(place as i32) - 1)).fract() - 0.5;
            guess.q[i] = if description.is_angle(i) { TAU * part } else { 2.0 * REACH * reach * part };
        }
        since += 1;
        if let Ok((mut q, _)) = assemble_from_guesses(mechanism, &guess) {
            bring_near(description, &mut q, &center);
            if !found.iter().any(|other| distance(description, other, &q, reach) < SAME) {
                found.push(q);
                since = 0;
            }
        }
        if since >= PATIENCE || found.len() >= MAX_BRANCHES || !keep_running() {
            break;
        }
    }
    found[first..].sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    found
}

/// The root of `x^(d+1) = x + 1`; its negative powers fill a cube of `d` dimensions evenly.
fn golden_ratio(dimensions: usize) -> f64 {
    let exponent = 1.0 / (dimensions as f64 + 1.0);
    (0..100).fold(1.5_f64, |x, _| (1.0 + x).powf(exponent))
}

/// Removes whole turns from angles.
fn bring_near(description: &Description, q: &mut [f64], center: &[f64]) {
    for (i, value) in q.iter_mut().enumerate().filter(|(i, _)| description.is_angle(*i)) {
        let turned = (*value - center[i]).rem_euclid(TAU);
        // At half a turn, rounding errors would decide.
        *value = center[i] + if turned > PI + SAME { turned - TAU } else { turned };
    }
}

fn distance(description: &Description, a: &[f64], b: &[f64], reach: f64) -> f64 {
    let apart = |(i, (a, b)): (usize, (&f64, &f64))| {
        if !description.is_angle(i) {
            return (a - b).abs() / reach;
        }
        let turned = (a - b).rem_euclid(TAU);
        turned.min(TAU - turned)
    };
    a.iter().zip(b).enumerate().map(apart).fold(0.0, f64::max)
}
