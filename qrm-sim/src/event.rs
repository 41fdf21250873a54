//! Events: functions of the state that rise through zero.

pub(crate) mod location;

use std::cell::RefCell;

use qrm_core::{Mechanism, Tape, TapeEvaluator};

use crate::solve::Solver;
use crate::state::State;

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
        Some(Self { evaluator, solver: takes_forces.then(|| RefCell::new(Solver::new(mechanism))) })
    }

    /// Whether it is not the scene's.
    pub(crate) fn is_of_request(&self) -> bool {
        self.evaluator.is_some()
    }

    /// Whether it depends on accelerations or multipliers.
    pub(crate) fn takes_forces(&self) -> bool {
        self.solver.is_some()
    }

    /// Sets the parameters to those of another mechanism of the same scene.
    pub(crate) fn set_parameters(&self, mechanism: &dyn Mechanism) {
        if let Some(evaluator) = &self.evaluator {
            let parameters = mechanism.parameters();
            evaluator.borrow_mut().set_parameters(|i| Some(parameters[i]));
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
}
