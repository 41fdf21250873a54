//! Extremes, mean and root mean square of numbers along a prescribed motion.

use super::inverse_dynamics::{NotPossible, Prescribed, PrescribedMotion, PrescribedState};
use crate::maximum::peak_between;
use crate::quadrature::{gauss_legendre, next_legendre};
use crate::solve::largest;

/// The number of times in a piece of the motion at which the numbers are computed.
const NODES: usize = 12;
/// The largest change of an angle in a piece that is tried.
const LONGEST: f64 = 1.0;
/// The largest of the last two coefficients of a Legendre series, relative to the largest value so far; other pieces
/// are halved.
const RESOLVED: f64 = 1e-11;
/// The largest difference between a number and its series at the ends of a piece, relative to the limit of the last
/// coefficients.
const ENDS: f64 = 100.0;
/// The limit where halving does not help.
const NOISE: f64 = 1e-8;
/// The factor by which halving a piece makes the last coefficients smaller, unless they are rounding errors.
const FALLING: f64 = 4.0;
/// The size of a number that is zero but for rounding errors, relative to the largest multiplier.
const ZERO: f64 = 1e-3;
/// The largest number of times that a piece is halved.
const MOST_HALVINGS: u32 = 20;
/// The largest number of pieces between two rows, halved ones included.
const MOST_PIECES: u32 = 20_000;
/// The number of equal parts of a piece at whose ends the series is compared with the known extremes.
const PARTS: usize = 64;
/// Rounding errors of a number, in parts of its size.
const ROUNDING: f64 = 1e-13;

/// Numbers at a state of the motion.
pub type Numbers<'f> = &'f dyn Fn(&PrescribedState) -> Vec<f64>;

/// Extremes, mean and root mean square of a number over the time of a motion, with their errors.
#[derive(Clone, Copy, Debug)]
pub struct Statistics {
    /// The smallest value, and its time.
    pub minimum: (f64, f64),
    /// The largest value, and its time.
    pub maximum: (f64, f64),
    /// The error of both.
    pub extreme_error: f64,
    /// The mean over the time.
    pub mean: f64,
    /// Its error.
    pub mean_error: f64,
    /// The root of the mean square over the time.
    pub root_mean_square: f64,
}

/// The sums over the pieces of a motion.
///
/// In each piece a number is a sum of Legendre polynomials, with the coefficients
/// `c_k = (2k + 1)/2 sum w_i f(x_i) P_k(x_i)` by Gauss-Legendre quadrature. A piece is halved until the last two terms
/// are small, and the sum is the number at both ends. Extremes are searched for on the motion itself where the sum
/// exceeds those that are known.
pub struct MotionStatistics {
    sums: Vec<Sum>,
    nodes: [(f64, f64); NODES],
    time: f64,
    /// The time of the last row, and the number of pieces that may follow before the next one.
    row: f64,
    left: u32,
}

/// The sums of a number.
#[derive(Clone, Copy, Debug)]
struct Sum {
    extremes: [(f64, f64); 2],
    integral: f64,
    of_square: f64,
    /// The largest of the last two terms of a series, and its integral over the time.
    last_term: f64,
    last_terms: f64,
}

impl MotionStatistics {
    /// Begins at a state.
    pub fn new(first: &PrescribedState, numbers: Numbers) -> Self {
        let sum = |value: f64| Sum {
            extremes: [(value, first.t); 2],
            integral: 0.0,
            of_square: 0.0,
            last_term: 0.0,
            last_terms: 0.0,
        };
        Self {
            sums: numbers(first).into_iter().map(sum).collect(),
            nodes: gauss_legendre::<NODES>(),
            time: 0.0,
            row: first.t,
            left: 0,
        }
    }

    /// Moves to a later time, and adds the motion up to there.
    ///
    /// # Errors
    /// The mechanism locks before that time, or the motion goes too far.
    pub fn advance(
        &mut self,
        motion: &mut PrescribedMotion,
        t: f64,
        prescribed: Prescribed,
        numbers: Numbers,
    ) -> Result<(), NotPossible> {
        (self.row, self.left) = (motion.state().t, MOST_PIECES);
        while motion.state().t < t {
            let state = motion.state();
            let fastest = motion.angles().fold(0.0_f64, |fastest, i| fastest.max(state.qd[i].abs()));
            let end = if fastest * (t - state.t) <= LONGEST { t } else { (state.t + LONGEST / fastest).min(t) };
            // Equal pieces: the last one is not a short remainder.
            let count = ((t - state.t) / (end - state.t)).ceil();
            let end = if count > 1.0 { state.t + (t - state.t) / count } else { t };
            self.add_piece(motion, end, (prescribed, numbers), (MOST_HALVINGS, &[]))?;
        }
        Ok(())
    }

