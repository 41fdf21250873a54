//! A motion with its derivatives by parameters.

use std::collections::VecDeque;

use qrm_core::{Mechanism, ParameterOverrides, RowRequest, Scalar, Tape};

use super::SensitivityRequest;
use super::columns::Columns;
use super::equations::DualState;
use super::error::SensitivityError;
use super::event::DualEvent;
use super::mesh::{Mesh, MeshStep};
use super::number::{Inner, Number, differentiated};
use super::result::Motion;
use super::start::start;
use super::stepper::DualStepper;
use crate::bounds::Resolution;
use crate::event::End;
use crate::integrate::Formula;
use crate::run::{StartError, check_condition, check_step};

/// The rows that are kept: an extreme is found between the last ones.
const ROWS: usize = 5;

/// The motion on dual numbers, by the steps of an ordinary run.
pub(super) struct DualRun<'a, T: Inner> {
    stepper: DualStepper<'a, T>,
    mesh: Mesh<'a>,
    event: Option<DualEvent<'a, T>>,
    rows: RowRequest,
    /// The end of the rows, and its derivatives.
    end_time: Number<T>,
    state: DualState<T>,
    /// The times of the last rows.
    last_rows: VecDeque<f64>,
    /// The states at the ends of the steps since the first of these.
    last_states: VecDeque<DualState<T>>,
    columns: Columns<T>,
    resolution: Resolution,
    /// The number of steps so far.
    steps: u64,
    keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
}

impl<'a, T: Inner> DualRun<'a, T> {
    /// The motion at its start, by the steps of the method or by steps half as long.
    ///
    /// # Errors
    /// It cannot begin, or there is no such parameter.
    pub(super) fn new(
        mechanism: &'a dyn Mechanism,
        tape: &'a Tape,
        replace: ParameterOverrides,
        parameters: &'a [&'a str],
        request: &'a SensitivityRequest<'a>,
        is_halved: bool,
    ) -> Result<Self, SensitivityError> {
        let mut stepper = DualStepper::new(mechanism, tape, parameters.len(), request);
        seed(&mut stepper, replace, parameters, request.direction)?;
        let schedule = stepper.equations.evaluator.schedule();
        let end_time = match request.end {
            Some(End::Time(t)) => Number::from_f64(t),
            _ => schedule.end_time,
        };
        let rows = RowRequest {
            origin: 0.0,
            step: request.step.unwrap_or(schedule.step.to_f64()),
            end_time: end_time.to_f64(),
            first: 0,
            residual: request.settings.projection_tolerance.residual,
            watches_event: false,
        };
        check_step(rows.step, rows.end_time).map_err(SensitivityError::Start)?;
        let state = start(&mut stepper.equations)?;
        let mesh = Mesh::new(mechanism, request.settings, &state.real(), rows.end_time, is_halved);
        let mesh = mesh.map_err(|error| SensitivityError::Start(StartError::Step(error)))?;
        let event = DualEvent::new(&stepper, request.end);
        let columns = Columns::new(mechanism.description().outputs.len());
        let resolution = Resolution::new(mechanism, request.outputs, if is_halved { 0.25 } else { 1.0 });
        Ok(Self {
            stepper,
            mesh,
            event,
            rows,
            end_time,
            last_rows: VecDeque::new(),
            last_states: VecDeque::from([state.clone()]),
            state,
            columns,
            resolution,
            steps: 0,
            keep_running: request.keep_running,
        })
    }

    /// Follows the motion to its end.
    ///
    /// # Errors
    /// It does not come to its end, has no derivative, or is interrupted.
    pub(super) fn run(mut self) -> Result<Motion<T>, SensitivityError> {
        self.take_row(Formula::fixed())?;
        let value = self.event_value(&self.state.clone());
        check_condition(value).map_err(SensitivityError::Start)?;
        let mut row = 0;
        loop {
            row += 1;
            let steps = self.mesh.steps_to(self.rows.time(row));
            let t = self.state.t.to_f64();
            for step in steps.map_err(|error| SensitivityError::Step { t, error })? {
                if self.make(&step)? {
                    return self.finish(step.formula);
                }
            }
            let t = self.state.t.to_f64();
            if self.keep_running.is_some_and(|keep_running| !keep_running(t, self.rows.end_time)) {
                return Err(SensitivityError::Interrupted { t });
            }
        }
    }

    /// The value of the event that ends the motion, if there is one.
    fn event_value(&mut self, at: &DualState<T>) -> Option<f64> {
        self.event.as_mut()?.value(at).map(Scalar::to_f64)
    }

    /// Makes a step; whether the motion is over.
    fn make(&mut self, step: &MeshStep) -> Result<bool, SensitivityError> {
        let is_at_end = step.end >= self.rows.end_time;
        let end = if is_at_end { self.end_time } else { Number::from_f64(step.end) };
        let mut next = self.stepper.advance(step.formula, &self.state, end)?;
        let value = self.event_value(&next);
        if value.is_some_and(f64::is_nan) {
            return Err(SensitivityError::NotSmooth { t: self.state.t.to_f64() });
        }
        let mut is_at_event = false;
        if let Some(event) = &mut self.event
            && let Some(at_event) = event.locate_first(&mut self.stepper, step.formula, [&self.state, &next])?
        {
            (next, is_at_event) = (at_event, true);
        } else if is_at_end && value.is_some() {
            return Err(SensitivityError::EventNotReached { end_time: self.rows.end_time });
        }
        self.last_states.push_back(next.clone());
        self.state = next;
        self.steps += 1;
        if step.is_row || is_at_event {
            self.take_row(step.formula)?;
        }
        Ok(is_at_end || is_at_event)
    }

    /// Takes the state as a row, and looks for extremes between the last rows. Where an output changes fast, rows between
    /// are taken too.
    fn take_row(&mut self, formula: Formula) -> Result<(), SensitivityError> {
        if !self.resolution.is_needed() {
            return self.add_row(formula, &self.state.clone());
        }
        let outputs = self.stepper.equations.outputs(&self.state)?.into_iter().map(Scalar::to_f64).collect();
        let times = self.resolution.times(self.stepper.equations.mechanism, &[(self.state.real(), outputs)])?;
        for t in times {
            let between = state_at(&mut self.stepper, formula, &self.last_states, t)?;
            self.add_row(formula, &between)?;
        }
        self.add_row(formula, &self.state.clone())
    }

    fn add_row(&mut self, formula: Formula, state: &DualState<T>) -> Result<(), SensitivityError> {
        let Self { stepper, columns, last_rows, last_states, .. } = self;
        columns.row(&mut stepper.equations, state)?;
        if last_rows.len() == ROWS {
            last_rows.pop_front();
        }
        last_rows.push_back(state.t.to_f64());
        while last_states.get(1).is_some_and(|second| second.t.to_f64() <= last_rows[0]) {
            last_states.pop_front();
        }
        columns.refine(|t| outputs_at(stepper, formula, last_states, t))
    }

    fn finish(self, formula: Formula) -> Result<Motion<T>, SensitivityError> {
        let Self { mut stepper, mut columns, last_states, state, steps, .. } = self;
        columns.finish();
        columns.refine(|t| outputs_at(&mut stepper, formula, &last_states, t))?;
        let derived = |numbers: &[Number<T>]| numbers.iter().map(|number| number.0).collect();
        let DualState { t, q, qd, .. } = &state;
        Ok(Motion { steps, end_time: t.0, q: derived(q), qd: derived(qd), outputs: columns.outputs() })
    }
}

