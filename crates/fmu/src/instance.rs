//! An instance of an FMU, with the phases of the interface.

use std::collections::BTreeMap;

use qrm_core::Model;
use qrm_sim::columns::{Column, Kind};
use qrm_sim::run::{Reason, SimError, Simulation};

use crate::failure::Failure;
use crate::phase::Phase;
use crate::token::{InstantiationToken, NotAToken};
use crate::variables::variables;

/// The residual above which an event is raised, in which an importer that integrates itself receives closed loops
/// again.
const OPEN_LOOP_RESIDUAL: f64 = 1e-10;

/// The relative difference below which times are equal for an importer that sums its steps.
const SAME: f64 = 1e-7;

/// The integrating side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interface {
    /// The FMU integrates.
    CoSimulation,
    /// The importer integrates.
    ModelExchange,
}

/// An instance.
pub(crate) struct Instance {
    pub(crate) interface: Interface,
    model: Model,
    token: InstantiationToken,
    variables: Vec<Column>,
    pub(crate) state: State,
}

/// The state of an instance that the importer can save and restore.
#[derive(Clone)]
pub(crate) struct State {
    pub(crate) phase: Phase,
    /// The importer's time at the start; the scene's time is zero there.
    origin: f64,
    /// The importer's stop time, if given.
    stop: Option<f64>,
    /// The parameters set by the importer.
    set: BTreeMap<&'static str, f64>,
    /// Whether parameters were set since the motion last used them.
    parameters_changed: bool,
    /// The time and states of the importer's integration.
    importer_state: Option<(f64, Vec<f64>)>,
    /// Whether the motion is at that time and state.
    is_placed: bool,
    simulation: Option<Simulation>,
}

impl State {
    fn new() -> Self {
        Self {
            phase: Phase::Instantiated,
            origin: 0.0,
            stop: None,
            set: BTreeMap::new(),
            parameters_changed: false,
            importer_state: None,
            is_placed: true,
            simulation: None,
        }
    }
}

impl Instance {
    pub(crate) fn new(token: &str, interface: Interface, models: &[Model]) -> Result<Self, String> {
        let token: InstantiationToken = token.parse().map_err(|e: NotAToken| e.to_string())?;
        let model = models.iter().find(|model| token.is_of(model.description)).ok_or_else(|| {
            format!("the library does not hold the scene `{}` that the description was made for", token.scene)
        })?;
        Ok(Self { interface, variables: variables(model.description), model: *model, token, state: State::new() })
    }

    pub(crate) fn reset(&mut self) {
        self.state = State::new();
    }

    /// The interface and model that a saved state must match before this instance accepts it.
    pub(crate) fn identity(&self) -> String {
        format!("{:?} of `{}`", self.interface, self.token)
    }

    /// Begins the initialization phase.
    pub(crate) fn begin(&mut self, start: f64, stop: Option<f64>) -> Result<(), Failure> {
        if !start.is_finite() {
            return Err(format!("{start} is no time to start at").into());
        }
        if let Some(stop) = stop.filter(|stop| !(*stop >= start)) {
            return Err(format!("a motion that starts at {start} s cannot stop at {stop} s").into());
        }
        (self.state.origin, self.state.stop) = (start, stop);
        self.state.phase = Phase::Initializing;
        Ok(())
    }

    /// Refuses functions of the other interface.
    pub(crate) fn is_for(&self, interface: Interface) -> Result<(), Failure> {
        if self.interface == interface {
            Ok(())
        } else {
            Err(format!("the instance is one of {:?}", self.interface).into())
        }
    }

    /// The value of a variable.
    pub(crate) fn get(&mut self, reference: u32) -> Result<f64, Failure> {
        let kind = self.variable(reference)?.kind;
        match kind {
            Kind::Parameter(i) => Ok(self.model.parameter_values(&|name| self.value_set(name))[i]),
            Kind::Time => match (&self.state.importer_state, &self.state.simulation) {
                (Some((t, _)), _) => Ok(*t),
                (None, Some(simulation)) => Ok(self.state.origin + simulation.now().t),
                (None, None) => Ok(self.state.origin),
            },
            _ => {
                let value = self.simulation()?.value(kind);
                let name = &self.variables[reference as usize].name;
                if value.is_finite() {
                    return Ok(value);
                }
                let message = format!("`{name}` is not finite here");
                Err(if self.state.importer_state.is_some() {
                    Failure::Discard(message)
                } else {
                    Failure::Error(message)
                })
            }
        }
    }

    /// Sets parameters: all or none.
    pub(crate) fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Failure> {
        let named: Vec<&'static str> =
            references.iter().zip(values).map(|(r, value)| self.settable(*r, *value)).collect::<Result<_, _>>()?;
        self.state.set.extend(named.into_iter().zip(values.iter().copied()));
        self.state.parameters_changed = true;
        Ok(())
    }

