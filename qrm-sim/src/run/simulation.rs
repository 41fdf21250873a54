//! A motion in progress, for programs that request states at arbitrary times.

mod advance;

use std::sync::Arc;

use qrm_core::{Mechanism, Model, ParameterOverrides};

use super::error::{Reason, SimError};
use super::first_state::first_state;
use super::judgement::RejectionReason;
use super::outcome::StartError;
use super::run_health::RunHealth;
use crate::columns::Kind;
use crate::integrate::{Integrator, MethodSettings, StepError};
use crate::position::{AssemblyBranch, Start};
use crate::solve::{LoopConstraints, Matrix, Solver, is_positive, largest};
use crate::state::State;

/// A motion in progress. Between the requested times it makes the same steps as [`simulate`](crate::run::simulate).
///
/// ```
/// # use qrm_sim::{integrate::MethodSettings, run::Simulation};
/// # fn swing(model: &qrm_core::Model) -> Result<(), Box<dyn std::error::Error>> {
/// let mut simulation = Simulation::new(model, &|_| None, MethodSettings::default(), None)?;
/// for i in 1..=100 {
///     let at = simulation.advance(0.01 * f64::from(i))?;
///     println!("{} {:?}", at.t, at.q);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Simulation {
    model: Model,
    mechanism: Arc<dyn Mechanism>,
    integrator: Integrator,
    step: f64,
    /// Time of row 0.
    origin: f64,
    /// The number of the last row.
    rows: u64,
    /// The last row.
    row: State,
    /// The last requested state.
    now: State,
    /// The data on the accuracy of the motion; `None` if it is not watched.
    watch: Option<Box<RunHealth>>,
}

impl Simulation {
    /// Begins a motion at its scene's start, t = 0, with some parameters replaced.
    ///
    /// `step` is the step in seconds, or the time between rows of a method that chooses its steps; the scene's if
    /// `None`.
    ///
    /// # Errors
    /// The mechanism cannot be assembled, its accelerations are not determined, or the step is not positive.
    pub fn new(
        model: &Model,
        replace: ParameterOverrides,
        settings: MethodSettings,
        step: Option<f64>,
    ) -> Result<Self, SimError> {
        let mechanism: Arc<dyn Mechanism> = model.mechanism(replace).into();
        let made = Self::begin(model, mechanism, settings, step);
        made.map_err(|reason| error(model, Reason::Start(reason)))?.require_positive_mass()
    }

    /// Returns the motion, if the kinetic energy of its mechanism is never negative.
    fn require_positive_mass(self) -> Result<Self, SimError> {
        let n = self.now.q.len();
        let mut mass_matrix = Matrix::zero(n, n);
        self.mechanism.mass_matrix(&self.now.q, mass_matrix.entries_mut());
        if is_positive(mass_matrix) { Ok(self) } else { Err(error(&self.model, Reason::NegativeMass)) }
    }

    fn begin(
        model: &Model,
        mechanism: Arc<dyn Mechanism>,
        settings: MethodSettings,
        step: Option<f64>,
    ) -> Result<Self, StartError> {
        let step = step.unwrap_or(mechanism.schedule().step);
        if !(step > 0.0) {
            return Err(StartError::StepTooShort { step, end_time: f64::INFINITY });
        }
        let first = first_state(&*mechanism, &AssemblyBranch::new(&*mechanism), Start::new(&*mechanism))?;
        Self::from_state(model, mechanism, settings, step, first).map_err(StartError::Step)
    }

    fn from_state(
        model: &Model,
        mechanism: Arc<dyn Mechanism>,
        settings: MethodSettings,
        step: f64,
        first: State,
    ) -> Result<Self, StepError> {
        let integrator = Integrator::new(&*mechanism, settings, &first, f64::INFINITY)?;
        Ok(Self {
            model: *model,
            mechanism,
            integrator,
            step,
            origin: first.t,
            rows: 0,
            row: first.clone(),
            now: first,
            watch: None,
        })
    }

    /// Watches the motion from here on, so that its accuracy can be judged like that of a run: see
    /// [`rejection_reasons`](Self::rejection_reasons).
    ///
    /// A second motion estimates the error, with 3/2 of the step, or with shorter steps if a tolerance chooses them.
    /// When parameters change, it restarts from this motion, and the errors are summed.
    ///
    /// # Errors
    /// The energy is not finite here.
    pub fn watched(mut self) -> Result<Self, SimError> {
        let watch = RunHealth::new(&*self.mechanism, &self.integrator.settings, &self.now);
        let failed = |reason| error(&self.model, Reason::Failed { t: self.now.t, error: reason });
        self.watch = Some(Box::new(watch.map_err(failed)?));
        Ok(self)
    }

