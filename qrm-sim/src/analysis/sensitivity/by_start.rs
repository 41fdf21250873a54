//! The end of a motion with its derivatives by the start.

use qrm_core::{Mechanism, Scalar, Tape};

use super::SensitivityRequest;
use super::error::SensitivityError;
use super::mesh::Mesh;
use super::number::{Number, PARTS, constants, derivative, differentiated};
use super::start::consistent;
use super::stepper::DualStepper;
use crate::integrate::{Integrator, MethodSettings};
use crate::position::Start;
use crate::run::StartError;
use crate::solve::Solver;
use crate::state::State;

/// The end of a motion, and its derivatives by the given coordinates and then by the given rates at the start.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct EndByStart {
    /// The state at the start.
    pub(in crate::analysis) first: State,
    /// The state at the end.
    pub(in crate::analysis) end: State,
    /// The derivatives of coordinates and rates at the end, for each given value.
    pub(in crate::analysis) by: Vec<[Vec<f64>; 2]>,
    /// The number of steps.
    pub(in crate::analysis) steps: u64,
}

/// Follows the motion from a consistent start to `end_time`, by the steps of a method that chooses them, or by steps
/// half as long. The start has all coordinates and rates; derivatives are those by the given ones.
///
/// # Errors
/// The motion does not come to its end, has no derivatives, or is interrupted.
pub(in crate::analysis) fn end_by_start(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    settings: MethodSettings,
    start: &Start,
    end_time: f64,
    is_halved: bool,
    keep_running: Option<&dyn Fn(f64, f64) -> bool>,
) -> Result<EndByStart, SensitivityError> {
    let given = |given: &[bool], is_rate| {
        (0..given.len()).filter(|&i| given[i]).map(|i| (is_rate, i)).collect::<Vec<(bool, usize)>>()
    };
    let places = [given(&start.given, false), given(&start.given_rates, true)].concat();
    if places.is_empty() {
        return prescribed(mechanism, settings, start, end_time);
    }
    let request = SensitivityRequest { settings, outputs: Some(&[]), ..SensitivityRequest::default() };
    let mut found: Option<EndByStart> = None;
    for places in places.chunks(PARTS) {
        let mut stepper = DualStepper::<f64>::new(mechanism, tape, places.len(), &request);
        stepper.equations.evaluator.set_parameters(|i| Some(Number::from_f64(mechanism.parameters()[i])));
        let (mut q, mut qd) = (constants(&start.q), constants(&start.qd));
        for (part, &(is_rate, i)) in places.iter().enumerate() {
            let number = if is_rate { &mut qd[i] } else { &mut q[i] };
            *number = differentiated(number.to_f64(), std::array::from_fn(|other| f64::from(u8::from(other == part))));
        }
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
        found.by.extend((0..places.len()).map(|part| [by(&state.q, part), by(&state.qd, part)]));
    }
    found.ok_or(SensitivityError::NotSmooth { t: 0.0 })
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
