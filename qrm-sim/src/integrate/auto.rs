//! Explicit steps where they suffice, implicit ones where the motion is stiff.

use qrm_core::Mechanism;

use super::dense_output::DenseOutput;
use super::dop853::{self, Dop853};
use super::implicit::Implicit;
use super::method::Method;
use super::step_error::StepError;
use super::step_formula::{Accepted, Evaluator, StepFormula, Task};
use crate::solve::{Linearization, Response, dot};
use crate::state::State;

/// The method for all scenes, stiff or not.
pub const AUTO: &Method = &Method {
    name: "auto",
    doc: "dop853, and rodas where springs or dampers are stiff; steps chosen by --tolerance",
    order: 8,
    is_for_stiff: true,
    needs_linearization: false,
    tableau: Some(&dop853::TABLEAU),
    formula: Some(|mechanism| Box::new(Auto::new(mechanism.description().coordinates.len()))),
};

/// The product of fastest rate and length above which stability limits a step of the explicit pair.
const STABILITY_BOUND: f64 = 5.0;
/// The number of consecutive steps that trigger a change of method.
const DECISIVE: u32 = 15;
/// The product of fastest rate and length below which an implicit step could have been explicit.
const NOT_STIFF: f64 = 2.0;

/// Both methods, and the evidence for a change.
#[derive(Clone, Debug)]
pub(super) struct Auto {
    explicit: Dop853,
    is_implicit: bool,
    /// Whether the last accepted step was implicit.
    was_implicit: bool,
    /// The number of consecutive steps that favoured the other method.
    favours_change: u32,
    /// The number of consecutive steps since then that did not.
    quiet: u32,
    /// The direction in which the equations of motion react most strongly: coordinates and rates.
    fastest: (Vec<f64>, Vec<f64>),
}

impl Auto {
    pub(super) fn new(n: usize) -> Self {
        // Any direction works that is not orthogonal to the fastest one by chance.
        let start: Vec<f64> = (0..n).map(|i| 1.0 / (1.0 + i as f64)).collect();
        Self {
            explicit: Dop853::new(n),
            is_implicit: false,
            was_implicit: false,
            favours_change: 0,
            quiet: 0,
            fastest: (start.clone(), start),
        }
    }

    /// Estimates the fastest rate of the linearized equations by two more steps of the power method.
    fn rate(&mut self, mechanism: &dyn Mechanism, at: &State) -> f64 {
        let Some(response) = Response::exact(mechanism, at) else { return f64::INFINITY };
        // Every second step amplifies by the square of a frequency, the others by less than one.
        let mut growth = 1.0;
        for _ in 0..2 {
            let (u, w) = &self.fastest;
            let Some(change) = response.accelerations(u, w) else { return f64::INFINITY };
            let size = (dot(w, w) + dot(&change, &change)).sqrt();
            if !(size > 0.0) {
                return 0.0;
            }
            growth *= size / (dot(u, u) + dot(w, w)).sqrt();
            let scaled = |x: &[f64]| x.iter().map(|x| x / size).collect();
            self.fastest = (scaled(w), scaled(&change));
        }
        growth.sqrt()
    }
}

impl StepFormula for Auto {
    fn order(&self) -> i32 {
        if self.is_implicit { Implicit.order() } else { self.explicit.order() }
    }

    fn beta(&self) -> f64 {
        0.0
    }

    fn attempt(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        h: f64,
        task: &Task,
        evaluator: &mut Evaluator,
        to: &mut State,
    ) -> Result<f64, StepError> {
        if self.is_implicit {
            Implicit.attempt(mechanism, from, h, task, evaluator, to)
        } else {
            self.explicit.attempt(mechanism, from, h, task, evaluator, to)
        }
    }

    fn accepted(&mut self, mechanism: &dyn Mechanism, from: &State, to: &State) -> Accepted {
        let is_implicit = self.is_implicit;
        self.was_implicit = is_implicit;
        let favours_change = if is_implicit {
            self.rate(mechanism, to) * (to.t - from.t) < NOT_STIFF
        } else {
            self.explicit.stiffness(from, to) > STABILITY_BOUND
        };
        if favours_change {
            (self.favours_change, self.quiet) = (self.favours_change + 1, 0);
        } else {
            self.quiet += 1;
            if self.quiet == 6 {
                self.favours_change = 0;
            }
        }
        let is_decided = self.favours_change >= DECISIVE;
        if is_decided && Linearization::is_known(mechanism) {
            (self.is_implicit, self.favours_change, self.quiet) = (!is_implicit, 0, 0);
        }
        let is_stability_bound = is_decided && !Linearization::is_known(mechanism);
        Accepted { is_implicit, is_stability_bound, ..Accepted::default() }
    }

    fn complete_dense_output(
        &mut self,
        mechanism: &dyn Mechanism,
        dense_output: &mut DenseOutput,
        task: &Task,
        evaluator: &mut Evaluator,
    ) -> Result<(), StepError> {
        if self.was_implicit {
            Ok(())
        } else {
            self.explicit.complete_dense_output(mechanism, dense_output, task, evaluator)
        }
    }

    fn boxed_clone(&self) -> Box<dyn StepFormula> {
        Box::new(self.clone())
    }
}
