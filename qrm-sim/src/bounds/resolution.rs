//! The times between rows at which outputs must be computed to show how they change.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use qrm_core::{Mechanism, RowLayout};

use super::arguments::ArgumentPolynomials;
use super::function::FunctionBounds;
use super::rows::RowBoxes;
use super::{BoundedOutput, bounded_outputs};
use crate::polynomial::Polynomial;
use crate::solve::Solver;
use crate::state::State;

/// The largest deviation of an output from the line between two rows, in parts of its range, for which rows show how it
/// changes.
const RESOLVED: f64 = 1e-4;
/// The largest deviation from the line between parts of a step, in which no change is missed.
const SEEN: f64 = 1e-2;
/// The largest error of a polynomial through six parts, in parts of the range.
const INTERPOLATED: f64 = 1e-9;
/// The number of parts for a polynomial.
const WINDOW: usize = 6;
/// The smallest range, in parts of the values: smaller ones are near their rounding errors.
const SMALLEST_PART: f64 = 1e-6;
/// A range that is as small as zero.
const SMALLEST_RANGE: f64 = 1e-30;
/// The number of rows before the end of a step that show how fast accelerations change.
const BEFORE: usize = 5;
/// The largest ratio of distances between neighbouring times.
const GRADE: f64 = 2.1;
/// The largest number of parts of a step.
const MOST_PARTS: usize = 10_000;
/// The shortest part of a step.
const SHORTEST: f64 = 1e-6;

/// An output changes too fast in the step that ends at a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unresolved {
    /// The time of the row.
    pub(crate) t: f64,
    /// The number of the output.
    pub(crate) output: usize,
}

/// The outputs that may change faster between rows than the motion does, and the last rows.
pub(crate) struct Resolution {
    outputs: Vec<BoundedOutput>,
    /// The smallest and the largest value of each of them.
    ranges: Vec<[f64; 2]>,
    /// Time, coordinates, rates, accelerations, multipliers and outputs of each row.
    rows: Vec<Vec<f64>>,
    solver: Option<Solver>,
    /// The distance of the last time from the one before it, if it was needed between rows.
    spacing: Option<f64>,
    /// The part of the usual deviations that is accepted.
    factor: f64,
}

impl Resolution {
    /// Begins without rows, for these outputs, or all; the deviation may be smaller than usual by a factor.
    pub(crate) fn new(mechanism: &dyn Mechanism, which: Option<&[usize]>, factor: f64) -> Self {
        let n = mechanism.description().coordinates.len();
        let mut outputs = bounded_outputs(mechanism);
        outputs.retain(|own| which.is_none_or(|which| which.contains(&own.output)));
        let takes_forces = outputs.iter().any(|own| own.bounds.takes_forces(n));
        Self {
            ranges: vec![[f64::INFINITY, f64::NEG_INFINITY]; outputs.len()],
            rows: Vec::new(),
            solver: takes_forces.then(|| Solver::new(mechanism)),
            spacing: None,
            factor,
            outputs,
        }
    }

    /// Whether there are such outputs.
    pub(crate) fn is_needed(&self) -> bool {
        !self.outputs.is_empty()
    }

