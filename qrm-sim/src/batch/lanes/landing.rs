//! The end of a design in a lane where its stop condition becomes true.

use std::convert::Infallible;

use qrm_core::LaneSchedule;

use super::{Lane, LaneSweep};
use crate::event::location::locate;
use crate::event::{Largest, Reached};
use crate::integrate::{Integrator, quintic};
use crate::run::Status;
use crate::state::State;

/// Longest change of time, as a part of the step, by which a state is moved along its Taylor series of order 2.
const NEAR: f64 = 1e-5;
/// The time by which a step may pass the condition, in parts of the time: extremes count states up to there.
const LATE: f64 = 16.0 * f64::EPSILON;
/// The part of that within which a condition must have become true for the end to be accepted.
const RESOLUTION: f64 = 1e-5;

/// A design with more steps towards its condition runs by itself: the condition may only come near its bound.
const MOST_LANDINGS: u32 = 20;

impl LaneSweep<'_> {
    /// Ends a design where its stop condition becomes true, near the end of a step; or makes a step to there.
    pub(super) fn land(&mut self, lane: usize, to: &State, value: f64) {
        let (mut from, mut near) = (std::mem::take(&mut self.from), std::mem::take(&mut self.near));
        self.read(&mut from, |batch, row| batch.read_row_before(lane, row));
        near.clone_from(to);
        self.land_between(lane, (&from, to, value), &mut near);
        (self.from, self.near) = (from, near);
    }

    fn land_between(&mut self, lane: usize, (from, to, value): (&State, &State, f64), at: &mut State) {
        let h = to.t - from.t;
        if !(h > 0.0) {
            return self.leave(lane);
        }
        let near = NEAR * h;
        let mut condition = |dt: f64| {
            at.clone_from(to);
            at.move_along(dt);
            self.condition_value(lane, at)
        };
        let dt = zero(value, near, &mut condition);
        // Times differ by no less than rounding errors.
        let resolution = (RESOLUTION * near).max(0.25 * LATE * to.t.abs());
        let [before, after] = [dt - resolution, dt + resolution];
        if dt.abs() <= near && condition(before) < 0.0 && condition(after) >= 0.0 {
            if dt < -LATE * to.t.abs() {
                return self.step_again(lane, from, to);
            }
            at.clone_from(to);
            at.move_along(dt);
            return self.finish(lane, Status::Stopped, at);
        }
        // The condition jumps, or stays as it is, or is farther away.
        let other = if value >= 0.0 { -near } else { near };
        if (condition(other) >= 0.0) != (value >= 0.0) {
            let other = to.moved_along(other);
            let ends = if value >= 0.0 { [&other, to] } else { [to, &other] };
            let mut value = |at: &State| self.condition_value(lane, at);
            let Ok(end) = locate(ends[0], ends[1], &mut value, &mut |t| Ok::<_, Infallible>(to.moved_along(t - to.t)));
            if end.t < to.t - LATE * to.t.abs() {
                return self.step_again(lane, from, to);
            }
            return self.finish(lane, Status::Stopped, &end);
        }
        if value >= 0.0 {
            self.step_again(lane, from, to)
        } else if dt > 0.0 && dt <= h {
            self.step_on(lane, to.t, to.t + dt)
        } else {
            // It became true for a short time only, or nearly.
            self.leave(lane)
        }
    }

    /// Makes the last step of a lane again if the stop condition becomes true inside it; returns whether it does.
    pub(super) fn land_inside(&mut self, lane: usize, to: &State) -> bool {
        let mut from = std::mem::take(&mut self.from);
        self.read(&mut from, |batch, row| batch.read_row_before(lane, row));
        let reached = self.reached_inside(lane, [&from, to]);
        match &reached {
            Some(Inside::BecomesTrue(at)) => self.step_again(lane, &from, at),
            Some(Inside::ComesNear) => self.leave(lane),
            None => {}
        }
        self.from = from;
        reached.is_some()
    }

    /// Whether the stop condition of a lane becomes true inside its last step.
    fn reached_inside(&self, lane: usize, [from, to]: [&State; 2]) -> Option<Inside> {
        let (of_lane, event) = (self.lanes[lane].as_ref()?, self.events.get(lane)?);
        let mechanism = &*self.designs[of_lane.design];
        if !event.may_come_near_zero(mechanism, [from, to]) {
            return None;
        }
        let settings = self.request.settings;
        let at = &mut |t: f64| {
            let mut at = from.clone();
            let mut integrator = Integrator::new(mechanism, settings, from, to.t).ok()?;
            integrator.advance(mechanism, from, t, &mut at).ok()?;
            Some(at)
        };
        match event.first_inside(mechanism, [from, to], at) {
            Some(Reached::Crossed(at)) => Some(Inside::BecomesTrue(at)),
            Some(_) => Some(Inside::ComesNear),
            None => {
                let Largest { t, .. } = event.largest_inside(mechanism, [from, to], at)?;
                let largest = at(t)?;
                event.is_near_zero(mechanism, &largest).then_some(Inside::ComesNear)
            }
        }
    }

    /// Makes the last step of a lane again, to the time at which a polynomial through its begin and a later state meets
    /// the condition.
    fn step_again(&mut self, lane: usize, from: &State, to: &State) {
        let Some(design) = self.lanes[lane].as_ref().map(|lane| lane.design) else { return };
        let mut condition = |at: &State| self.condition_value(lane, at);
        let Ok(at) = locate(from, to, &mut condition, &mut |t| Ok::<_, Infallible>(quintic(from, to, t)));
        from.write(&mut self.row);
        let outputs = self.outputs(design, from);
        self.batch.undo_last_step(lane, &self.row, &outputs);
        // From a little before the condition on, the motion is that of its Taylor series.
        self.step_on(lane, from.t, at.t - 0.5 * NEAR * (at.t - from.t));
    }

    /// Makes a step that is to end where the condition becomes true.
    fn step_on(&mut self, lane: usize, begin: f64, end_time: f64) {
        let Some(Lane { is_landing, landings, .. }) = &mut self.lanes[lane] else { return };
        (*is_landing, *landings) = (true, *landings + 1);
        if !(end_time > begin) || *landings > MOST_LANDINGS {
            return self.leave(lane);
        }
        let schedule = self.batch.schedule(lane);
        self.batch.set_schedule(lane, &LaneSchedule { end_time, step: end_time - begin, ..schedule });
    }

    /// The value of the stop condition of a lane, negative until it is true, where accelerations and multipliers are
    /// not known; not a number without one.
    fn condition_value(&self, lane: usize, at: &State) -> f64 {
        let Some(Lane { design, .. }) = &self.lanes[lane] else { return f64::NAN };
        let event = self.events.get(lane);
        event.and_then(|event| event.value_at_position(&*self.designs[*design], at)).unwrap_or(f64::NAN)
    }
}

/// The behaviour of the stop condition inside a step of a lane.
enum Inside {
    /// It becomes true before this state.
    BecomesTrue(State),
    /// It comes near its bound: the design leaves the lanes.
    ComesNear,
}

/// The zero of a function near zero, where it has the given value, by the secant method from a distance on. It may not
/// have converged.
fn zero(value: f64, distance: f64, f: &mut impl FnMut(f64) -> f64) -> f64 {
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
