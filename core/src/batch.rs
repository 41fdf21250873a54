//! Motions of one mechanism in the lanes of vectors: each lane makes the steps of a design of its own.

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::kernel::MAX_GROWTH;
use crate::lane_steps::{LaneSteps, PARTS};

/// Motions in lanes, whatever the mechanism and the number of lanes.
///
/// If errors are estimated, three steps of every lane are followed by two longer ones of a companion motion.
pub struct SimdBatch {
    steps: Box<dyn LaneSteps>,
    layout: BatchLayout,
    request: BatchRequest,
    residual: f64,
}

/// The steps of a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneSchedule {
    /// Length of the steps.
    pub step: f64,
    /// Number of the last step.
    pub last: f64,
    /// Its end.
    pub end_time: f64,
}

/// A motion in a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneRole {
    /// The motion itself.
    Main,
    /// Its companion at 3/2 of the step; where lanes choose their steps, the state of the motion at the last number of
    /// steps that was a power of two.
    Companion,
}

/// Why a batch of motions waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PauseReason {
    /// A step was made that some lane cannot simply go on from: it is the last one, the event occurred in it or has to
    /// be looked for, or it cannot be relied on.
    Step,
    /// A companion's step cannot be relied on.
    Companion,
    /// A lane may take another design now.
    Refill,
}

/// What every lane of a batch is asked to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchRequest {
    /// Whether the scene's event ends a motion.
    pub watches_event: bool,
    /// Whether each step is looked at from outside: the caller has a stop condition of its own.
    pub waits_each_step: bool,
    /// Whether the ranges of outputs are wanted.
    pub ranges: bool,
    /// Whether companions estimate errors, where steps have a fixed length.
    pub companions: bool,
    /// Whether each lane chooses its steps by a tolerance.
    pub is_adaptive: bool,
}

/// The size of the vectors of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Eight doubles (AVX-512).
    Eight,
    /// Four doubles (AVX2).
    Four,
}

/// The places of the numbers of a batch; at each place stands one number of every lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BatchLayout {
    /// Number of coordinates.
    pub(crate) n: usize,
    /// Number of constraints.
    pub(crate) m: usize,
    /// Number of outputs whose ranges are wanted.
    pub(crate) output_count: usize,
}

/// The steps that were made.
pub(crate) const MADE: usize = 0;
/// The number of the last step, the length of the steps and the end of the last one.
pub(crate) const LAST: usize = 1;
pub(crate) const STEP: usize = 2;
pub(crate) const END_TIME: usize = 3;
/// The value of the scene's event after the step that is waited for.
pub(crate) const EVENT: usize = 4;
/// Growth factor, residual and check for finite numbers of that step.
pub(crate) const QUALITY: usize = 5;
/// Not a number if an output was none.
pub(crate) const DEFINED: usize = 8;
/// The tolerance and the longest step of a lane that chooses its steps.
pub(crate) const TOLERANCE: usize = 9;
pub(crate) const LONGEST: usize = 10;
/// The number of the step after which a lane that chooses its steps keeps its state next.
pub(crate) const CHECKPOINT: usize = 11;
/// The largest difference of each coordinate from the companion, then the smallest and the largest value of each.
pub(crate) const DIFFERENCES: usize = 12;

/// A lane waits when the steps that it chooses become shorter than this part of its end time.
pub(crate) const SHORTEST: f64 = 1e-12;

impl BatchLayout {
    /// The layout for a mechanism of this size.
    #[inline(always)]
    pub(crate) const fn new(n: usize, m: usize, outputs: usize, request: &BatchRequest) -> Self {
        Self { n, m, output_count: if request.ranges { outputs } else { 0 } }
    }

    /// The length of a row `[t, q, qd, qdd, multipliers]`.
    #[inline(always)]
    pub(crate) const fn width(self) -> usize {
        1 + 3 * self.n + self.m
    }

    #[inline(always)]
    const fn first_row(self) -> usize {
        DIFFERENCES + 3 * self.n
    }

    /// The row of a motion.
    #[inline(always)]
    pub(crate) const fn row(self, role: LaneRole) -> usize {
        self.first_row() + role as usize * self.width()
    }

    /// The row before the step that is waited for.
    #[inline(always)]
    pub(crate) const fn row_before(self) -> usize {
        self.first_row() + 2 * self.width()
    }

    /// The outputs of the last row.
    #[inline(always)]
    pub(crate) const fn outputs(self) -> usize {
        self.first_row() + 3 * self.width()
    }

