//! Events: functions of the state that rise through zero.

mod bounds;
mod end_time;
mod largest;
pub(crate) mod location;
mod rows;
mod search;

use std::cell::RefCell;

pub(crate) use bounds::EventBounds;
pub(crate) use largest::Largest;
use qrm_core::{Mechanism, Tape, TapeEvaluator};
pub(crate) use search::{Maximum, Reached};

use crate::solve::Solver;
use crate::state::State;

/// Whether events are looked for between rows.
const HAS_BOUNDS: bool = cfg!(feature = "events");

/// The distance from zero within which the largest value of an event is looked for, in parts of its value at the start
/// and of its arguments.
const NEARNESS: f64 = 1e-4;
/// The largest ratio of an error to its estimate.
pub(crate) const POSSIBLE: f64 = 3.0;

/// The end of a motion.
#[derive(Clone, Copy, Debug)]
pub enum End<'a> {
    /// At a time, in s.
    Time(f64),
    /// When the event of a tape rises through zero. Its parameters are those of the mechanism.
    Event(&'a Tape),
}

/// The event function of a request, or else of the scene.
pub(crate) struct EventFunction<'a> {
    evaluator: Option<RefCell<TapeEvaluator<'a, Vec<f64>>>>,
    /// Completes states, if the function takes accelerations or multipliers.
    solver: Option<RefCell<Solver>>,
    /// Bounds with the parameters of the mechanism; made on first use.
    bounds: RefCell<Option<EventBounds>>,
    /// How far below zero it counts as negative between rows.
    nearness: f64,
}

impl<'a> EventFunction<'a> {
    /// `None` if the motion ends at a time.
    pub(crate) fn new(mechanism: &dyn Mechanism, end: Option<End<'a>>) -> Option<Self> {
        let (evaluator, takes_forces) = match end {
            Some(End::Time(_)) => return None,
            Some(End::Event(tape)) => {
                let evaluator = TapeEvaluator::with_parameters(tape, mechanism.parameters());
                (Some(RefCell::new(evaluator)), tape.event_takes_forces())
            }
            None => (None, mechanism.tape().is_none_or(Tape::event_takes_forces)),
        };
        let solver = takes_forces.then(|| RefCell::new(Solver::new(mechanism)));
        Some(Self { evaluator, solver, bounds: RefCell::default(), nearness: 0.0 })
    }

    /// Whether it is not the scene's.
    pub(crate) fn is_of_request(&self) -> bool {
        self.evaluator.is_some()
    }

    /// Whether it depends on accelerations or multipliers.
    pub(crate) fn takes_forces(&self) -> bool {
        self.solver.is_some()
    }

    /// Sets the value at the start, relative to which values are near zero.
    pub(crate) fn set_start(&mut self, value: f64) {
        self.nearness = NEARNESS * value.abs();
        if let Some(bounds) = self.bounds.get_mut() {
            bounds.set_nearness(self.nearness);
        }
    }

    /// Whether the event comes near zero at a state.
    pub(crate) fn is_near_zero(&self, mechanism: &dyn Mechanism, at: &State) -> bool {
        self.with_bounds(mechanism, |bounds| bounds.is_near_zero(at)).unwrap_or(true)
    }

    /// Sets the parameters to those of another mechanism of the same scene.
    pub(crate) fn set_parameters(&self, mechanism: &dyn Mechanism) {
        self.bounds.borrow_mut().take_if(|bounds| !bounds.hold_for(mechanism));
        if let Some(evaluator) = &self.evaluator {
            let parameters = mechanism.parameters();
            evaluator.borrow_mut().set_parameters(|i| Some(parameters[i]));
        }
    }

    /// Takes over the bounds of another event of the same request where they hold for the mechanism, or makes them for
    /// others.
    pub(crate) fn share_bounds(&self, mechanism: &dyn Mechanism, known: &mut Option<EventBounds>) {
        if self.bounds.borrow().is_some() {
            return;
        }
        known.take_if(|known| !known.hold_for(mechanism));
        if known.is_none() {
            *known = self.with_bounds(mechanism, |bounds| bounds.clone());
        } else {
            self.bounds.borrow_mut().clone_from(known);
        }
    }

    /// The value at a state; `None` if the scene has no event.
    pub(crate) fn value(&self, mechanism: &dyn Mechanism, at: &State) -> Option<f64> {
        match &self.evaluator {
            Some(evaluator) => evaluator.borrow_mut().event(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers),
            None => mechanism.event(&at.as_ref()),
        }
    }

    /// The value at time, coordinates and rates of a state whose accelerations and multipliers are not known.
    pub(crate) fn value_at_position(&self, mechanism: &dyn Mechanism, at: &State) -> Option<f64> {
        let Some(solver) = &self.solver else { return self.value(mechanism, at) };
        let mut at = at.clone();
        solver.borrow_mut().complete(mechanism, &mut at).ok()?;
        self.value(mechanism, &at)
    }

    /// Calls a function with the bounds of the event; `None` if the mechanism has no tape, or its tape no event.
    fn with_bounds<T>(&self, mechanism: &dyn Mechanism, f: impl FnOnce(&mut EventBounds) -> T) -> Option<T> {
        if !HAS_BOUNDS {
            return None;
        }
        let mut bounds = self.bounds.borrow_mut();
        if bounds.is_none() {
            let own = self.evaluator.as_ref().map(|evaluator| evaluator.borrow().tape());
            *bounds = EventBounds::new(own.or_else(|| mechanism.tape())?, mechanism, self.nearness);
        }
        bounds.as_mut().map(f)
    }
}
