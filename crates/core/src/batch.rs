//! Motions of one mechanism in the lanes of vectors: each lane takes its own steps.

extern crate alloc;

use alloc::vec;
use alloc::vec::Vec;

use crate::description::Description;
use crate::kernel::MAX_GROWTH;
use crate::lane_layout::{
    BatchLayout, BatchRequest, CHECKPOINT_STEP, CHECKPOINTS, COORDINATE_RANGES, DEFINED, END_TIME, EVENT, LONGEST,
    MAX_STEPS, NEAR_GROWTH, QUALITY, SHORTEST, STEP, STEPS_MADE, TOLERANCE,
};
use crate::lane_steps::BoxedLaneSteps;

/// Motions of any mechanism in any number of lanes.
///
/// Each lane chooses its steps by its own tolerance.
pub struct Batch {
    steps: BoxedLaneSteps,
    layout: BatchLayout,
    request: BatchRequest,
    residual: f64,
    /// Whether steps could not be made: no lane is reliable.
    has_failed: bool,
}

/// The step schedule of a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneSchedule {
    /// The target error of a step is 0.8 of this: absolute for an angle, relative to `1 + |x|` for a length or a rate
    /// `x`. Steps with more than four times this error are repeated.
    pub tolerance: f64,
    /// Longest step.
    pub longest: f64,
    /// The time at which the motion ends.
    pub end_time: f64,
    /// Length of the next step.
    pub step: f64,
    /// The number of steps after which the lane waits for its caller.
    pub max_steps: f64,
}

impl Batch {
    /// A batch for this mechanism; a step counts as reliable up to this residual of the constraints.
    pub fn new(steps: BoxedLaneSteps, mechanism: &Description, request: BatchRequest, residual: f64) -> Self {
        Self { steps, layout: BatchLayout::new(mechanism, &request), request, residual, has_failed: false }
    }

    /// The number of lanes.
    pub fn lanes(&self) -> usize {
        self.steps.lanes()
    }

    /// Sets the parameters of a lane.
    pub fn set_parameters(&mut self, lane: usize, values: &[f64]) {
        self.set(lane, self.layout.parameters(), values);
    }

    /// Places a motion at a row `[t, q, qd, qdd, multipliers]`, with a schedule of steps to make.
    pub fn place(&mut self, lane: usize, row: &[f64], schedule: &LaneSchedule) {
        self.set_row(lane, row);
        (0..CHECKPOINTS).for_each(|age| self.set(lane, self.layout.checkpoint(age), &row[..self.layout.width()]));
        [(STEPS_MADE, 0.0), (CHECKPOINT_STEP, 1.0)]
            .into_iter()
            .for_each(|(place, number)| self.set(lane, place, &[number]));
        self.set_schedule(lane, schedule);
        let n = self.layout.n;
        [0, 1].into_iter().for_each(|kind| self.set(lane, COORDINATE_RANGES + kind * n, &row[1..=n]));
    }

    /// Lets a lane rest that has no motion: it makes no steps, or those of a lane that has one.
    pub fn rest(&mut self, lane: usize, other: usize) {
        if self.steps.are_independent() {
            return self.set(lane, END_TIME, &[f64::NEG_INFINITY]);
        }
        let mut numbers = vec![0.0; self.layout.places()];
        self.steps.read(0, other, &mut numbers);
        self.steps.write(0, lane, &numbers);
    }

    /// Replaces the state of a lane.
    fn set_row(&mut self, lane: usize, row: &[f64]) {
        self.set(lane, self.layout.row(), &row[..self.layout.width()]);
    }

    /// The state of a lane as a row.
    pub fn read_row(&self, lane: usize, row: &mut Vec<f64>) {
        self.read(self.layout.row(), lane, row);
    }

    /// The state of a lane before the last step, as a row.
    pub fn read_row_before(&self, lane: usize, row: &mut Vec<f64>) {
        self.read(self.layout.row_before(), lane, row);
    }

    /// Reads the state of a lane at its last checkpoint (`age` 0) or at the one before (1), as a row without `qdd` and
    /// multipliers. Checkpoints are taken when the number of steps is a power of two.
    pub fn read_checkpoint(&self, age: usize, lane: usize, row: &mut Vec<f64>) {
        self.read(self.layout.checkpoint(age), lane, row);
    }

    /// The step schedule of a lane.
    pub fn schedule(&self, lane: usize) -> LaneSchedule {
        let [tolerance, longest, end_time, step, max_steps] =
            [TOLERANCE, LONGEST, END_TIME, STEP, MAX_STEPS].map(|place| self.get(lane, place));
        LaneSchedule { tolerance, longest, end_time, step, max_steps }
    }

    /// Replaces the step schedule of a lane.
    pub fn set_schedule(&mut self, lane: usize, schedule: &LaneSchedule) {
        let LaneSchedule { tolerance, longest, end_time, step, max_steps } = *schedule;
        [(TOLERANCE, tolerance), (LONGEST, longest), (END_TIME, end_time), (STEP, step), (MAX_STEPS, max_steps)]
            .into_iter()
            .for_each(|(place, number)| self.set(lane, place, &[number]));
    }