    /// The smallest values of the outputs.
    #[inline(always)]
    pub(crate) const fn lowest(self) -> usize {
        self.outputs() + self.output_count
    }

    /// The largest values of the outputs.
    #[inline(always)]
    pub(crate) const fn highest(self) -> usize {
        self.lowest() + self.output_count
    }

    /// The smallest values of the outputs in the last step of a length that a lane chose.
    #[inline(always)]
    pub(crate) const fn step_lowest(self) -> usize {
        self.highest() + self.output_count
    }

    /// The largest values of the outputs in that step.
    #[inline(always)]
    pub(crate) const fn step_highest(self) -> usize {
        self.step_lowest() + self.output_count
    }

    /// The outputs at the end of a part of that step, from the first part on.
    #[inline(always)]
    pub(crate) const fn sample(self, part: usize) -> usize {
        self.step_highest() + part * self.output_count
    }

    /// The number of places.
    #[inline(always)]
    pub(crate) const fn places(self) -> usize {
        self.sample(1 + PARTS)
    }
}

impl SimdBatch {
    /// For a mechanism of this size; a step counts as reliable up to this residual of the constraints.
    pub(crate) fn new(
        steps: Box<dyn LaneSteps>,
        (n, m, outputs): (usize, usize, usize),
        request: BatchRequest,
        residual: f64,
    ) -> Self {
        Self { steps, layout: BatchLayout::new(n, m, outputs, &request), request, residual }
    }

    /// The number of lanes.
    pub fn lanes(&self) -> usize {
        self.steps.lanes()
    }

    /// Gives lanes their parameters.
    pub fn set_parameters(&mut self, values: &[Vec<f64>]) {
        self.steps.set_parameters(values);
    }

    /// Puts a motion and its companion at a row `[t, q, qd, qdd, multipliers]`, with its steps still to make.
    pub fn place(&mut self, lane: usize, row: &[f64], schedule: &LaneSchedule) {
        self.set_row(LaneRole::Main, lane, row);
        self.set_row(LaneRole::Companion, lane, row);
        let LaneSchedule { step, last, end_time } = *schedule;
        let numbers = [(MADE, 0.0), (LAST, last), (STEP, step), (END_TIME, end_time), (CHECKPOINT, 1.0)];
        numbers.into_iter().for_each(|(place, number)| self.set(lane, place, &[number]));
        for (i, q) in row[1..=self.layout.n].iter().enumerate() {
            [(0, 0.0), (1, *q), (2, *q)]
                .into_iter()
                .for_each(|(kind, number)| self.set(lane, DIFFERENCES + kind * self.layout.n + i, &[number]));
        }
    }

    /// Copies the motion of a lane to another one.
    pub fn copy(&mut self, from: usize, to: usize) {
        let mut row = Vec::new();
        self.read_row(LaneRole::Main, from, &mut row);
        self.set_row(LaneRole::Main, to, &row);
        self.set_row(LaneRole::Companion, to, &row);
        [MADE, LAST, STEP, END_TIME, TOLERANCE, LONGEST]
            .into_iter()
            .for_each(|place| self.set(to, place, &[self.get(from, place)]));
    }

    /// Replaces the state of a lane, or of its companion.
    pub fn set_row(&mut self, role: LaneRole, lane: usize, row: &[f64]) {
        self.set(lane, self.layout.row(role), &row[..self.layout.width()]);
    }

    /// The state of a lane, or of its companion, as a row.
    pub fn read_row(&self, role: LaneRole, lane: usize, row: &mut Vec<f64>) {
        self.read(self.layout.row(role), lane, row);
    }

    /// The state of a lane, or of its companion, before the last step, as a row.
    pub fn read_row_before(&self, lane: usize, row: &mut Vec<f64>) {
        self.read(self.layout.row_before(), lane, row);
    }

    /// Sets the tolerance by which a lane chooses its steps, and the longest one.
    pub fn set_tolerance(&mut self, lane: usize, tolerance: f64, longest: f64) {
        self.set(lane, TOLERANCE, &[tolerance]);
        self.set(lane, LONGEST, &[longest]);
    }

    /// Sets the time that the steps of a lane do not go beyond, and the length of the next one.
    pub fn set_end(&mut self, lane: usize, end_time: f64, step: f64) {
        self.set(lane, END_TIME, &[end_time]);
        self.set(lane, STEP, &[step]);
    }