    /// Adds rows with their outputs, and returns the times since the row before them at which outputs must be computed.
    ///
    /// # Errors
    /// An output changes too fast.
    pub(crate) fn times(
        &mut self,
        mechanism: &dyn Mechanism,
        new: &[(State, Vec<f64>)],
    ) -> Result<Vec<f64>, Unresolved> {
        let Some((first, _)) = new.first() else { return Ok(Vec::new()) };
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let n = layout.n;
        let known = self.rows.len();
        for (at, outputs) in new {
            self.rows.push([&[at.t][..], &at.q, &at.qd, &at.qdd, &at.multipliers, outputs].concat());
            for (own, [low, high]) in self.outputs.iter().zip(&mut self.ranges) {
                let value = outputs[own.output];
                (*low, *high) = (low.min(value), high.max(value));
            }
        }
        let rows: Vec<&[f64]> = self.rows.iter().map(Vec::as_slice).collect();
        let mut times = Vec::new();
        for (BoundedOutput { output, bounds }, [low, high]) in self.outputs.iter_mut().zip(&self.ranges) {
            let range = (high - low).max(SMALLEST_PART * high.abs().max(low.abs()));
            // All steps are tried at once first.
            if rows.len() < 2 || is_resolved_by(bounds, (&rows, n), range, self.factor * RESOLVED) {
                continue;
            }
            for end in known.max(1)..rows.len() {
                let (before, around) = (rows[end - 1], end.saturating_sub(BEFORE)..(end + 2).min(rows.len()));
                if before[0] >= rows[end][0]
                    || is_resolved_by(bounds, (&rows[around], n), range, self.factor * RESOLVED)
                {
                    continue;
                }
                let [from, to] = [before, rows[end]].map(|row| State::from_row(layout, row));
                let ends = [&from, &to];
                let motion = ArgumentPolynomials::between(mechanism, self.solver.as_mut(), ends, &bounds.arguments);
                let Some(motion) = motion else { continue };
                let h = to.t - from.t;
                let place = 1 + 3 * n + layout.m + *output;
                let known = rows[end.saturating_sub(WINDOW - 1)..=end].iter();
                let known = known.map(|row| ((row[0] - from.t) / h, row[place]));
                let known = known.filter(|(s, _)| *s == 1.0 || *s <= 0.0).collect();
                let parts = parts(bounds, &motion, known, range, self.factor);
                let parts = parts.ok_or(Unresolved { t: to.t, output: *output })?;
                times.extend(parts.into_iter().map(|s| from.t + s * h));
            }
        }
        if !times.is_empty() || self.spacing.is_some() {
            let ends = &rows[known.saturating_sub(1)..];
            times.extend(ends.iter().map(|row| row[0]));
            times = graded(times, self.spacing);
            self.spacing = match times[..] {
                [.., before, last] => Some(last - before),
                _ => None,
            };
            times.retain(|t| ends.iter().all(|row| row[0] != *t));
        }
        self.rows.drain(..self.rows.len().saturating_sub(BEFORE));
        Ok(times)
    }
}

/// The times with others between them, so that none is more than twice as far from its neighbour on one side as from
/// that on the other: a polynomial through times at very different distances oscillates. The times begin after others
/// with a spacing.
fn graded(mut times: Vec<f64>, before: Option<f64>) -> Vec<f64> {
    times.sort_by(f64::total_cmp);
    times.dedup();
    let [Some(first), Some(last)] = [times.first(), times.last()] else { return times };
    let least = SHORTEST * (last - first);
    loop {
        let widths: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let is_wide = |i: usize| {
            let neighbours = [i.checked_sub(1).map_or(before, |i| Some(widths[i])), widths.get(i + 1).copied()];
            neighbours.into_iter().flatten().any(|width| widths[i] > GRADE * width.max(least))
        };
        let middles: Vec<f64> =
            (0..widths.len()).filter(|&i| is_wide(i)).map(|i| 0.5 * (times[i] + times[i + 1])).collect();
        if middles.is_empty() {
            return times;
        }
        times.extend(middles);
        times.sort_by(f64::total_cmp);
    }
}

/// Whether rows show how an output with this range changes between them.
fn is_resolved_by(bounds: &mut FunctionBounds, (rows, n): (&[&[f64]], usize), range: f64, resolved: f64) -> bool {
    let boxes = RowBoxes::new(rows, n, &bounds.arguments);
    let natural = bounds.among(&boxes, 0);
    if !natural.is_finite() || !bounds.is_smooth() {
        return false;
    }
    bounds.among(&boxes, 1);
    let curvature = 2.0 * bounds.among(&boxes, 2).magnitude();
    curvature * boxes.spacing * boxes.spacing / 8.0 <= resolved * range.max(SMALLEST_RANGE)
}

