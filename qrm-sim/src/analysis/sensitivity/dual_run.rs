//! A motion with its derivatives by parameters.

use qrm_core::{Mechanism, Replace, RowRequest, Scalar, Tape};

use super::event::Condition;
use super::number::{Derived, Number, PARTS, derivatives, has_derivatives, number};
use super::result::{Motion, Output};
use super::step::{DualState, DualStepper};
use super::{SensitivityEnd, SensitivityError, SensitivityRequest};
use crate::run::{Dependents, Extremes, ExtremesTracker, Integral, StartError, assembled, check_condition, check_step};
use crate::solve::{LoopConstraints, ProjectionTolerance};
use crate::start::Start;

/// The motion on dual numbers.
pub(super) struct DualRun<'a> {
    stepper: DualStepper<'a>,
    condition: Condition<'a>,
    rows: RowRequest,
    /// The end of the rows, and its derivatives.
    end_time: Number,
    state: DualState,
    goes_on: Option<&'a dyn Fn(f64, f64) -> bool>,
}

impl<'a> DualRun<'a> {
    /// The motion at its start.
    ///
    /// # Errors
    /// It cannot begin, or there is no such parameter.
    pub(super) fn new(
        mechanism: &'a dyn Mechanism,
        tape: &'a Tape<'a>,
        replace: Replace,
        parameters: &'a [&'a str],
        request: &'a SensitivityRequest<'a>,
    ) -> Result<Self, SensitivityError> {
        let own = mechanism.description().parameters;
        let place = |parameter: &&str| {
            let no_parameter = || SensitivityError::NoParameter { name: (*parameter).to_owned() };
            own.iter().position(|own| own.name == *parameter).ok_or_else(no_parameter)
        };
        let places = parameters.iter().map(place).collect::<Result<Vec<usize>, _>>()?;
        let mut stepper = DualStepper::new(mechanism, tape, parameters.len());
        stepper.evaluator.set_parameters(|i| {
            if !places.contains(&i) {
                return replace(own[i].name).map(Number::from_f64);
            }
            let is_own = |part: usize| if places.get(part) == Some(&i) { 1.0 } else { 0.0 };
            Some(number(mechanism.parameters()[i], std::array::from_fn(is_own)))
        });
        let schedule = stepper.evaluator.schedule();
        let end_time = match request.end {
            Some(SensitivityEnd::Time(t)) => Number::from_f64(t),
            _ => schedule.end_time,
        };
        let rows = RowRequest {
            origin: 0.0,
            step: request.step.unwrap_or(schedule.step.0.re),
            end_time: end_time.0.re,
            first: 0,
            residual: ProjectionTolerance::default().residual,
            watches_event: false,
        };
        check_step(rows.step, rows.end_time).map_err(SensitivityError::Start)?;
        let state = start(&mut stepper)?;
        let condition = Condition { parameters, end: request.end.as_ref() };
        Ok(Self { stepper, condition, rows, end_time, state, goes_on: request.goes_on })
    }

    /// Follows the motion to its end.
    ///
    /// # Errors
    /// It does not come to its end, has no derivative, or is interrupted.
    pub(super) fn run(self) -> Result<Motion, SensitivityError> {
        let Self { mut stepper, condition, rows, end_time, mut state, goes_on } = self;
        let mut columns = Columns::new(stepper.mechanism.description().outputs.len());
        columns.row(&mut stepper, &state)?;
        let mut value = condition.value(&mut stepper, &state);
        check_condition(value.map(|value| value.0.re)).map_err(SensitivityError::Start)?;
        let mut row = 0;
        while state.t.0.re < rows.end_time && value.is_none_or(|value| value.0.re < 0.0) {
            row += 1;
            let t = Number::from_f64(rows.time(row));
            let mut next = stepper.step(&state, if t.0.re < rows.end_time { t } else { end_time })?;
            value = condition.value(&mut stepper, &next);
            if value.is_some_and(|value| value.0.re.is_nan()) {
                return Err(SensitivityError::NotSmooth { t: state.t.0.re });
            }
            if value.is_some_and(|value| value.0.re >= 0.0) {
                next = condition.locate(&mut stepper, &state, &next)?;
            }
            state = next;
            columns.row(&mut stepper, &state)?;
            let t = state.t.0.re;
            if goes_on.is_some_and(|goes_on| !goes_on(t, rows.end_time)) {
                return Err(SensitivityError::Interrupted { t });
            }
        }
        if value.is_some_and(|value| value.0.re < 0.0) {
            return Err(SensitivityError::EventNotReached { end_time: rows.end_time });
        }
        Ok(Motion { end_time: state.t.0, q: derived(&state.q), qd: derived(&state.qd), outputs: columns.finish() })
    }
}

