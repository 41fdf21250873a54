//! Designs by steps of order 8, each lane with a length of its own.

use std::convert::Infallible;

use qrm_core::{Description, LaneRole, LaneSchedule};

use super::super::sweep::{DesignResult, run_alone};
use super::{Lane, LaneSweep};
use crate::integrate::quintic;
use crate::run::{Status, accepted_errors, locate, rounding, worst};
use crate::solve::largest;
use crate::state::State;

/// The tolerance of a companion as a multiple of that of its design. The difference of the two is the error stated.
const LOOSER: f64 = 100.0;
/// The largest tolerance of a design: errors by longer steps do not follow the tolerance.
const LOOSEST: f64 = 3e-8;
/// Fewer steps may be the same for a design and its companion.
const FEWEST_STEPS: u64 = 10;
/// Longest change of time, as a part of the step, by which a state is moved along its Taylor series of order 2.
const NEAR: f64 = 1e-5;

/// The end of a design that its companion has still to come to.
pub(super) struct Main {
    result: DesignResult,
    /// The state after a number of steps that is a power of two, where it is compared first.
    checkpoint: State,
    /// The smallest and the largest value of each coordinate.
    ranges: Vec<[f64; 2]>,
    /// The largest rate of change of a coordinate at both ends, as a multiple of its range.
    rate: f64,
    /// The largest difference of each coordinate so far.
    differences: Vec<f64>,
}

impl LaneSweep<'_> {
    /// Lets a lane choose its steps from the beginning of its design on, by its tolerance or a looser one.
    pub(super) fn choose_steps(&mut self, lane: usize, looser: f64) {
        let Some(Lane { design, first, rows, .. }) = &self.lanes[lane] else { return };
        let settings = self.request.settings_of(*design);
        let tolerance = looser * settings.tolerance.min(LOOSEST);
        let rate = largest(&first.qd).1.max(largest(&first.qdd).1.sqrt()).max(1.0 / rows.end_time);
        self.batch.set_tolerance(lane, tolerance, settings.step_bounds.longest);
        let end_time = self.next_end(lane, first.t);
        self.batch.set_end(lane, end_time, tolerance.powf(0.125) / rate);
    }

    /// The next time that a step of a lane is to end at.
    fn next_end(&self, lane: usize, t: f64) -> f64 {
        let Some(Lane { design, rows, main, .. }) = &self.lanes[lane] else { return f64::INFINITY };
        let bound = self.request.settings_of(*design).step_bounds.next_end(t).min(rows.end_time);
        main.as_ref().map(|main| main.checkpoint.t).filter(|checkpoint| *checkpoint > t).map_or(bound, |t| bound.min(t))
    }

    /// Takes up a step of which not every lane can simply go on.
    pub(super) fn resolve_adaptive_step(&mut self) {
        for lane in 0..self.lanes.len() {
            let Some(Lane { design, is_landing, rows, main, .. }) = &self.lanes[lane] else { continue };
            if self.batch.goes_on(lane) {
                continue;
            }
            let (design, is_landing, end_time) = (*design, *is_landing, rows.end_time);
            if !self.batch.is_reliable(lane) {
                self.leave(lane);
                continue;
            }
            let is_companion = main.is_some();
            let to = self.state(|batch, row| batch.read_row(LaneRole::Main, lane, row));
            if let Some(Lane { main: Some(main), .. }) = &mut self.lanes[lane] {
                main.compare(&to);
            }
            let condition = self.condition(design, &to).filter(|_| !is_companion);
            match condition {
                Some(value) if value.is_nan() => self.leave(lane),
                Some(value) if is_landing || value >= 0.0 => self.stop(lane, design, (&to, value)),
                _ if to.t >= end_time && is_companion => self.finish_companion(lane),
                // Where a stop was not reached, a run of its own tells how near it came.
                Some(_) if to.t >= end_time => self.leave(lane),
                None if to.t >= end_time => self.finish_main(lane, Status::Completed, &to),
                _ if self.batch.stands_still(lane) => self.leave(lane),
                _ => {
                    let (end_time, step) = (self.next_end(lane, to.t), self.batch.next_step(lane));
                    self.batch.set_end(lane, end_time, step);
                }
            }
        }
    }

    /// Ends a design where its stop condition becomes true, at the end of a step or near it.
    fn stop(&mut self, lane: usize, design: usize, (to, value): (&State, f64)) {
        let from = self.state(|batch, row| batch.read_row_before(lane, row));
        let h = to.t - from.t;
        let condition = |at: &State| self.condition(design, at).unwrap_or(f64::NAN);
        let dt = zero(value, NEAR * h, |dt| condition(&along(to, dt)));
        if dt.abs() <= NEAR * h {
            self.finish_main(lane, Status::Stopped, &along(to, dt));
            return;
        }
        // The step is made again, to the time at which its polynomial meets the condition.
        let (begin, end_time) = if value >= 0.0 {
            let Ok(at) = locate(&from, to, condition, |t| Ok::<_, Infallible>(quintic(&from, to, t)));
            from.write(&mut self.row);
            let outputs = self.outputs(design, &from);
            self.batch.take_back(lane, &self.row, &outputs);
            (from.t, at.t)
        } else {
            (to.t, to.t + dt)
        };
        if !(end_time > begin) {
            self.leave(lane);
            return;
        }
        self.batch.set_end(lane, end_time, end_time - begin);
        if let Some(lane) = &mut self.lanes[lane] {
            lane.is_landing = true;
        }
    }

    /// Takes up the end of a design, and begins with its companion.
    fn finish_main(&mut self, lane: usize, status: Status, at: &State) {
        let checkpoint = self.state(|batch, row| batch.read_row(LaneRole::Companion, lane, row));
        let Some(Lane { design, first, rows, .. }) = &self.lanes[lane] else { return };
        let (design, mut rows) = (*design, *rows);
        let has_few_steps = self.request.estimate_error && self.batch.steps(lane) < FEWEST_STEPS;
        if has_few_steps || !self.batch.is_defined(lane) || !self.is_balanced(design, first, at) {
            self.leave(lane);
            return;
        }
        let result = self.result(lane, design, status, at);
        if !self.request.estimate_error {
            self.lanes[lane] = None;
            self.wants_refill = true;
            self.finished[design] = Some(result);
            return;
        }
        let ranges = self.ranges(lane, at);
        let rate = rate(self.designs[design].description(), &ranges, [first, at]);
        let main = Main { result, checkpoint, ranges, rate, differences: vec![0.0; self.size.0] };
        rows.end_time = at.t;
        let first = first.clone();
        first.write(&mut self.row);
        self.batch.place(lane, &self.row, &LaneSchedule { step: 0.0, last: f64::INFINITY, end_time: at.t });
        self.lanes[lane] = Some(Lane { design, rows, first, has_companion: true, is_landing: false, main: Some(main) });
        self.choose_steps(lane, LOOSER);
    }

    /// Takes up the end of a companion.
    fn finish_companion(&mut self, lane: usize) {
        let Some(Lane { design, main: Some(main), .. }) = &self.lanes[lane] else { return };
        let (design, Main { result, ranges, differences, .. }) = (*design, main);
        let description = self.designs[design].description();
        let tolerance = Some(LOOSER * self.request.settings.tolerance);
        let accepted = accepted_errors(description, ranges, tolerance, result.steps);
        let rounding = rounding(largest(ranges.as_flattened()).1, result.steps);
        let errors: Vec<f64> = differences.iter().map(|difference| difference.max(rounding)).collect();
        if worst(&errors, &accepted).is_some() {
            self.leave(lane);
            return;
        }
        let Some(Lane { main: Some(main), .. }) = self.lanes[lane].take() else { return };
        self.wants_refill = true;
        self.finished[design] = Some(DesignResult { estimated_error: Some(largest(&errors).1), ..main.result });
    }

    /// Lets a design leave its lane for a run of its own, which tells when and what went wrong.
    fn leave(&mut self, lane: usize) {
        let Some(Lane { design, .. }) = self.lanes[lane].take() else { return };
        self.wants_refill = true;
        self.finished[design] = Some(run_alone(design, &*self.designs[design], self.request));
    }
}