    /// Adds a piece of the motion; `before` are the last terms of the piece that it is a half of.
    fn add_piece(
        &mut self,
        motion: &mut PrescribedMotion,
        end: f64,
        (prescribed, numbers): (Prescribed, Numbers),
        (halvings, before): (u32, &[f64]),
    ) -> Result<(), NotPossible> {
        self.left = self.left.checked_sub(1).ok_or_else(|| motion.unresolved(self.row))?;
        let begin = motion.clone();
        let (from, h) = (begin.state().t, end - begin.state().t);
        let mut values = Vec::with_capacity(NODES);
        let (mut error, mut held): (f64, f64) = (0.0, 0.0);
        for (x, _) in self.nodes {
            let state = motion.advance(from + x * h, prescribed)?;
            error = error.max(state.error);
            held = held.max(largest(&state.multipliers).1);
            values.push(numbers(state));
        }
        let series: Vec<[f64; NODES]> =
            (0..self.sums.len()).map(|i| self.series(&std::array::from_fn(|node| values[node][i]))).collect();
        let size = |i: usize, series: &[f64; NODES]| {
            let known = self.sums[i].extremes.iter().map(|(value, _)| value);
            series.iter().chain(known).fold(ZERO * held, |size, c| size.max(c.abs()))
        };
        let last = |series: &[f64; NODES]| series[NODES - 1].abs().max(series[NODES - 2].abs());
        let lasts: Vec<f64> = series.iter().map(last).collect();
        let at_begin = numbers(begin.state());
        let at_end = numbers(motion.advance(end, prescribed)?);
        // A corner between an end and the node next to it shows in no coefficient.
        let beyond = |i: usize, series: &[f64; NODES]| {
            (sum(series, -1.0) - at_begin[i]).abs().max((sum(series, 1.0) - at_end[i]).abs())
        };
        let is_resolved = series.iter().enumerate().all(|(i, series)| {
            let is_noise = before.get(i).is_some_and(|before| lasts[i] > before / FALLING);
            let limit = if is_noise { NOISE } else { RESOLVED } * size(i, series);
            lasts[i] <= limit && beyond(i, series) <= ENDS * limit
        });
        let middle = from + 0.5 * h;
        if !is_resolved && halvings > 0 && from < middle && middle < end {
            *motion = begin;
            self.add_piece(motion, middle, (prescribed, numbers), (halvings - 1, &lasts))?;
            return self.add_piece(motion, end, (prescribed, numbers), (halvings - 1, &lasts));
        }
        let of_series = |i: usize, own| if is_resolved { lasts[i] } else { lasts[i].max(beyond(i, own)) };
        let errors: Vec<f64> =
            series.iter().enumerate().map(|(i, own)| of_series(i, own) + error * size(i, own)).collect();
        self.time += h;
        for (i, series) in series.iter().enumerate() {
            let sum = &mut self.sums[i];
            let mut value = |t: f64| begin.clone().advance(t, prescribed).ok().map(|state| numbers(state)[i]);
            sum.add(series, h, errors[i]);
            for (node, (_, weight)) in self.nodes.iter().enumerate() {
                sum.of_square += h * weight * values[node][i] * values[node][i];
            }
            sum.search(series, (from, h), (at_end[i], errors[i]), &mut value);
        }
        Ok(())
    }

    /// The coefficients of the Legendre series through values at the nodes.
    fn series(&self, values: &[f64; NODES]) -> [f64; NODES] {
        let mut series = [0.0; NODES];
        for ((x, weight), value) in self.nodes.iter().zip(values) {
            for (k, legendre) in legendre(2.0 * x - 1.0).into_iter().enumerate() {
                series[k] += (2.0 * k as f64 + 1.0) * weight * value * legendre;
            }
        }
        series
    }

    /// The statistics of each number so far.
    pub fn finish(&self) -> Vec<Statistics> {
        let time = self.time;
        let statistics = |sum: &Sum| {
            let [minimum, maximum] = sum.extremes;
            let rounding = ROUNDING * minimum.0.abs().max(maximum.0.abs());
            Statistics {
                minimum,
                maximum,
                extreme_error: sum.last_term + rounding,
                mean: sum.integral / time,
                mean_error: sum.last_terms / time + rounding,
                root_mean_square: (sum.of_square / time).sqrt(),
            }
        };
        self.sums.iter().map(statistics).collect()
    }
}

impl Sum {
    fn add(&mut self, series: &[f64; NODES], h: f64, last: f64) {
        self.integral += h * series[0];
        self.last_term = self.last_term.max(last);
        self.last_terms += h * last;
    }

    /// Looks for larger and for smaller values in a piece, whose series has an error.
    fn search(
        &mut self,
        series: &[f64; NODES],
        (from, h): (f64, f64),
        (at_end, error): (f64, f64),
        value: &mut dyn FnMut(f64) -> Option<f64>,
    ) {
        for (end, sign) in [(0, -1.0), (1, 1.0)] {
            let known = &mut self.extremes[end];
            if sign * at_end > sign * known.0 {
                *known = (at_end, from + h);
            }
            let mut of_series = |x: f64| Some(sign * sum(series, x));
            let places = (0..=PARTS).map(|part| 2.0 * part as f64 / PARTS as f64 - 1.0);
            let values = places.map(|x| (x, sign * sum(series, x)));
            let Some(best) = values.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
            let ends = [-1.0, 1.0].map(|side| (best.0 + side * 2.0 / PARTS as f64).clamp(-1.0, 1.0));
            let Some(peak) = peak_between(ends, best, &mut of_series) else { continue };
            let tie = 2.0 * error + ROUNDING * known.0.abs();
            if peak.1 <= sign * known.0 + tie {
                continue;
            }
            let time = |x: f64| from + 0.5 * (1.0 + x) * h;
            let mut at = |t: f64| value(t).map(|value| sign * value);
            let first = at(time(peak.0)).map(|value| (time(peak.0), value));
            let found = first.and_then(|first| peak_between(ends.map(time), first, &mut at));
            if let Some((t, value)) = found.filter(|(_, value)| *value > sign * known.0) {
                *known = (sign * value, t);
            }
        }
    }
}

/// The Legendre polynomials at a place between -1 and 1.
fn legendre(x: f64) -> [f64; NODES] {
    let mut values = [1.0; NODES];
    values[1] = x;
    for k in 2..NODES {
        values[k] = next_legendre(k, x, [values[k - 2], values[k - 1]]);
    }
    values
}

/// A Legendre series at a place between -1 and 1.
fn sum(series: &[f64; NODES], x: f64) -> f64 {
    series.iter().zip(legendre(x)).map(|(coefficient, legendre)| coefficient * legendre).sum()
}