/// The consistent state at the start. Given coordinates and rates may depend on the parameter; the others follow by the
/// constraints, `C_q dx = -dC` in derivatives.
fn start(stepper: &mut DualStepper) -> Result<DualState, SensitivityError> {
    let mechanism = stepper.mechanism;
    let given = Start::of(mechanism);
    let assembled = assembled(mechanism).map_err(|e| SensitivityError::Start(StartError::NotAssembled(e)))?;
    let jacobian = LoopConstraints::of(mechanism, 0.0, &assembled.0).constraint_jacobian;
    let zero = |size| vec![Number::zero(); size];
    let (mut q, mut qd) = (zero(given.q.len()), zero(given.q.len()));
    stepper.evaluator.start(&mut q, &mut qd);
    let mut results = zero(stepper.evaluator.tape().loop_constraints.results.len());

    take_assembled(&mut q, &assembled.0, &given.given);
    stepper.evaluator.loop_constraints(Number::zero(), &q, &mut results);
    let [residuals, _, _] = stepper.evaluator.tape().split_loop_constraints(&results);
    follow(&Dependents::new(&jacobian, &given.given), &mut q, residuals);

    take_assembled(&mut qd, &assembled.1, &given.given_rates);
    stepper.evaluator.loop_constraints(Number::zero(), &q, &mut results);
    let [_, rows, rates] = stepper.evaluator.tape().split_loop_constraints(&results);
    let velocity_residual: Vec<Number> = rows
        .chunks_exact(q.len().max(1))
        .zip(rates)
        .map(|(row, rate)| row.iter().zip(&qd).fold(*rate, |sum, (entry, qd)| sum + *entry * *qd))
        .collect();
    follow(&Dependents::new(&jacobian, &given.given_rates), &mut qd, &velocity_residual);
    stepper.state(Number::zero(), q, qd)
}

/// Takes over assembled values; only given ones keep their derivatives.
fn take_assembled(numbers: &mut [Number], values: &[f64], given: &[bool]) {
    for ((taken, value), given) in numbers.iter_mut().zip(values).zip(given) {
        *taken = number(*value, if *given { derivatives(taken) } else { [0.0; PARTS] });
    }
}

/// Lets the derivatives of dependent coordinates or rates follow.
fn follow(dependents: &Dependents, x: &mut [Number], residuals: &[Number]) {
    let of = |numbers: &[Number], part: usize| numbers.iter().map(|x| derivatives(x)[part]).collect::<Vec<f64>>();
    let mut changed: Vec<[f64; PARTS]> = x.iter().map(derivatives).collect();
    for part in 0..PARTS {
        let mut change = of(x, part);
        dependents.follow(&mut change, &of(residuals, part));
        changed.iter_mut().zip(change).for_each(|(all, change)| all[part] = change);
    }
    x.iter_mut().zip(changed).for_each(|(x, changed)| *x = number(x.0.re, changed));
}

fn derived(numbers: &[Number]) -> Vec<Derived> {
    numbers.iter().map(|number| number.0).collect()
}

/// The columns of the outputs.
struct Columns {
    extremes: ExtremesTracker<Derived>,
    integrals: Vec<Integral<Derived>>,
    /// The last row.
    outputs: Vec<Number>,
}

impl Columns {
    fn new(count: usize) -> Self {
        Self {
            extremes: ExtremesTracker::default(),
            integrals: vec![Integral::default(); count],
            outputs: vec![Number::zero(); count],
        }
    }

    /// Takes the next row.
    fn row(&mut self, stepper: &mut DualStepper, at: &DualState) -> Result<(), SensitivityError> {
        stepper.evaluator.outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut self.outputs);
        for (integral, output) in self.integrals.iter_mut().zip(&self.outputs) {
            if !(output.0.re.is_finite() && has_derivatives(output)) {
                return Err(SensitivityError::NotSmooth { t: at.t.0.re });
            }
            integral.row(at.t.0, output.0);
        }
        let values: Vec<Derived> = self.outputs.iter().map(|output| output.0).collect();
        self.extremes.row(at.t.0, &values);
        Ok(())
    }

    fn finish(mut self) -> Vec<Output> {
        self.extremes.finish();
        let columns = self.integrals.iter().zip(&self.outputs).zip(self.extremes.found());
        let output = |((integral, end), extremes): ((&Integral<Derived>, &Number), &Extremes<Derived>)| Output {
            end: end.0,
            extremes: *extremes,
            integral: integral.finish(),
        };
        columns.map(output).collect()
    }
}
