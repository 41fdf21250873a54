//! The result of a design in a lane.

use super::super::design::{DesignResult, run_alone};
use super::{Lane, LaneSweep};
use crate::run::{NonFiniteQuantity, Status, is_balanced};
use crate::state::State;

/// With fewer steps, a design and its companion may make the same ones.
const FEWEST_STEPS: u64 = 10;
/// The largest error of an output's extremes, in parts of its range, and the smallest one that is no rounding error, in
/// parts of its size, or of 1 if that is larger.
const RESOLVED: f64 = 0.05;
const ROUNDING: f64 = 1e-12;

impl LaneSweep<'_> {
    /// Takes up the end of a lane's design.
    pub(super) fn finish(&mut self, lane: usize, status: Status, at: &State) {
        let Some(Lane { design, first, .. }) = &self.lanes[lane] else { return };
        let design = *design;
        let has_few_steps = self.request.estimate_error && self.batch.steps(lane) < FEWEST_STEPS;
        if has_few_steps || !self.batch.is_defined(lane) || !self.is_balanced(design, first, at) {
            self.leave(lane);
            return;
        }
        let mut result = self.result(lane, design, status, at);
        if !are_resolved(&result) {
            return self.leave(lane);
        }
        if self.request.estimate_error {
            self.await_companion(lane, result, at);
        } else {
            self.lanes[lane] = None;
            result.extreme_errors.clear();
            self.finished[design] = Some(result);
        }
    }

    /// Whether the energy at the end is that at the start, if no load without potential works at either.
    fn is_balanced(&self, design: usize, first: &State, at: &State) -> bool {
        let mechanism = &*self.designs[design];
        if first.power(mechanism) != 0.0 || at.power(mechanism) != 0.0 {
            return true;
        }
        let [before, after] = [first, at].map(|at| mechanism.energy(&at.q, &at.qd));
        let imbalance = (after[0] + after[1] - before[0] - before[1]).abs();
        is_balanced(imbalance, before[0].max(after[0]), before[1].abs().max(after[1].abs()))
    }

    /// The smallest and the largest value of each coordinate.
    pub(super) fn ranges(&self, lane: usize, at: &State) -> Vec<[f64; 2]> {
        let range = |i: usize| {
            let [low, high] = self.batch.coordinate_range(lane, i);
            [low.min(at.q[i]), high.max(at.q[i])]
        };
        (0..self.size.0).map(range).collect()
    }

    /// The end of a design in a lane.
    fn result(&self, lane: usize, design: usize, status: Status, at: &State) -> DesignResult {
        let outputs = self.outputs(design, at);
        let status = match outputs.iter().position(|value| !value.is_finite()) {
            Some(output) => Status::NotFinite { t: at.t, what: NonFiniteQuantity::Output(output) },
            None => status,
        };
        let range = |(output, value): (usize, &f64)| {
            let [low, high] = self.batch.range(lane, output);
            [low.min(*value), high.max(*value)]
        };
        DesignResult {
            status: Ok(status),
            steps: self.batch.steps(lane),
            end_time: at.t,
            end_time_error: None,
            q: at.q.clone(),
            qd: at.qd.clone(),
            extreme_errors: (0..outputs.len()).map(|output| self.batch.range_errors(lane, output)).collect(),
            extremes: outputs.iter().enumerate().map(range).collect(),
            estimated_error: None,
            rejection_reasons: Vec::new(),
            nearest_singular: None,
            redundancy: None,
            is_alone: false,
        }
    }

    /// Lets a design leave its lane for a run of its own, which tells when and what went wrong.
    pub(super) fn leave(&mut self, lane: usize) {
        if let Some(Lane { design, .. }) = self.lanes[lane].take() {
            self.run_alone(design);
        }
    }

    pub(super) fn run_alone(&mut self, design: usize) {
        self.finished[design] = Some(run_alone(design, &*self.designs[design], self.request));
    }
}

/// Whether the steps show how the outputs change.
fn are_resolved(result: &DesignResult) -> bool {
    result.extremes.iter().zip(&result.extreme_errors).all(|([low, high], errors)| {
        let error = errors[0].max(errors[1]);
        error <= RESOLVED * (high - low) || error <= ROUNDING * low.abs().max(high.abs()).max(1.0)
    })
}
