//! The outputs whose extremes rows may not show, and the steps between rows in which they may lie.

use std::ops::Range;

use qrm_core::{Interval, Mechanism, RowLayout};

use super::extremes::{Extremes, sign};
use crate::bounds::{BoundedOutput, FunctionBounds, RowBoxes, bounded_outputs};
use crate::columns::number;
use crate::state::State;

/// Values beyond an extreme that do not count, in parts of the output's range.
const ROUNDING: f64 = 1e-13;
/// The number of bounds that an output may take inside steps, and for each sample, of outputs with at most so many
/// operations; others take as many times fewer bounds.
const FIRST_BOUNDS: u32 = 20_000;
const BOUNDS_OF_SAMPLE: u32 = 20;
const FEW_OPERATIONS: usize = 1000;
/// The growth of an output from one sample to the next that only a pole explains.
const POLE_GROWTH: f64 = 1e6;
/// The distance of a pole from a row at which the row lies on it, in parts of its numbers.
const POLE_DISTANCE: f64 = 1e-13;
/// The smallest change of a pole's value over that distance, in parts of it.
const POLE_CHANGE: f64 = 1e-3;
/// The number of samples that are kept for the next ones: they show how fast accelerations change.
const KEPT: usize = 3;

/// The bounds of outputs that may change faster between rows than the motion does, and the samples between which they
/// are bounded: rows and the states between them.
#[derive(Clone, Debug)]
pub(super) struct OutputBounds {
    layout: RowLayout,
    /// Each output has the number of bounds that it may still take inside steps.
    pub(super) outputs: Vec<(BoundedOutput, u32)>,
    /// The number of bounds that each sample adds.
    of_sample: u32,
    /// Each sample has time, coordinates, rates, accelerations, multipliers and outputs.
    samples: Vec<f64>,
    width: usize,
    /// The first step that was not looked at.
    next: usize,
}

/// A step between samples in which an output may exceed its known extremes.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnresolvedStep {
    /// The number of the sample before it.
    pub(super) step: usize,
    /// Whether the output may be smaller, and whether it may be larger.
    pub(super) ends: [bool; 2],
}

impl OutputBounds {
    /// `None` if rows show the extremes of all outputs, or the mechanism has no tape.
    pub(super) fn new(mechanism: &dyn Mechanism, layout: RowLayout) -> Option<Self> {
        let operations = mechanism.tape()?.outputs.operations.len();
        let cost = u32::try_from(operations / FEW_OPERATIONS).unwrap_or(u32::MAX).max(1);
        let [first, of_sample] = [FIRST_BOUNDS / cost, (BOUNDS_OF_SAMPLE / cost).max(1)];
        let outputs: Vec<_> = bounded_outputs(mechanism).into_iter().map(|output| (output, first)).collect();
        let width = 1 + 3 * layout.n + layout.m + mechanism.description().outputs.len();
        (!outputs.is_empty()).then_some(Self { layout, outputs, of_sample, samples: Vec::new(), width, next: 0 })
    }

    /// Adds a sample: a row's state, and its outputs.
    pub(super) fn add(&mut self, row: &[f64], outputs: &[f64]) {
        self.samples.extend_from_slice(&row[..self.width - outputs.len()]);
        self.samples.extend_from_slice(outputs);
        for (_, left) in &mut self.outputs {
            *left = left.saturating_add(self.of_sample);
        }
    }

    /// The output that has a pole at the next row, within rounding errors.
    pub(super) fn pole_at(&mut self, mechanism: &dyn Mechanism, row: &[f64], outputs: &[f64]) -> Option<usize> {
        let Self { layout, samples, .. } = self;
        let before = &samples[samples.len().checked_sub(outputs.len())?..];
        self.outputs.iter_mut().find_map(|(BoundedOutput { output, bounds }, _)| {
            let [from, to] = [before[*output], outputs[*output]].map(f64::abs);
            let is_pole = from > 0.0
                && to > POLE_GROWTH * from
                && !bounds.near(row, POLE_DISTANCE).is_finite()
                && [-POLE_DISTANCE, POLE_DISTANCE].into_iter().any(|distance| {
                    let mut near = State::from_row(*layout, row);
                    near.q.iter_mut().zip(&mut near.qd).for_each(|(q, qd)| {
                        *q *= 1.0 + distance;
                        *qd *= 1.0 - distance;
                    });
                    let value = number(mechanism, &near, 1 + 3 * layout.n + layout.m + *output);
                    !((value - outputs[*output]).abs() < POLE_CHANGE * to)
                });
            is_pole.then_some(*output)
        })
    }

    /// The state of a sample.
    pub(super) fn state(&self, sample: usize) -> State {
        State::from_row(self.layout, &self.samples[sample * self.width..])
    }