    /// The reasons not to trust the motion since it was [`watched`](Self::watched); empty if it is not.
    pub fn rejection_reasons(&self) -> Vec<RejectionReason> {
        let rejection_reasons =
            |watch: &RunHealth| watch.rejection_reasons(&*self.mechanism, &self.integrator, self.rows);
        self.watch.as_deref().map_or_else(Vec::new, rejection_reasons)
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &dyn Mechanism {
        &*self.mechanism
    }

    /// The last requested state.
    pub fn now(&self) -> &State {
        &self.now
    }

    /// A number of the present state; not a number if the mechanism has no such entry.
    pub fn value(&self, kind: Kind) -> f64 {
        let State { t, q, qd, qdd, multipliers, .. } = self.now();
        let mechanism = self.mechanism();
        let entry = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        match kind {
            Kind::Time => *t,
            Kind::Parameter(i) => entry(mechanism.parameters(), i),
            Kind::Coordinate(i) => entry(q, i),
            Kind::Rate(i) => entry(qd, i),
            Kind::Acceleration(i) => entry(qdd, i),
            Kind::Multiplier(i) => entry(multipliers, i),
            Kind::Output(i) => entry(&self.outputs(), i),
            Kind::Residual => self.residuals()[0],
            Kind::ResidualRate => self.residuals()[1],
            Kind::Energy => mechanism.energy(q, qd).iter().sum(),
        }
    }

    /// The outputs of the present state, in the order of the description.
    pub fn outputs(&self) -> Vec<f64> {
        let State { t, q, qd, qdd, multipliers, .. } = &self.now;
        let mut outputs = vec![f64::NAN; self.mechanism.description().outputs.len()];
        self.mechanism.outputs(*t, q, qd, qdd, multipliers, &mut outputs);
        outputs
    }

    /// The largest residual of a constraint, in m or rad, and the largest rate of a residual, in m/s or rad/s, in the
    /// present state.
    pub fn residuals(&self) -> [f64; 2] {
        let constraints = LoopConstraints::at(&*self.mechanism, self.now.t, &self.now.q);
        [&constraints.residuals, &constraints.velocity_residual(&self.now.qd)].map(|residuals| largest(residuals).1)
    }

    /// Continues from the present state with other parameter values: other masses, springs, loads.
    ///
    /// # Errors
    /// The constraints cannot be satisfied near this position, or the accelerations are not determined; the motion is
    /// then unchanged.
    pub fn replace(&mut self, replace: ParameterOverrides) -> Result<(), SimError> {
        let mechanism: Arc<dyn Mechanism> = self.model.mechanism(replace).into();
        let t = self.now.t;
        let changed = self.changed(mechanism);
        *self = changed
            .map_err(|reason| error(&self.model, Reason::Failed { t, error: reason }))?
            .require_positive_mass()?;
        Ok(())
    }

    fn changed(&self, mechanism: Arc<dyn Mechanism>) -> Result<Self, StepError> {
        let settings = self.integrator.settings;
        let mut first = self.now.clone();
        Solver::with_rank(&*mechanism, self.integrator.rank()).make_consistent(&*mechanism, &settings, &mut first)?;
        let mut watch = self.watch.clone();
        if let Some(watch) = &mut watch {
            let mechanisms = [&*self.mechanism, &*mechanism];
            watch.change(mechanisms, &self.integrator, self.rows, [&self.now, &first])?;
        }
        let changed = Self::from_state(&self.model, mechanism, settings, self.step, first)?;
        Ok(Self { watch, ..changed })
    }

    /// Continues from other coordinates and rates, at another time; the motion is no longer watched.
    ///
    /// # Errors
    /// The accelerations are not determined there; the motion is then unchanged.
    pub fn place(&mut self, t: f64, q: &[f64], qd: &[f64]) -> Result<(), SimError> {
        let mut first = State::zero(q.len(), self.now.multipliers.len());
        (first.t, first.q, first.qd) = (t, q.to_vec(), qd.to_vec());
        let mechanism = Arc::clone(&self.mechanism);
        let made = Solver::with_rank(&*mechanism, self.integrator.rank())
            .complete(&*mechanism, &mut first)
            .and_then(|()| Self::from_state(&self.model, mechanism, self.integrator.settings, self.step, first));
        *self = made.map_err(|reason| error(&self.model, Reason::Failed { t, error: reason }))?;
        Ok(())
    }
}

fn error(model: &Model, reason: Reason) -> SimError {
    SimError { reason, description: model.description }
}
