//! The companion of a design: the same motion by a looser tolerance, whose difference is the error stated. Runs by
//! themselves have a companion of another kind (`run/companion.rs`).

use qrm_core::{CHECKPOINTS, Description};

use super::super::design::{DesignResult, with_end_time};
use super::{Lane, LaneSweep};
use crate::run::{Status, accepted_errors, rounding, worst};
use crate::solve::largest;
use crate::state::State;

/// The tolerance of a companion as a multiple of that of its design.
pub(super) const LOOSER: f64 = 100.0;

/// The longest step of a companion as a multiple of that of its design: where this bound is their length, steps differ
/// too.
pub(super) const LONGER: f64 = 1.5;

/// With fewer steps, the difference of a companion may be small by chance.
const FEW_STEPS: u64 = 32;
/// The estimate is then so many times the difference.
const CHANCE: f64 = 4.0;

/// The rounding error of a condition, in parts of its distance from true at the start.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// The comparison of a companion with its design.
pub(super) struct Companion {
    result: DesignResult,
    /// The design after the last two numbers of steps that are powers of two, where the companion is compared too: the
    /// later one first.
    checkpoints: [State; CHECKPOINTS],
    /// The smallest and the largest value of each coordinate.
    ranges: Vec<[f64; 2]>,
    /// The largest rate of change of a coordinate at both ends, as a multiple of its range.
    rate: f64,
    /// The largest difference of each coordinate so far.
    differences: Vec<f64>,
    /// The outputs at the end of the design.
    outputs: Vec<f64>,
}

impl LaneSweep<'_> {
    /// Lets a design that has come to its end wait for its companion.
    pub(super) fn await_companion(&mut self, lane: usize, result: DesignResult, at: &State) {
        let mut checkpoints: [State; CHECKPOINTS] = Default::default();
        for (age, checkpoint) in checkpoints.iter_mut().enumerate() {
            self.read(checkpoint, |batch, row| batch.read_checkpoint(age, lane, row));
        }
        let ranges = self.ranges(lane, at);
        let Some(Lane { design, first, bounds, .. }) = self.lanes[lane].take() else { return };
        let rate = rate(self.designs[design].description(), &ranges, [&first, at]);
        let differences = vec![0.0; self.size.0];
        let outputs = self.outputs(design, at);
        let companion = Some(Companion { result, checkpoints, ranges, rate, differences, outputs });
        self.waiting.push(Lane { companion, ..Lane::new(design, first, bounds, at.t) });
    }

    /// Takes up the end of a companion.
    pub(super) fn finish_companion(&mut self, lane: usize, at: &State) {
        let Some(Lane { design, companion: Some(companion), .. }) = &self.lanes[lane] else { return };
        let (design, Companion { result, ranges, differences, .. }) = (*design, companion);
        let tolerance = Some(LOOSER * self.request.settings.tolerance);
        let accepted = accepted_errors(self.designs[design].description(), ranges, tolerance, result.steps);
        let rounding_of_motion = rounding(largest(ranges.as_flattened()).1, result.steps);
        let errors: Vec<f64> = differences.iter().map(|difference| difference.max(rounding_of_motion)).collect();
        if worst(&errors, &accepted).is_some() {
            self.leave(lane);
            return;
        }
        let end_time_error = match result.status {
            Ok(Status::Stopped) => match self.end_time_error(lane, result, at) {
                None => return self.leave(lane),
                known => known,
            },
            _ => None,
        };
        let of_companion = self.outputs(design, at);
        let mut moved = at.moved_along(end_time_error.unwrap_or(0.0));
        let is_moved = self.solver.complete(&*self.designs[design], &mut moved).is_ok();
        let at_event = if is_moved { self.outputs(design, &moved) } else { of_companion.clone() };
        let Some(Lane { companion: Some(companion), .. }) = self.lanes[lane].take() else { return };
        let Companion { mut result, ranges, outputs, .. } = companion;
        let margin = if result.steps < FEW_STEPS { CHANCE } else { 1.0 };
        let relative = errors.iter().zip(&ranges).map(|(error, [low, high])| error / (high - low));
        let relative = relative.filter(|part| part.is_finite()).fold(0.0, f64::max);
        for (i, errors) in result.extreme_errors.iter_mut().enumerate() {
            let [low, high] = result.extremes[i];
            let of_motion = (outputs[i] - of_companion[i]).abs().max(relative * (high - low));
            let of_motion = margin * of_motion.max(rounding(low.abs().max(high.abs()), result.steps));
            let of_event = (at_event[i] - of_companion[i]).abs();
            let is_at_end = [low, high].map(|extreme| extreme == outputs[i]);
            *errors = [0, 1].map(|end| errors[end] + of_motion + if is_at_end[end] { of_event } else { 0.0 });
        }
        let estimated_error = Some(margin * with_end_time(&errors, &result.qd, end_time_error.unwrap_or(0.0)));
        let end_time_error = end_time_error.map(|error| margin * error);
        self.finished[design] = Some(DesignResult { estimated_error, end_time_error, ..result });
    }

    /// The error of the time at which a condition ended a design; `None` if it is not known.
    fn end_time_error(&self, lane: usize, result: &DesignResult, at: &State) -> Option<f64> {
        let (Lane { design, first, .. }, event) = (self.lanes[lane].as_ref()?, self.events.get(lane)?);
        let mechanism = &*self.designs[*design];
        event.set_parameters(mechanism);
        let end = State { q: result.q.clone(), qd: result.qd.clone(), ..at.clone() };
        let [at_start, end_value, other_value] = [first, &end, at].map(|at| event.value_at_position(mechanism, at));
        let rounding = ROUNDING * at_start?.abs();
        event.time_between(mechanism, [(&end, end_value?), (at, other_value?)], rounding, &[])
    }
}

impl Companion {
    /// The next time of a comparison with a checkpoint.
    pub(super) fn next_checkpoint(&self, t: f64) -> Option<f64> {
        self.checkpoints.iter().rev().map(|checkpoint| checkpoint.t).find(|next| *next > t)
    }

    /// Compares the companion with its design where both stand at the same time.
    ///
    /// A coordinate may agree by chance where its rate does not.
    pub(super) fn compare(&mut self, at: &State) {
        let (q, qd) = if at.t == self.result.end_time {
            (&self.result.q, &self.result.qd)
        } else if let Some(checkpoint) = self.checkpoints.iter().find(|checkpoint| at.t == checkpoint.t) {
            (&checkpoint.q, &checkpoint.qd)
        } else {
            return;
        };
        for (i, largest) in self.differences.iter_mut().enumerate() {
            let of_rate = (qd[i] - at.qd[i]).abs() / self.rate;
            *largest = largest.max((q[i] - at.q[i]).abs()).max(of_rate);
        }
    }
}

/// The largest `|qd|/range` and `sqrt(|qdd|/range)` of a coordinate in some states; the range of an angle counts as 1
/// at most.
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
