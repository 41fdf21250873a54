//! The condition that ends a run.

use qrm_core::{Mechanism, RowLayout};

use super::outcome::{StartError, Status};
use crate::event::location::{Approach, PARTS, first_inside, locate, slope, time_to_event};
use crate::event::{End, EventFunction};
use crate::integrate::{Integrator, StepError};
use crate::state::State;

/// The part of the time over which the slope of a condition is taken.
const SHIFT: f64 = 1e-7;
/// The part of the time within which the jump of a condition is looked for in another motion.
const LONGEST: f64 = 1e-3;

/// The condition that ends a run, a function that rises through zero, and where it was nearest to true.
pub(super) struct StopCondition<'a> {
    mechanism: &'a dyn Mechanism,
    layout: RowLayout,
    function: EventFunction<'a>,
    approach: Approach,
    /// The time at which the condition was nearest to true, and its value there.
    nearest: (f64, f64),
}

/// A state that the condition is evaluated at.
#[derive(Clone, Copy)]
enum Sample {
    /// A row of the block.
    Row(usize),
    /// A state between rows.
    Inner(usize),
}

impl<'a> StopCondition<'a> {
    /// Begins with a run; `None` if it ends at a time.
    ///
    /// # Errors
    /// The condition is true or undefined at the start.
    pub(super) fn new(
        mechanism: &'a dyn Mechanism,
        end: Option<End<'a>>,
        first: &State,
    ) -> Result<Option<Self>, StartError> {
        let Some(function) = EventFunction::new(mechanism, end) else { return Ok(None) };
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let value = function.value(mechanism, first);
        check_condition(value)?;
        let Some(value) = value else { return Ok(None) };
        Ok(Some(Self { mechanism, layout, function, approach: Approach::new(value), nearest: (first.t, value) }))
    }

    /// The largest value of the stop condition so far, from the start of the run on.
    pub(super) fn nearest(&self) -> f64 {
        self.nearest.1
    }

    /// The distance from true (negative); `None` if neither the run nor the scene has a condition.
    fn value(&self, at: &State) -> Option<f64> {
        self.function.value(self.mechanism, at)
    }

    /// The distance from true at a state that was moved, with accelerations and multipliers of another one.
    fn moved_value(&self, at: &State) -> Option<f64> {
        self.function.value_at_position(self.mechanism, at)
    }

    /// Writes the values of a condition of the run into rows after the first; the first row at which it is not false.
    pub(super) fn write(&self, rows: &mut [f64]) -> Option<usize> {
        if !self.function.is_of_request() {
            return None;
        }
        let mut at = State::zero(self.layout.n, self.layout.m);
        for (number, row) in rows.chunks_exact_mut(self.layout.width()).enumerate().skip(1) {
            at.read(row);
            let value = self.value(&at)?;
            row[self.layout.event()] = value;
            if !(value < 0.0) {
                return Some(number);
            }
        }
        None
    }

    /// Looks where it is nearest to true in rows after the first.
    pub(super) fn note(&mut self, rows: &[f64]) {
        for row in rows.chunks_exact(self.layout.width()).skip(1) {
            let value = row[self.layout.event()];
            if value > self.nearest.1 {
                self.nearest = (row[0], value);
            }
        }
    }

    /// The end of a run in which it did not become true.
    pub(super) fn not_reached(&self) -> Status {
        let (nearest_time, nearest) = self.nearest;
        Status::StopNotReached { nearest_time, missing: -nearest }
    }

    /// The time between the events of two motions: one ended there, and the other one is `other` at that time.
    pub(super) fn time_between(&self, end: &State, other: &State) -> Option<f64> {
        let [own_value, other_value] = [self.value(end)?, self.value(other)?];
        let moved_value = &mut |at: &State| self.moved_value(at);
        let slope = slope(end, SHIFT * end.t.abs().max(f64::MIN_POSITIVE), moved_value)?;
        let time = (other_value - own_value).abs() / slope.abs();
        if time.is_finite() && slope != 0.0 {
            return Some(time);
        }
        // The condition jumps, or stays as it is.
        let longest = LONGEST * end.t.abs();
        Some((time_to_event(other, longest, moved_value)? - time_to_event(end, longest, moved_value)?).abs())
    }

    /// The first row before which the condition was true inside the step, though it is true in no row before; the row
    /// becomes the state where it was found true.
    pub(super) fn first_crossing(&mut self, integrator: &mut Integrator, rows: &mut [f64]) -> Option<usize> {
        let (width, event) = (self.layout.width(), self.layout.event());
        let made = rows.len() / width - 1;
        let (mut row, mut inner) = (1, 0);
        // The last sample, a row or a state between rows.
        let (mut last, mut is_false) = (Sample::Row(0), rows[event] < 0.0);
        while row <= made && is_false {
            let is_inner = integrator.inner_row(inner).is_some_and(|at| at[0] < rows[row * width]);
            let sample = if is_inner { Sample::Inner(inner) } else { Sample::Row(row) };
            let state = |integrator: &Integrator, sample: Sample| match sample {
                Sample::Row(row) => State::from_row(self.layout, &rows[row * width..]),
                Sample::Inner(inner) => State::from_row(self.layout, integrator.inner_row(inner).unwrap_or_default()),
            };
            let value = match sample {
                Sample::Row(row) => rows[row * width + event],
                Sample::Inner(_) => self.value(&state(integrator, sample)).unwrap_or(-1.0),
            };
            let may_have_touched = self.approach.may_have_touched(value);
            let found = if value >= 0.0 {
                // A row where the condition is true is found without help.
                is_inner.then(|| state(integrator, sample))
            } else if may_have_touched {
                let [from, to] = [last, sample].map(|sample| state(integrator, sample));
                self.first_inside(integrator, [&from, &to])
            } else {
                None
            };
            if let Some(found) = found {
                found.write(&mut rows[row * width..]);
                rows[row * width + event] = 0.0;
                return Some(row);
            }
            (last, is_false) = (sample, value < 0.0);
            if is_inner { inner += 1 } else { row += 1 }
        }
        None
    }

    /// The state at which the condition is true between two states at which it is not.
    fn first_inside(&self, integrator: &mut Integrator, [from, to]: [&State; 2]) -> Option<State> {
        // Fixed steps are short where they are accurate.
        let parts = if integrator.is_fixed() { 1 } else { PARTS };
        let value = &mut |at: &State| self.moved_value(at);
        let found = first_inside([from, to], parts, value, &mut |t| integrator.between(self.mechanism, from, t).ok())?;
        self.value(&found).is_some_and(|value| value >= 0.0).then_some(found)
    }

    /// The state at which it becomes true in the step between the last two of some rows.
    ///
    /// # Errors
    /// A step could not be made.
    pub(super) fn locate(&self, integrator: &mut Integrator, rows: &[f64]) -> Result<State, StepError> {
        let width = self.layout.width();
        let [from, beyond] = [2, 1].map(|back| State::from_row(self.layout, &rows[rows.len() - back * width..]));
        let value = |at: &State| self.value(at).unwrap_or(0.0);
        locate(&from, &beyond, &mut { value }, &mut |t| integrator.between(self.mechanism, &from, t))
    }
}

/// An error for a stop condition that is true or undefined at the start.
pub(crate) fn check_condition(value: Option<f64>) -> Result<(), StartError> {
    match value {
        Some(value) if !value.is_finite() => Err(StartError::ConditionNotFinite),
        Some(value) if value >= 0.0 => Err(StartError::ConditionHolds),
        _ => Ok(()),
    }
}
