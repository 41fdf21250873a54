//! Repetition of some of a kernel's steps by the plain functions.

use qrm_core::{Mechanism, RowLayout};

use crate::integrate::{Integrator, MethodSettings};
use crate::solve::{Solver, SolverStats};
use crate::state::State;

/// The intervals, in rows, at which steps are repeated: among the first rows, and later.
const SAMPLED: [u64; 2] = [32, 128];
/// The number of rows that count as the first ones.
const FIRST_ROWS: u64 = 1024;

/// Repeats some of the kernel's steps by the plain functions. These measure what the kernel does not: residuals before
/// the projection, and corrections of the coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    integrator: Integrator,
    /// A buffer for the two rows of such a step.
    pair: [State; 2],
}

impl Sampler {
    /// Begins with a run; `None` if no kernel makes its steps.
    pub(crate) fn new(
        mechanism: &dyn Mechanism,
        settings: &MethodSettings,
        first: &State,
        end_time: f64,
    ) -> Option<Self> {
        let integrator = settings
            .is_by_kernel()
            .then(|| Integrator::new(mechanism, *settings, first, end_time))
            .and_then(Result::ok)
            .filter(|integrator| integrator.rank() == first.multipliers.len())?;
        Some(Self { integrator, pair: [first.clone(), first.clone()] })
    }

    /// Repeats some of the steps between rows; the first row has the number `first`. `solver` records the results.
    pub(crate) fn follow(&mut self, mechanism: &dyn Mechanism, rows: &[f64], first: u64, solver: &mut Solver) {
        let [from, to] = &mut self.pair;
        let width = RowLayout { n: from.q.len(), m: from.multipliers.len() }.width();
        for (number, step) in (first..).zip(rows.windows(2 * width).step_by(width)) {
            if number % SAMPLED[usize::from(number >= FIRST_ROWS)] != 0 {
                continue;
            }
            from.read(step);
            self.integrator.solver_mut().stats = SolverStats::default();
            // If a step fails here, the plain functions had made it in the run too.
            if self.integrator.advance_by_functions(mechanism, from, step[width], to).is_ok() {
                solver.take_corrections_of(self.integrator.solver_mut());
            }
        }
    }
}
