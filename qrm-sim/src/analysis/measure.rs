//! The run time and the results of a method at given times.

use std::time::{Duration, Instant};

use qrm_core::{Mechanism, RowLayout, RowRequest};

use super::energy_integral::{EnergyIntegral, NoEnergyIntegral};
use crate::columns::Kind;
use crate::integrate::{Counts, Integrator, MethodSettings, StepError};
use crate::position::{AssemblyBranch, Start};
use crate::run::{StartError, first_state};
use crate::solve::{LoopConstraints, Solver, largest};
use crate::state::State;

/// A state with its outputs and checks.
#[derive(Clone, Debug)]
pub struct StateAt {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Rates.
    pub qd: Vec<f64>,
    /// Accelerations.
    pub qdd: Vec<f64>,
    /// Multipliers.
    pub multipliers: Vec<f64>,
    /// Outputs.
    pub outputs: Vec<f64>,
    /// Largest residual of a constraint.
    pub residual: f64,
    /// Kinetic and potential energy.
    pub energy: f64,
    /// Power of the loads without potential and of the driven constraints.
    pub power: f64,
}

impl StateAt {
    /// The number of this kind; not a number if the mechanism has no such entry.
    pub fn value(&self, kind: Kind) -> f64 {
        let entry = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        match kind {
            Kind::Time => self.t,
            Kind::Coordinate(i) => entry(&self.q, i),
            Kind::Rate(i) => entry(&self.qd, i),
            Kind::Acceleration(i) => entry(&self.qdd, i),
            Kind::Multiplier(i) => entry(&self.multipliers, i),
            Kind::Output(i) => entry(&self.outputs, i),
            Kind::Residual => self.residual,
            Kind::Energy => self.energy,
            Kind::Parameter(_) | Kind::ResidualRate => f64::NAN,
        }
    }
}

/// The results and run times of a method.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The time of each repetition in s, shortest first.
    pub seconds: Vec<f64>,
    /// The states at the requested times.
    pub states: Vec<StateAt>,
    /// Energy at the start.
    pub energy: f64,
    /// The numbers of steps and evaluations of one repetition.
    pub counts: Counts,
}

/// A method, and the step length if the method does not choose it.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// The method.
    pub settings: MethodSettings,
    /// Length of the steps.
    pub step: f64,
}

/// The number of repetitions of a run.
#[derive(Clone, Copy, Debug)]
pub struct Repetitions {
    /// The smallest number of repetitions.
    pub least: usize,
    /// The time after which repetitions stop. Ten times this is the hard limit.
    pub time: Duration,
}

/// Runs a method repeatedly to each of the times, which must increase. Fixed steps are shortened a little where they do
/// not divide the time to the next one.
///
/// # Errors
/// The run cannot start, or does not reach the last time.
pub fn measure(
    mechanism: &dyn Mechanism,
    trial: &Trial,
    times: &[f64],
    repetitions: Repetitions,
) -> Result<Measurement, StartError> {
    let first = first_state(mechanism, &AssemblyBranch::new(mechanism), Start::new(mechanism))?;
    let mut states = Vec::with_capacity(times.len());
    let mut seconds = Vec::new();
    let mut counts = Counts::default();
    let begun = Instant::now();
    while seconds.len() < repetitions.least || begun.elapsed() < repetitions.time {
        let repetition = Instant::now();
        counts = run_to_times(mechanism, trial, &first, times, &mut states).map_err(StartError::Step)?;
        seconds.push(repetition.elapsed().as_secs_f64());
        if begun.elapsed() > 10 * repetitions.time {
            break;
        }
    }
    seconds.sort_by(f64::total_cmp);
    let energy = first.energy(mechanism);
    let states = states.iter().map(|state| described(mechanism, state)).collect();
    Ok(Measurement { seconds, states, energy, counts })
}

/// The number of rows in a block.
const CHUNK: u64 = 256;

/// Runs once to each of the times.
fn run_to_times(
    mechanism: &dyn Mechanism,
    Trial { settings, step }: &Trial,
    first: &State,
    times: &[f64],
    states: &mut Vec<State>,
) -> Result<Counts, StepError> {
    states.clear();
    let end = times.last().copied().unwrap_or(0.0);
    let mut integrator = Integrator::new(mechanism, *settings, first, end)?;
    let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
    let mut now = first.clone();
    let mut rows = 0;
    let mut buffer = Vec::new();
    for &t in times {
        let steps = if integrator.is_fixed() { ((t - now.t) / step - 1e-9).ceil().max(1.0) as u64 } else { 1 };
        rows += steps;
        let mut request = RowRequest {
            origin: now.t,
            step: (t - now.t) / steps as f64,
            end_time: t,
            first: 0,
            residual: settings.projection_tolerance.residual,
            watches_event: false,
        };
        while request.first < steps {
            buffer.resize((CHUNK.min(steps - request.first) + 1) as usize * layout.width(), 0.0);
            now.write(&mut buffer);
            let block = integrator.fill(mechanism, &request, &mut buffer);
            block.reason?;
            request.first += block.rows_written as u64;
            now.read(&buffer[block.rows_written * layout.width()..]);
        }
        states.push(now.clone());
    }
    Ok(integrator.counts(rows))
}

/// Computes states from the energy integral.
///
/// # Errors
/// The motion has no energy integral.
pub fn exact_states(mechanism: &dyn Mechanism, times: &[f64], panels: f64) -> Result<Vec<StateAt>, NoEnergyIntegral> {
    let integral = EnergyIntegral::new(mechanism, times.last().copied().unwrap_or(0.0), panels)?;
    let at = |t: &f64| {
        let mut state = State::zero(0, mechanism.description().constraints.len());
        state.t = *t;
        (state.q, state.qd) = integral.state(*t)?;
        state.qdd = vec![0.0; state.q.len()];
        Solver::at(mechanism, *t, &state.q).complete(mechanism, &mut state).ok()?;
        Some(described(mechanism, &state))
    };
    times.iter().map(at).collect::<Option<Vec<StateAt>>>().ok_or(NoEnergyIntegral::TurnsBack)
}

fn described(mechanism: &dyn Mechanism, at: &State) -> StateAt {
    let mut outputs = vec![0.0; mechanism.description().outputs.len()];
    mechanism.outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut outputs);
    StateAt {
        t: at.t,
        q: at.q.clone(),
        qd: at.qd.clone(),
        qdd: at.qdd.clone(),
        multipliers: at.multipliers.clone(),
        outputs,
        residual: largest(&LoopConstraints::at(mechanism, at.t, &at.q).residuals).1,
        energy: at.energy(mechanism),
        power: at.power(mechanism),
    }
}