impl Main {
    /// Compares its companion with the design where both stand at the same time.
    ///
    /// A coordinate may agree by chance where its rate does not.
    fn compare(&mut self, companion: &State) {
        let (q, qd) = if companion.t == self.checkpoint.t {
            (&self.checkpoint.q, &self.checkpoint.qd)
        } else if companion.t == self.result.end_time {
            (&self.result.q, &self.result.qd)
        } else {
            return;
        };
        for (i, largest) in self.differences.iter_mut().enumerate() {
            let of_rate = (qd[i] - companion.qd[i]).abs() / self.rate;
            *largest = largest.max((q[i] - companion.q[i]).abs()).max(of_rate);
        }
    }
}

/// The largest rate of change of a coordinate in some states, as a multiple of its range, or of an angle up to 1.
fn rate<const K: usize>(description: &Description, ranges: &[[f64; 2]], states: [&State; K]) -> f64 {
    let mut rate = f64::MIN_POSITIVE;
    for (i, [low, high]) in ranges.iter().enumerate() {
        let range = if description.is_angle(i) { (high - low).min(1.0) } else { high - low };
        if range > 0.0 {
            for state in states {
                rate = rate.max(state.qd[i].abs() / range).max((state.qdd[i].abs() / range).sqrt());
            }
        }
    }
    rate
}

/// A state along its Taylor series of order 2.
fn along(from: &State, dt: f64) -> State {
    let mut at = from.clone();
    at.t += dt;
    for i in 0..at.q.len() {
        at.q[i] += dt * (from.qd[i] + 0.5 * dt * from.qdd[i]);
        at.qd[i] += dt * from.qdd[i];
    }
    at
}

/// The zero of a function near zero, where it has the given value, by the secant method from a distance on.
fn zero(value: f64, distance: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut x, mut f_x) = (0.0, value);
    let (mut other, mut f_other) = (-distance, f(-distance));
    for _ in 0..4 {
        let next = x - f_x * (x - other) / (f_x - f_other);
        if !next.is_finite() {
            break;
        }
        (other, f_other) = (x, f_x);
        (x, f_x) = (next, f(next));
    }
    x
}
