//! The energy balance over steps whose length is chosen by a tolerance.

use qrm_core::Mechanism;

use super::corner::Corner;
use super::dense_output::DenseOutput;
use super::step_formula::{Evaluator, StepFormula, Task};
use crate::solve::Solver;
use crate::state::State;

/// The energy at the ends of steps, compared with the work of the loads without potential.
#[derive(Clone, Debug)]
pub(super) struct StepBalance {
    /// Energy at the start.
    energy: f64,
    /// Work of the loads without potential since the start.
    work: f64,
    /// The largest difference between the change of the energy and the work, at the end of any step.
    pub(super) imbalance: f64,
    /// Whether a load without potential had power in any step.
    pub(super) has_power: bool,
}

impl StepBalance {
    /// Begins at a state.
    pub(super) fn new(mechanism: &dyn Mechanism, first: &State) -> Self {
        Self { energy: first.energy(mechanism), work: 0.0, imbalance: 0.0, has_power: false }
    }

    /// Adds the work on the way across a corner.
    pub(super) fn cross(&mut self, mechanism: &dyn Mechanism, from: &State, corner: Corner) {
        self.work += from.power(mechanism) * (corner.just_after() - from.t);
    }

    /// Adds a step; the power inside it is integrated by its formula. `room` is a buffer for a state.
    pub(super) fn add(
        &mut self,
        mechanism: &dyn Mechanism,
        formula: &mut dyn StepFormula,
        (task, solver): (&Task, &mut Solver),
        step: &mut DenseOutput,
        room: &mut State,
    ) {
        let [at_begin, at_end] = [&step.from, &step.to].map(|at| at.power(mechanism));
        if at_begin != 0.0 || at_end != 0.0 {
            // These evaluations serve observers, and do not count for the method.
            let mut evaluator = Evaluator { evaluations: &mut 0, solver };
            let found = formula.load_work(mechanism, step, task, &mut evaluator, room);
            // If the power inside is unknown, the power at the ends is used.
            let by_ends = 0.5 * (step.to.t - step.from.t) * (at_begin + at_end);
            self.work += found.ok().filter(|work| work.is_finite()).unwrap_or(by_ends);
            self.has_power = true;
        }
        self.imbalance = self.imbalance.max((step.to.energy(mechanism) - self.energy - self.work).abs());
    }
}