    /// The steps in which an output may exceed its known extremes.
    pub(super) fn unresolved(&mut self, which: usize, known: &Extremes) -> Vec<UnresolvedStep> {
        let Self { layout, outputs, samples, width, next, .. } = self;
        let (BoundedOutput { output, bounds }, _) = &mut outputs[which];
        let rows: Vec<&[f64]> = samples.chunks_exact(*width).collect();
        let place = 1 + 3 * layout.n + layout.m + *output;
        let tie = ROUNDING * known.range();
        let known = [known.minimum.0 - tie, known.maximum.0 + tie];
        let mut steps = Unresolved { bounds, rows: &rows, n: layout.n, place, known, found: Vec::new() };
        if *next + 1 < rows.len() {
            steps.look_in(*next..rows.len() - 1);
        }
        steps.found
    }

    /// Bounds an output no more.
    pub(super) fn leave_out(&mut self, output: usize) {
        self.outputs.retain(|(own, _)| own.output != output);
    }

    /// Forgets the samples so far, except the last ones.
    pub(super) fn forget(&mut self) {
        let count = self.samples.len() / self.width;
        let kept = KEPT.min(count);
        self.samples.drain(..(count - kept) * self.width);
        self.next = kept.saturating_sub(1);
    }
}

/// The search for unresolved steps of an output.
struct Unresolved<'s> {
    bounds: &'s mut FunctionBounds,
    rows: &'s [&'s [f64]],
    n: usize,
    /// The place of the output in a row.
    place: usize,
    /// The known extremes.
    known: [f64; 2],
    found: Vec<UnresolvedStep>,
}

impl Unresolved<'_> {
    /// Looks in some steps.
    ///
    /// Between rows, an output exceeds their values by at most `max |f''| h^2/8`, or `max |f'| h/2` at corners. Where
    /// it rises, falls or has one peak, rows and the polynomials through them show its extremes.
    fn look_in(&mut self, steps: Range<usize>) {
        let part = self.rows.get(steps.start..=steps.end).unwrap_or_default();
        let boxed = if self.bounds.takes_forces(self.n) {
            &self.rows[steps.start.saturating_sub(1)..(steps.end + 2).min(self.rows.len())]
        } else {
            part
        };
        let is_known = boxed.len() > 2 || !self.bounds.takes_forces(self.n);
        let boxes = RowBoxes::new(boxed, self.n, &self.bounds.arguments);
        let natural = self.bounds.among(&boxes, 0);
        let [low, high] = self.known;
        if is_known && low <= natural.lo() && natural.hi() <= high {
            return;
        }
        let [mut slope, mut curvature] = [Interval::ENTIRE; 2];
        if is_known && natural.is_finite() && !self.bounds.may_jump() {
            slope = self.bounds.among(&boxes, 1);
            if self.bounds.is_smooth() {
                curvature = self.bounds.among(&boxes, 2) * Interval::point(2.0);
            }
        }
        let h = boxes.spacing;
        let reach = (curvature.magnitude() * h * h / 8.0).min(slope.magnitude() * h / 2.0);
        let value = |row: usize| self.rows[row][self.place];
        let may_exceed = |step: usize, end: usize| {
            let values = [value(step), value(step + 1)];
            let is_within = |value: f64| if end == 0 { value - reach >= low } else { value + reach <= high };
            // Written so that values that are not numbers may exceed.
            !values.into_iter().all(is_within)
        };
        let turns = |end: usize| {
            let sign = sign(end);
            let is_peak = |row: usize| {
                let [before, at, after] = [row - 1, row, row + 1].map(|row| sign * value(row));
                before <= at && at >= after
            };
            (curvature * Interval::point(sign)).hi() < 0.0 && (steps.start + 1..steps.end).any(is_peak)
        };
        let is_monotonic = slope.lo() > 0.0 || slope.hi() < 0.0;
        let open = [0, 1].map(|end| !is_monotonic && !turns(end));
        let exceeding = |step: usize| [0, 1].map(|end| open[end] && may_exceed(step, end));
        if steps.len() == 1 {
            let ends = exceeding(steps.start);
            if ends.contains(&true) {
                self.found.push(UnresolvedStep { step: steps.start, ends });
            }
            return;
        }
        // Runs of steps in which it may exceed.
        let mut runs: Vec<Range<usize>> = Vec::new();
        for step in steps.clone().filter(|&step| exceeding(step).contains(&true)) {
            match runs.last_mut() {
                Some(run) if run.end == step => run.end += 1,
                _ => runs.push(step..step + 1),
            }
        }
        for run in runs {
            if run == steps {
                let middle = steps.start + steps.len() / 2;
                self.look_in(steps.start..middle);
                self.look_in(middle..steps.end);
            } else {
                self.look_in(run);
            }
        }
    }
}