/// The state at a time, by a step from the last of some states before it.
fn state_at<T: Inner>(
    stepper: &mut DualStepper<T>,
    formula: Formula,
    states: &VecDeque<DualState<T>>,
    t: f64,
) -> Result<DualState<T>, SensitivityError> {
    let from = states.iter().rev().find(|state| state.t.to_f64() < t).unwrap_or(&states[0]);
    stepper.advance(formula, from, Number::from_f64(t))
}

/// The outputs at a time, by a step from the last of some states before it.
fn outputs_at<T: Inner>(
    stepper: &mut DualStepper<T>,
    formula: Formula,
    states: &VecDeque<DualState<T>>,
    t: f64,
) -> Result<Vec<Number<T>>, SensitivityError> {
    let at = state_at(stepper, formula, states, t)?;
    stepper.equations.outputs(&at)
}

/// Gives the parameters their values, and the derivatives by themselves and along the direction.
///
/// # Errors
/// There is no parameter of a name.
fn seed<T: Inner>(
    stepper: &mut DualStepper<T>,
    replace: ParameterOverrides,
    parameters: &[&str],
    direction: &[(&str, f64)],
) -> Result<(), SensitivityError> {
    let mechanism = stepper.equations.mechanism;
    let own = mechanism.description().parameters;
    for name in parameters.iter().chain(direction.iter().map(|(name, _)| name)) {
        if !own.iter().any(|own| own.name == *name) {
            return Err(SensitivityError::NoParameter { name: (*name).to_owned() });
        }
    }
    stepper.equations.evaluator.set_parameters(|i| {
        let name = own[i].name;
        let part = parameters.iter().position(|parameter| *parameter == name);
        let along = direction.iter().find(|(other, _)| *other == name).map(|(_, along)| *along);
        if part.is_none() && along.is_none() {
            return replace(name).map(Number::from_f64);
        }
        let by = |place: usize| T::from(if part == Some(place) { 1.0 } else { 0.0 });
        Some(differentiated(T::new(mechanism.parameters()[i], along.unwrap_or(0.0)), std::array::from_fn(by)))
    });
    Ok(())
}
