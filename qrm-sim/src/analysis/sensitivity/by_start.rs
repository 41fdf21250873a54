//! The end of a motion with its derivatives by the start.

use qrm_core::{Mechanism, ParameterOverrides, Scalar, Tape};

use super::SensitivityRequest;
use super::error::SensitivityError;
use super::mesh::Mesh;
use super::number::{Number, PARTS, derivative, differentiated};
use super::start::consistent;
use super::stepper::DualStepper;
use crate::integrate::{Integrator, MethodSettings};
use crate::position::Start;
use crate::run::StartError;
use crate::solve::Solver;
use crate::state::State;

/// The end of a motion, and its derivatives by the given coordinates, the given rates at the start, and a parameter.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct EndByStart {
    /// The state at the start.
    pub(in crate::analysis) first: State,
    /// The state at the end.
    pub(in crate::analysis) end: State,
    /// The derivatives of coordinates and rates at the end, for each given value, and then for the parameter.
    pub(in crate::analysis) by: Vec<[Vec<f64>; 2]>,
    /// The number of steps.
    pub(in crate::analysis) steps: u64,
}

/// A motion whose end is differentiated.
#[derive(Clone, Copy)]
pub(in crate::analysis) struct MotionByStart<'a> {
    /// The method, which chooses its steps.
    pub(in crate::analysis) settings: MethodSettings,
    /// The start, with all coordinates and rates; derivatives are those by the given ones.
    pub(in crate::analysis) start: &'a Start,
    /// The number of a parameter, whose derivatives are computed too, and the values that replace those of the scene:
    /// parameters that the scene computes from that one follow.
    pub(in crate::analysis) parameter: Option<(usize, ParameterOverrides<'a>)>,
    pub(in crate::analysis) end_time: f64,
    /// Whether steps are half as long.
    pub(in crate::analysis) is_halved: bool,
    /// Asked after some steps, with the time and the end of the motion; nothing more is computed where it says false.
    pub(in crate::analysis) keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
}

/// Follows a motion from a consistent start to its end.
///
/// # Errors
/// The motion does not come to its end, has no derivatives, or is interrupted.
pub(in crate::analysis) fn end_by_start(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    motion: &MotionByStart,
) -> Result<EndByStart, SensitivityError> {
    let MotionByStart { settings, start, parameter, end_time, is_halved, keep_running } = *motion;
    let given = |given: &[bool], seed: fn(usize) -> Seed| {
        (0..given.len()).filter(|&i| given[i]).map(seed).collect::<Vec<Seed>>()
    };
    let mut seeds = [given(&start.given, Seed::Coordinate), given(&start.given_rates, Seed::Rate)].concat();
    seeds.extend(parameter.map(|(place, _)| Seed::Parameter(place)));
    if seeds.is_empty() {
        return prescribed(mechanism, settings, start, end_time);
    }
    let request = SensitivityRequest { settings, outputs: Some(&[]), ..SensitivityRequest::default() };
    let mut found: Option<EndByStart> = None;
    for seeds in seeds.chunks(PARTS) {
        let mut stepper = DualStepper::<f64>::new(mechanism, tape, seeds.len(), &request);
        let seeded = |value: f64, seed: Seed| match seeds.iter().position(|other| *other == seed) {
            Some(place) => differentiated(value, std::array::from_fn(|part| f64::from(u8::from(part == place)))),
            None => Number::from_f64(value),
        };
        let (values, names) = (mechanism.parameters(), mechanism.description().parameters);
        stepper.equations.evaluator.set_parameters(|i| match parameter {
            Some((place, replace)) if i != place => replace(names[i].name).map(Number::from_f64),
            _ => Some(seeded(values[i], Seed::Parameter(i))),
        });
        let numbers = |values: &[f64], seed: fn(usize) -> Seed| -> Vec<Number<f64>> {
            values.iter().enumerate().map(|(i, value)| seeded(*value, seed(i))).collect()
        };
        let (q, qd) = (numbers(&start.q, Seed::Coordinate), numbers(&start.qd, Seed::Rate));
        let mut state = consistent(&mut stepper.equations, q, qd, start)?;
        let first = state.real();
        let mesh = Mesh::new(mechanism, settings, &first, end_time, is_halved);
        let mut mesh = mesh.map_err(|error| SensitivityError::Start(StartError::Step(error)))?;
        let steps = mesh.steps_to(end_time).map_err(|error| SensitivityError::Step { t: first.t, error })?;
        for step in &steps {
            state = stepper.advance(step.formula, &state, Number::from_f64(step.end))?;
            if keep_running.is_some_and(|keep_running| !keep_running(step.end, end_time)) {
                return Err(SensitivityError::Interrupted { t: step.end });
            }
        }
        let (end, steps) = (state.real(), steps.len() as u64);
        let found = found.get_or_insert_with(|| EndByStart { first, end, by: Vec::new(), steps });
        let by = |numbers: &[Number<f64>], part| numbers.iter().map(|number| derivative(number, part)).collect();
        found.by.extend((0..seeds.len()).map(|part| [by(&state.q, part), by(&state.qd, part)]));
    }
    found.ok_or(SensitivityError::NotSmooth { t: 0.0 })
}

/// A value by which the end is differentiated.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Seed {
    /// A coordinate at the start.
    Coordinate(usize),
    /// A rate at the start.
    Rate(usize),
    /// A parameter.
    Parameter(usize),
}

/// The end of a motion that constraints prescribe, which has no derivatives.
fn prescribed(
    mechanism: &dyn Mechanism,
    settings: MethodSettings,
    start: &Start,
    end_time: f64,
) -> Result<EndByStart, SensitivityError> {
    let failed = |error| SensitivityError::Step { t: 0.0, error };
    let mut first = State::zero(start.q.len(), mechanism.description().constraints.len());
    (first.q, first.qd) = (start.q.clone(), start.qd.clone());
    Solver::at(mechanism, 0.0, &first.q).complete(mechanism, &mut first).map_err(failed)?;
    let mut integrator = Integrator::new(mechanism, settings, &first, end_time).map_err(failed)?;
    let mut end = first.clone();
    integrator.advance(mechanism, &first, end_time, &mut end).map_err(failed)?;
    let steps = integrator.take_steps().len() as u64;
    Ok(EndByStart { first, end, by: Vec::new(), steps })
}