    /// Takes the last step of a lane back: puts it at a row with these outputs.
    pub fn take_back(&mut self, lane: usize, row: &[f64], outputs: &[f64]) {
        self.set_row(LaneRole::Main, lane, row);
        self.set_outputs(lane, outputs);
        self.begin_step_ranges(lane, outputs);
    }

    /// Whether the steps of a lane have become too short.
    pub fn stands_still(&self, lane: usize) -> bool {
        self.get(lane, STEP) <= SHORTEST * self.get(lane, END_TIME)
    }

    /// The length of the next step of a lane.
    pub fn next_step(&self, lane: usize) -> f64 {
        self.get(lane, STEP)
    }

    /// Makes steps until some lane cannot simply go on.
    pub fn advance(&mut self, wants_refill: bool) -> PauseReason {
        self.steps.advance(wants_refill)
    }

    /// The number of steps that a lane has made.
    pub fn steps(&self, lane: usize) -> u64 {
        self.get(lane, MADE) as u64
    }

    /// Whether a lane can simply go on after the step that is waited for.
    pub fn goes_on(&self, lane: usize) -> bool {
        !self.request.waits_each_step
            && self.get(lane, MADE) < self.get(lane, LAST)
            && self.get(lane, self.layout.row(LaneRole::Main)) < self.get(lane, END_TIME)
            && !self.stands_still(lane)
            && self.get(lane, EVENT) < 0.0
            && self.is_reliable(lane)
    }

    /// Whether the last step of a lane, or of its companion, can be relied on.
    pub fn is_reliable(&self, lane: usize) -> bool {
        let [growth_factor, residual, finite_check] = [0, 1, 2].map(|i| self.get(lane, QUALITY + i));
        growth_factor.abs() <= MAX_GROWTH && residual <= self.residual && finite_check == 0.0
    }

    /// The largest difference of a coordinate between a motion and its companion.
    pub fn difference(&self, lane: usize, coordinate: usize) -> f64 {
        self.get(lane, DIFFERENCES + coordinate)
    }

    /// The smallest and the largest value of a coordinate in the rows that a motion and its companion both have.
    pub fn coordinate_range(&self, lane: usize, coordinate: usize) -> [f64; 2] {
        [1, 2].map(|kind| self.get(lane, DIFFERENCES + kind * self.layout.n + coordinate))
    }

    /// The smallest and the largest value of an output so far.
    pub fn range(&self, lane: usize, output: usize) -> [f64; 2] {
        let get = |place: usize| self.get(lane, place + output);
        let [low, high] = [get(self.layout.step_lowest()), get(self.layout.step_highest())];
        [get(self.layout.lowest()).min(low), get(self.layout.highest()).max(high)]
    }

    /// Whether all outputs of a lane were numbers so far.
    pub fn is_defined(&self, lane: usize) -> bool {
        self.get(lane, DEFINED) == 0.0
    }

    /// Begins the ranges of a lane with these outputs.
    pub fn begin_ranges(&mut self, lane: usize, outputs: &[f64]) {
        let outputs = &outputs[..self.layout.output_count.min(outputs.len())];
        self.set(lane, DEFINED, &[outputs.iter().map(|value| 0.0 * value).sum()]);
        self.set(lane, self.layout.lowest(), outputs);
        self.set(lane, self.layout.highest(), outputs);
        self.begin_step_ranges(lane, outputs);
    }

    /// Begins the ranges of a step of a lane with these outputs.
    fn begin_step_ranges(&mut self, lane: usize, outputs: &[f64]) {
        let outputs = &outputs[..self.layout.output_count.min(outputs.len())];
        self.set(lane, self.layout.step_lowest(), outputs);
        self.set(lane, self.layout.step_highest(), outputs);
    }

    /// Replaces the outputs of a lane in the row under way.
    pub fn set_outputs(&mut self, lane: usize, outputs: &[f64]) {
        self.set(lane, self.layout.outputs(), &outputs[..self.layout.output_count.min(outputs.len())]);
    }

    fn get(&self, lane: usize, place: usize) -> f64 {
        self.steps.get(place, lane)
    }

    /// Sets the numbers of a lane from a place on.
    fn set(&mut self, lane: usize, place: usize, numbers: &[f64]) {
        numbers.iter().enumerate().for_each(|(i, number)| self.steps.set(place + i, lane, *number));
    }

    fn read(&self, place: usize, lane: usize, row: &mut Vec<f64>) {
        row.clear();
        row.extend((0..self.layout.width()).map(|i| self.get(lane, place + i)));
    }
}