    /// The name of a parameter, if it can be set to this value now.
    fn settable(&self, reference: u32, value: f64) -> Result<&'static str, String> {
        let variable = self.variable(reference)?;
        let name = &variable.name;
        let Kind::Parameter(i) = variable.kind else {
            return Err(format!("`{name}` is a result and cannot be set"));
        };
        if self.token.computed.contains(name) {
            return Err(format!("parameter `{name}` follows from others and cannot be set"));
        }
        if self.state.phase.is_running() && self.token.fixed.contains(name) {
            return Err(format!(
                "parameter `{name}` can be set before the start only: the loops or the start depend on it"
            ));
        }
        if !value.is_finite() {
            return Err(format!("parameter `{name}` cannot be {value}: it must be finite"));
        }
        if value < 0.0 && self.token.masses.contains(name) {
            return Err(format!("parameter `{name}` cannot be {value}: its smallest value is 0"));
        }
        Ok(self.model.description.parameters[i].name)
    }

    /// Ends the initialization phase.
    pub(crate) fn start(&mut self) -> Result<(), Failure> {
        self.simulation()?;
        self.state.phase = match self.interface {
            Interface::CoSimulation => Phase::Stepping,
            Interface::ModelExchange => Phase::Event,
        };
        Ok(())
    }

    /// Advances by a step of the importer.
    pub(crate) fn advance(&mut self, from: f64, step: f64) -> Result<(), Failure> {
        let now = self.time();
        let same = SAME * (1.0 + now.abs());
        if !((from - now).abs() <= same) {
            return Err(format!("a step from t = {from} s was asked for, but the motion has come to {now} s").into());
        }
        if !(step >= 0.0) {
            return Err(format!("a step cannot be {step} s long").into());
        }
        if let Some(stop) = self.state.stop.filter(|stop| from + step > stop + same) {
            let message = format!("a step from t = {from} s by {step} s leads beyond the stop time, {stop} s");
            return Err(message.into());
        }
        let t = from + step - self.state.origin;
        match self.simulation()?.advance_trusted(t) {
            Ok(_) => Ok(()),
            Err(e) if matches!(e.reason, Reason::Doubtful { .. }) => {
                Err(format!("{e}; step, method and tolerance are options of `qrm export-fmu`").into())
            }
            Err(e) => Err(e.to_string().into()),
        }
    }

    /// The importer's time.
    pub(crate) fn time(&self) -> f64 {
        self.state.origin + self.state.simulation.as_ref().map_or(0.0, |simulation| simulation.now().t)
    }

    /// The number of states that an importer integrates.
    pub(crate) fn states(&self) -> usize {
        2 * self.model.description.coordinates.len()
    }

    /// Sets the time and states of the importer's integration.
    pub(crate) fn place(&mut self, t: Option<f64>, states: Option<&[f64]>) -> Result<(), Failure> {
        let mut now = match self.state.importer_state.take() {
            Some(importer_state) => importer_state,
            None => (self.time(), self.continuous_states()?),
        };
        if !t.is_none_or(f64::is_finite) || !states.unwrap_or_default().iter().all(|state| state.is_finite()) {
            self.state.importer_state = Some(now);
            return Err("time or a state is not finite".into());
        }
        if let Some(t) = t {
            now.0 = t;
        }
        if let Some(states) = states {
            now.1.copy_from_slice(states);
        }
        self.state.importer_state = Some(now);
        self.state.is_placed = false;
        Ok(())
    }

    /// The continuous states: coordinates, then rates.
    pub(crate) fn continuous_states(&mut self) -> Result<Vec<f64>, Failure> {
        if let Some((_, states)) = &self.state.importer_state {
            return Ok(states.clone());
        }
        let now = self.simulation()?.now();
        Ok([&*now.q, &now.qd].concat())
    }

    /// The derivatives of the continuous states: rates, then accelerations.
    pub(crate) fn derivatives(&mut self) -> Result<Vec<f64>, Failure> {
        let now = self.simulation()?.now();
        Ok([&*now.qd, &now.qdd].concat())
    }

    /// Whether the importer's integration has opened the loops.
    pub(crate) fn is_open(&mut self) -> Result<bool, Failure> {
        Ok(self
            .simulation()
            .map_err(Failure::final_one)?
            .residuals()
            .iter()
            .any(|residual| *residual > OPEN_LOOP_RESIDUAL))
    }

    /// Closes the loops.
    pub(crate) fn close(&mut self) -> Result<(), Failure> {
        self.state.parameters_changed = true;
        self.simulation().map_err(Failure::final_one)?;
        self.state.importer_state = None;
        Ok(())
    }

    /// The motion with the current parameters, at the importer's time and states.
    fn simulation(&mut self) -> Result<&mut Simulation, Failure> {
        let Self { model, token, state, interface, .. } = self;
        let set = &state.set;
        let value = |name: &str| set.get(name).copied().or_else(|| token.value(name));
        let message = |e: SimError| e.to_string();
        let is_running = state.phase.is_running();
        let simulation = match state.simulation.take() {
            Some(simulation) if is_running || !state.parameters_changed => simulation,
            _ => {
                state.parameters_changed = false;
                let new = Simulation::new(model, &value, token.settings, Some(token.step)).map_err(message)?;
                // An importer that integrates estimates its errors itself.
                if *interface == Interface::CoSimulation { new.watched().map_err(message)? } else { new }
            }
        };
        // The motion is kept, even if the following steps fail.
        let simulation = state.simulation.insert(simulation);
        if let (false, Some((t, states))) = (state.is_placed, &state.importer_state) {
            let (q, qd) = states.split_at(states.len() / 2);
            simulation.place(t - state.origin, q, qd).map_err(Failure::from_trial)?;
            state.is_placed = true;
        }
        if state.parameters_changed {
            simulation.replace(&value).map_err(message)?;
            state.parameters_changed = false;
        }
        Ok(simulation)
    }

    fn value_set(&self, name: &str) -> Option<f64> {
        self.state.set.get(name).copied().or_else(|| self.token.value(name))
    }

    fn variable(&self, reference: u32) -> Result<&Column, String> {
        self.variables.get(reference as usize).ok_or_else(|| format!("there is no variable with reference {reference}"))
    }
}
