//! The condition that ends a run.

use qrm_core::{Mechanism, RowLayout};

use super::companion::state_of_companion;
use super::error_estimate::ErrorEstimates;
use super::outcome::{StartError, Status};
use crate::event::location::locate;
use crate::event::{End, EventFunction, Largest, Maximum, POSSIBLE, Reached};
use crate::integrate::{Corner, Integrator, MethodSettings, StepError};
use crate::solve::IRREGULAR;
use crate::state::State;

/// The rounding error of a condition, in parts of its distance from true at the start.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The condition that ends a run, a function that rises through zero, and where it was nearest to true.
pub(super) struct StopCondition<'a> {
    mechanism: &'a dyn Mechanism,
    layout: RowLayout,
    function: EventFunction<'a>,
    /// The time at which the condition was nearest to true, and its value there.
    nearest: (f64, f64),
    /// Its distance from true at the start.
    at_start: f64,
    start: State,
    /// The state between rows at which it was nearest to true, and its value there.
    maximum_between: Option<(State, f64)>,
    /// The samples before the last row.
    before: Vec<f64>,
    /// The maximum by which it became true, if it does not cross zero there.
    maximum: Option<Maximum>,
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
        let Some(mut function) = EventFunction::new(mechanism, end) else { return Ok(None) };
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let value = function.value(mechanism, first);
        check_condition(value)?;
        let Some(value) = value else { return Ok(None) };
        function.set_start(value);
        Ok(Some(Self {
            mechanism,
            layout,
            function,
            nearest: (first.t, value),
            at_start: value.abs(),
            start: first.clone(),
            maximum_between: None,
            before: Vec::new(),
            maximum: None,
        }))
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
    pub(super) fn write(&self, integrator: &mut Integrator, rows: &mut [f64]) -> Option<usize> {
        if !self.function.is_of_request() {
            return None;
        }
        let mut at = State::zero(self.layout.n, self.layout.m);
        for (number, row) in rows.chunks_exact_mut(self.layout.width()).enumerate().skip(1) {
            at.read(row);
            self.refine(integrator, &mut at);
            let value = self.value(&at)?;
            row[self.layout.event()] = value;
            if !(value < 0.0) {
                return Some(number);
            }
        }
        None
    }

    /// Solves for a state near a singular position in all digits, if the condition takes forces.
    fn refine(&self, integrator: &mut Integrator, state: &mut State) {
        if cfg!(feature = "events") && self.function.takes_forces() {
            integrator.solver_mut().refine(self.mechanism, IRREGULAR, state);
        }
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

    /// Looks where it is nearest to true in a step in which no crossing was found; the state, if it is true there.
    fn largest_between(&mut self, ends: [&State; 2], at: &mut dyn FnMut(f64) -> Option<State>) -> Option<Reached> {
        if !cfg!(feature = "events") {
            return None;
        }
        let Largest { t, value, half_curvature } = self.function.largest_inside(self.mechanism, ends, at)?;
        if value <= self.nearest.1 {
            return None;
        }
        let state = at(t)?;
        self.nearest = (t, value);
        let rounding = ROUNDING * self.at_start;
        if value > rounding {
            return Some(Reached::Crossed(state));
        }
        if value >= 0.0 {
            return Some(Reached::Touched(state, Some(Maximum { rounding, half_curvature })));
        }
        self.maximum_between = Some((state, value));
        None
    }

    /// The time at which it may have become true before the end of the run, within errors of the motion, and its
    /// distance from true there.
    pub(super) fn undecided(&self, errors: Option<&ErrorEstimates>, settings: &MethodSettings) -> Option<(f64, f64)> {
        if !cfg!(feature = "events") {
            return None;
        }
        let (state, largest) = self.maximum_between.as_ref()?;
        let missing = -largest;
        // An uncertainty that is not known decides nothing.
        let uncertainty = self.uncertainty(state, *largest, errors, settings);
        let is_short = uncertainty.is_some_and(|uncertainty| missing > uncertainty);
        (!is_short).then_some((state.t, missing))
    }

    /// The error of a value of the condition at a state of the motion; `None` if it is not known.
    fn uncertainty(
        &self,
        state: &State,
        value: f64,
        errors: Option<&ErrorEstimates>,
        settings: &MethodSettings,
    ) -> Option<f64> {
        let n = self.layout.n;
        let mut uncertainty = ROUNDING * self.at_start;
        for (i, error) in errors.map_or(&[][..], |errors| &errors.largest[..2 * n]).iter().enumerate() {
            let mut other = state.clone();
            let number = if i < n { &mut other.q[i] } else { &mut other.qd[i - n] };
            *number += POSSIBLE * error;
            uncertainty += (self.moved_value(&other)? - value).abs();
        }
        // Few rows may tell little of the errors between them.
        if errors.is_some() && settings.method.is_adaptive() {
            let other = state_of_companion(self.mechanism, settings, &self.start, state.t)?;
            uncertainty += POSSIBLE * (self.moved_value(&other)? - value).abs();
        }
        Some(uncertainty)
    }

    /// The end of a run in which it did not become true.
    pub(super) fn not_reached(&self) -> Status {
        let (nearest_time, nearest) = self.nearest;
        Status::StopNotReached { nearest_time, missing: -nearest }
    }

    /// The time between the events of two motions: one ended there, and the other one is `other` at that time. Their
    /// coordinates and rates differ by `floors` at least.
    pub(super) fn time_between(&self, end: &State, other: &State, floors: &[f64]) -> Option<f64> {
        let [own_value, other_value] = [self.value(end)?, self.value(other)?];
        if let Some(maximum) = self.maximum {
            return Some(maximum.time_to_fall((other_value - own_value).abs()));
        }
        self.function.time_between(self.mechanism, [(end, own_value), (other, other_value)], 0.0, floors)
    }

    /// The error of the time at which it became true that its rounding error causes; `None` if it is not known.
    pub(super) fn rounding_of_time(&self, end: &State) -> Option<f64> {
        if let Some(maximum) = self.maximum {
            return Some(maximum.time_to_fall(0.0));
        }
        let (at_end, rounding) = ((end, self.value(end)?), self.function.rounding(self.mechanism, end));
        let of_value = self.function.time_between(self.mechanism, [at_end; 2], rounding, &[])?;
        let of_corner = if self.mechanism.description().has_corners { Corner::resolution(end.t) } else { 0.0 };
        Some(of_value.max(of_corner))
    }

    /// Finds where the condition first becomes true in rows, and the number of the row after that. It is false in the
    /// first row.
    ///
    /// # Errors
    /// A step could not be made.
    pub(super) fn first_reached(
        &mut self,
        integrator: &mut Integrator,
        rows: &[f64],
    ) -> Result<Option<(usize, Reached)>, StepError> {
        let width = self.layout.width();
        let before = std::mem::take(&mut self.before);
        let samples = samples([&before, rows], integrator.inner_rows(), width);
        let (first, last) = (before.len() / width, samples.len() - 1);
        let mut steps = self.function.undecided_steps(self.mechanism, &samples, first);
        let is_true_at_last = samples[last][self.layout.event()] >= 0.0;
        if is_true_at_last && steps.last() != Some(&(last - 1)) {
            steps.push(last - 1);
        }
        self.before = samples[last.saturating_sub(2)..last].concat();
        let state = |sample: usize| State::from_row(self.layout, samples[sample]);
        let mut steps: Vec<[State; 2]> = steps.into_iter().map(|step| [state(step), state(step + 1)]).collect();
        steps.iter_mut().flatten().for_each(|state| self.refine(integrator, state));
        let mut found = None;
        for (number, [from, to]) in steps.iter().enumerate() {
            let at = &mut |t: f64| integrator.between(self.mechanism, from, t).ok();
            let reached = self.function.first_inside(self.mechanism, [from, to], at);
            let reached = reached.or_else(|| self.largest_between([from, to], at));
            let is_last = is_true_at_last && number + 1 == steps.len();
            // It is true in the last row, and no crossing was found before.
            found =
                reached.or_else(|| is_last.then(|| Reached::Crossed(to.clone()))).map(|reached| (reached, from, to));
            if found.is_some() {
                break;
            }
        }
        let Some((reached, from, to)) = found else { return Ok(None) };
        if let Reached::Touched(_, maximum) = &reached {
            self.maximum = *maximum;
        }
        let reached = match reached {
            Reached::Crossed(beyond) => {
                let mut value = |at: &State| self.value(at).unwrap_or(0.0);
                let between = &mut |t: f64| integrator.between(self.mechanism, from, t);
                Reached::Crossed(locate(from, &beyond, &mut value, between)?)
            }
            other => other,
        };
        let row = rows.chunks_exact(width).position(|row| row[0] >= to.t);
        Ok(Some((row.unwrap_or(rows.len() / width - 1), reached)))
    }
}

/// Rows of earlier blocks, and rows and the states between them, in the order of time.
fn samples<'r>([before, rows]: [&'r [f64]; 2], inner: &'r [f64], width: usize) -> Vec<&'r [f64]> {
    let mut inner = inner.chunks_exact(width).peekable();
    let mut samples = Vec::with_capacity((before.len() + rows.len()) / width);
    samples.extend(before.chunks_exact(width));
    for row in rows.chunks_exact(width) {
        while let Some(state) = inner.next_if(|state| state[0] < row[0]) {
            samples.push(state);
        }
        samples.push(row);
    }
    samples
}

/// An error for a stop condition that is true or undefined at the start.
pub(crate) fn check_condition(value: Option<f64>) -> Result<(), StartError> {
    match value {
        Some(value) if !value.is_finite() => Err(StartError::ConditionNotFinite),
        Some(value) if value >= 0.0 => Err(StartError::ConditionHolds),
        _ => Ok(()),
    }
}