    /// Undoes the last step of a lane: restores this row with these outputs.
    pub fn undo_last_step(&mut self, lane: usize, row: &[f64], outputs: &[f64]) {
        self.set_row(lane, row);
        let outputs = &outputs[..self.layout.output_count.min(outputs.len())];
        self.begin_step(lane, outputs);
    }

    /// Makes steps until some lane needs its caller: see [`keep_running`](Self::keep_running).
    pub fn advance(&mut self) {
        self.has_failed |= !self.steps.advance();
    }

    /// The number of steps that a lane has made.
    pub fn steps(&self, lane: usize) -> u64 {
        self.get(lane, STEPS_MADE) as u64
    }

    /// Whether a lane can continue without its caller after the last step.
    pub fn keep_running(&self, lane: usize) -> bool {
        let numbers = self.numbers(lane);
        let t = self.get(lane, self.layout.row());
        !self.has_failed
            && !self.request.waits_each_step
            && t < numbers[END_TIME]
            && !is_stuck(&numbers)
            && numbers[EVENT] < 0.0
            && is_reliable(&numbers, self.residual, self.request.most_growth())
    }

    /// Whether the steps of a lane have become too short or too many.
    pub fn is_stuck(&self, lane: usize) -> bool {
        is_stuck(&self.numbers(lane))
    }

    /// Whether the last step of a lane can be relied on.
    pub fn is_reliable(&self, lane: usize) -> bool {
        !self.has_failed && is_reliable(&self.numbers(lane), self.residual, MAX_GROWTH)
    }

    /// Whether the last step of a lane may have come so near a singular position that requested forces lose digits.
    pub fn may_be_singular(&self, lane: usize) -> bool {
        self.request.forces && !(self.numbers(lane)[QUALITY] <= NEAR_GROWTH)
    }

    /// The numbers of a lane before [`DEFINED`].
    fn numbers(&self, lane: usize) -> [f64; DEFINED] {
        let mut numbers = [0.0; DEFINED];
        self.steps.read(0, lane, &mut numbers);
        numbers
    }

    /// The smallest and the largest value of a coordinate after any step; kept only with checkpoints.
    pub fn coordinate_range(&self, lane: usize, coordinate: usize) -> [f64; 2] {
        [0, 1].map(|kind| self.get(lane, COORDINATE_RANGES + kind * self.layout.n + coordinate))
    }

    /// The smallest and the largest value of an output so far.
    pub fn range(&self, lane: usize, output: usize) -> [f64; 2] {
        let get = |place: usize| self.get(lane, place + output);
        let [low, high] = [get(self.layout.step_lowest()), get(self.layout.step_highest())];
        [get(self.layout.lowest()).min(low), get(self.layout.highest()).max(high)]
    }

    /// The errors of the smallest and of the largest value of an output so far, as far as they come from the times at which
    /// the output was computed.
    pub fn range_errors(&self, lane: usize, output: usize) -> [f64; 2] {
        let get = |place: usize| self.get(lane, place + output);
        let [low, high] = self.range(lane, output);
        let least = get(self.layout.least()).min(get(self.layout.step_least()));
        let most = get(self.layout.most()).max(get(self.layout.step_most()));
        [low - least, most - high]
    }

    /// Whether all outputs of a lane have been numbers so far.
    pub fn is_defined(&self, lane: usize) -> bool {
        self.get(lane, DEFINED) == 0.0
    }

    /// Starts the ranges of a lane with these outputs.
    pub fn begin_ranges(&mut self, lane: usize, outputs: &[f64]) {
        let outputs = &outputs[..self.layout.output_count.min(outputs.len())];
        self.set(lane, DEFINED, &[outputs.iter().map(|value| 0.0 * value).sum()]);
        self.set(lane, self.layout.lowest(), outputs);
        self.set(lane, self.layout.highest(), outputs);
        self.set(lane, self.layout.least(), outputs);
        self.set(lane, self.layout.most(), outputs);
        self.begin_step(lane, outputs);
    }

    /// Starts the ranges of a step of a lane with these outputs.
    fn begin_step(&mut self, lane: usize, outputs: &[f64]) {
        let layout = self.layout;
        let of_step = [layout.step_lowest(), layout.step_highest(), layout.step_least(), layout.step_most()];
        [layout.outputs()].into_iter().chain(of_step).for_each(|place| self.set(lane, place, outputs));
    }

    fn get(&self, lane: usize, place: usize) -> f64 {
        let mut number = [0.0];
        self.steps.read(place, lane, &mut number);
        number[0]
    }

    /// Sets consecutive numbers of a lane, beginning at a place.
    fn set(&mut self, lane: usize, place: usize, numbers: &[f64]) {
        self.steps.write(place, lane, numbers);
    }

    fn read(&self, place: usize, lane: usize, row: &mut Vec<f64>) {
        row.resize(self.layout.width(), 0.0);
        self.steps.read(place, lane, row);
    }
}

fn is_stuck(numbers: &[f64; DEFINED]) -> bool {
    numbers[STEP] <= SHORTEST * numbers[END_TIME] || numbers[STEPS_MADE] >= numbers[MAX_STEPS]
}

fn is_reliable(numbers: &[f64; DEFINED], tolerance: f64, most_growth: f64) -> bool {
    let [growth_factor, residual, finite_check] = [0, 1, 2].map(|i| numbers[QUALITY + i]);
    growth_factor.abs() <= most_growth && residual <= tolerance && finite_check == 0.0
}
