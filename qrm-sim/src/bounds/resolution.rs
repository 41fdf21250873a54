//! The times between rows at which outputs must be computed to show how they change.

use qrm_core::{Interval, Mechanism};

use super::arguments::ArgumentPolynomials;
use super::function::FunctionBounds;
use super::rows::RowBoxes;
use super::{BoundedOutput, bounded_outputs};
use crate::solve::Solver;
use crate::state::State;

/// The largest deviation of an output from the line between two times, in parts of its range: polynomials of degree 5
/// through such rows have errors of about 1e-9 of it.
const RESOLVED: f64 = 1e-4;
/// A range that is as small as zero.
const SMALLEST_RANGE: f64 = 1e-30;
/// The number of rows before the end of a step that show how fast accelerations change.
const BEFORE: usize = 4;
/// The largest number of bounds in a step.
const MOST_BOUNDS: usize = 10_000;
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
    /// Time, coordinates, rates, accelerations and multipliers of each row.
    rows: Vec<Vec<f64>>,
    solver: Option<Solver>,
    /// The largest deviation.
    resolved: f64,
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
            resolved: factor * RESOLVED,
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
        let Some(n) = new.first().map(|(at, _)| at.q.len()) else { return Ok(Vec::new()) };
        let known = self.rows.len();
        for (at, outputs) in new {
            self.rows.push([&[at.t][..], &at.q, &at.qd, &at.qdd, &at.multipliers].concat());
            for (own, [low, high]) in self.outputs.iter().zip(&mut self.ranges) {
                let value = outputs[own.output];
                (*low, *high) = (low.min(value), high.max(value));
            }
        }
        let rows: Vec<&[f64]> = self.rows.iter().map(Vec::as_slice).collect();
        let mut times = Vec::new();
        for (BoundedOutput { output, bounds }, [low, high]) in self.outputs.iter_mut().zip(&self.ranges) {
            let range = high - low;
            // All steps at once, or each by itself.
            if rows.len() < 2 || is_resolved_by(bounds, (&rows, n), range, self.resolved) {
                continue;
            }
            for end in known.max(1)..rows.len() {
                let (before, around) = (rows[end - 1], end.saturating_sub(BEFORE)..(end + 2).min(rows.len()));
                if before[0] >= rows[end][0] || is_resolved_by(bounds, (&rows[around], n), range, self.resolved) {
                    continue;
                }
                let [from, to] = [before, rows[end]].map(|row| state(row, n));
                let ends = [&from, &to];
                let motion = ArgumentPolynomials::between(mechanism, self.solver.as_mut(), ends, &bounds.arguments);
                let Some(motion) = motion else { continue };
                let parts =
                    parts(bounds, &motion, range, self.resolved).ok_or(Unresolved { t: to.t, output: *output })?;
                times.extend(parts.into_iter().map(|s| from.t + s * (to.t - from.t)));
            }
        }
        times.sort_by(f64::total_cmp);
        times.dedup();
        self.rows.drain(..self.rows.len().saturating_sub(BEFORE));
        Ok(times)
    }
}

/// Whether rows show how an output with this range changes between them.
fn is_resolved_by(bounds: &mut FunctionBounds, (rows, n): (&[&[f64]], usize), range: f64, resolved: f64) -> bool {
    let boxes = RowBoxes::new(rows, n, &bounds.arguments);
    let arguments = bounds.arguments.clone();
    let of = |coefficient: &dyn Fn(usize) -> Interval| -> Vec<Interval> {
        arguments.iter().map(|&argument| coefficient(argument)).collect()
    };
    let natural = bounds.evaluate(0, &of(&|i| boxes.value(i)));
    if !natural.is_finite() || !bounds.is_smooth() {
        return false;
    }
    bounds.evaluate(1, &of(&|i| boxes.rate(i)));
    let curvature = 2.0 * bounds.evaluate(2, &of(&|i| boxes.half_curvature(i))).magnitude();
    curvature * boxes.spacing * boxes.spacing / 8.0 <= resolved * range.max(natural.width()).max(SMALLEST_RANGE)
}

/// The parts of a step, except its ends, between which an output with this range is near a line; `None` if they are too
/// many.
fn parts(bounds: &mut FunctionBounds, motion: &ArgumentPolynomials, range: f64, resolved: f64) -> Option<Vec<f64>> {
    let (mut found, mut open, mut count) = (Vec::new(), vec![[0.0, 1.0]], 0);
    let mut scale = None;
    while let Some([begin, end]) = open.pop() {
        count += 1;
        if count > MOST_BOUNDS {
            return None;
        }
        let (bound, width) = (bounds.within(motion, [begin, end], |_| false), end - begin);
        if bound.value.is_finite() {
            scale.get_or_insert(range.max(bound.value.width()).max(SMALLEST_RANGE));
        }
        let reach = (bound.curvature.magnitude() * width * width / 8.0)
            .min(bound.slope.magnitude() * width / 2.0)
            .min(bound.value.width());
        // What is computed may be rounding errors alone.
        let rounding = bounds.at(motion, 0.5 * (begin + end)).width();
        let is_rounding = rounding.is_finite() && bound.value.width() <= 4.0 * rounding;
        if scale.is_some_and(|scale| reach <= resolved * scale) || is_rounding || width <= SHORTEST {
            found.extend((end < 1.0).then_some(end));
        } else {
            let middle = 0.5 * (begin + end);
            open.extend([[middle, end], [begin, middle]]);
        }
    }
    Some(found)
}

/// The state of a row.
fn state(row: &[f64], n: usize) -> State {
    let [q, qd, qdd] = [0, 1, 2].map(|order| row[1 + order * n..1 + (order + 1) * n].to_vec());
    State { t: row[0], q, qd, qdd, multipliers: row[1 + 3 * n..].to_vec(), corrections: 0 }
}