/// The ends of the parts of a step, except its own, between which polynomials give an output with this range; `None` if
/// they are too many. The output is known at the step's ends, and at parts before it.
///
/// The part that may be farthest from a line is halved first: the range grows with the values between its halves.
fn parts(
    bounds: &mut FunctionBounds,
    motion: &ArgumentPolynomials,
    known: Vec<(f64, f64)>,
    range: f64,
    factor: f64,
) -> Option<Vec<f64>> {
    let mut part = |begin: f64, end: f64| {
        let (bound, width) = (bounds.within(motion, [begin, end], |_| false), end - begin);
        let reach = (bound.curvature.magnitude() * width * width / 8.0)
            .min(bound.slope.magnitude() * width / 2.0)
            .min(bound.value.width());
        let middle = bounds.at(motion, 0.5 * (begin + end));
        // The output may consist of rounding errors.
        let is_rounding = middle.is_finite() && bound.value.width() <= 4.0 * middle.width();
        let is_final = is_rounding || width <= SHORTEST;
        (Part { reach: if is_final { 0.0 } else { reach }, begin, end }, middle)
    };
    let (first, middle) = part(0.0, 1.0);
    let (mut open, mut ends, mut values) = (BinaryHeap::from([first]), Vec::new(), middle);
    while let Some(Part { reach, begin, end }) = open.pop() {
        if reach <= SEEN * range.max(values.width()).max(SMALLEST_RANGE) {
            break;
        }
        if open.len() > MOST_PARTS {
            return None;
        }
        let at = 0.5 * (begin + end);
        ends.push(at);
        for (half, middle) in [part(begin, at), part(at, end)] {
            open.push(half);
            if middle.is_finite() {
                values = if values.is_finite() { values.hull(middle) } else { middle };
            }
        }
    }
    let scale = range.max(values.width()).max(SMALLEST_RANGE);
    refined(known, ends, factor * scale, |s| bounds.at(motion, s).mid())
}

/// The ends of parts with others, so that polynomials through six of them give an output between them; `None` if they
/// are too many.
fn refined(
    mut points: Vec<(f64, f64)>,
    ends: Vec<f64>,
    scale: f64,
    mut at: impl FnMut(f64) -> f64,
) -> Option<Vec<f64>> {
    points.extend(ends.into_iter().map(|s| (s, at(s))));
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Whether the part behind each point is known.
    let mut known: Vec<bool> = points.iter().map(|(s, _)| *s < 0.0).collect();
    while points.len() <= MOST_PARTS {
        let mut next = Vec::with_capacity(2 * points.len());
        for i in 0..points.len() {
            next.push((points[i], known[i]));
            let Some(&(end, _)) = points.get(i + 1) else { continue };
            let (begin, _) = points[i];
            if known[i] || end - begin <= SHORTEST {
                continue;
            }
            let first = (i + 1).saturating_sub(WINDOW / 2).min(points.len().saturating_sub(WINDOW));
            let window = &points[first..points.len().min(first + WINDOW)];
            let middle = 0.5 * (begin + end);
            let value = at(middle);
            let error = (Polynomial::through(window).value(middle) - value).abs();
            if window.len() < WINDOW || !(error <= INTERPOLATED * scale) {
                next.push(((middle, value), false));
            } else if let Some((_, is_known)) = next.last_mut() {
                *is_known = true;
            }
        }
        if next.len() == points.len() {
            return Some(points.into_iter().map(|(s, _)| s).filter(|s| 0.0 < *s && *s < 1.0).collect());
        }
        (points, known) = next.into_iter().unzip();
    }
    None
}

/// A part of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    /// The largest deviation of the output from a line.
    reach: f64,
    begin: f64,
    end: f64,
}

impl Eq for Part {}

impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        self.reach.total_cmp(&other.reach).then(other.begin.total_cmp(&self.begin))
    }
}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_distances_differ_by_a_factor_of_two() {
        let times = graded(vec![0.0, 1.0, 1.001, 3.0], Some(0.05));
        let widths: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(widths.windows(2).all(|pair| pair[0] <= GRADE * pair[1] && pair[1] <= GRADE * pair[0]), "{widths:?}");
        assert!(widths[0] <= GRADE * 0.05, "{widths:?}");
    }

    #[test]
    fn times_a_rounding_error_apart_are_one() {
        let times = graded(vec![0.0, 0.5, 0.5 + f64::EPSILON, 1.0], None);
        assert!(times.len() < 100, "{}", times.len());
    }

    #[test]
    fn a_corner_is_surrounded_by_times() {
        let ends = refined(vec![(0.0, 0.3), (1.0, 0.7)], Vec::new(), 1.0, |s| (s - 0.3).abs()).expect("few");
        let nearest = ends.iter().map(|s| (s - 0.3).abs()).fold(1.0, f64::min);
        assert!(nearest < 1e-5 && ends.len() < 500, "{nearest}, {}", ends.len());
    }
}
