//! The pair of order 8 with estimates of order 5 and 3, and its dense output of order 7.

use qrm_core::dop853::{DENSE, ERROR_3, ERROR_5, NODES, ROWS};
use qrm_core::{Mechanism, StateMut, StepEstimate, StepMut, StepRequest};

use super::dense_output::DenseOutput;
use super::explicit::Explicit;
use super::method::Method;
use super::step_error::StepError;
use super::step_formula::{Accepted, Evaluator, StepFormula, Task};
use super::tableau::Tableau;
use crate::state::State;

/// The Dormand-Prince pair of order 8.
pub const DOP853: &Method = &Method {
    name: "dop853",
    doc: "Dormand-Prince pair of order 8, steps chosen by --tolerance",
    order: 8,
    is_for_stiff: false,
    needs_linearization: false,
    tableau: Some(&TABLEAU),
    formula: Some(|mechanism| Box::new(Dop853::new(mechanism.description().coordinates.len()))),
};

/// Dormand and Prince's method of order 8, with the error estimates and the dense output of E. Hairer, S. P. Nørsett
/// and G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993, II.5 and II.6 (their code DOP853).
pub(super) static TABLEAU: Tableau = Tableau {
    stages: 12,
    order: 8,
    beta: 0.0,
    nodes: &NODES,
    rows: &ROWS,
    weights: ROWS[12],
    errors: &[ERROR_5, ERROR_3],
    dense: &DENSE,
    error: |[fifth, third], h, count| {
        let denominator = fifth + 0.01 * third;
        if denominator > 0.0 { h.abs() * fifth / (denominator * count).sqrt() } else { 0.0 }
    },
};

/// Steps by the kernel, or by the plain functions where the kernel fails.
#[derive(Clone, Debug)]
pub(super) struct Dop853 {
    plain: Explicit,
    /// The last step of the kernel; `None` if the plain functions made the last step.
    by_kernel: Option<StepEstimate>,
    /// A buffer for the higher coefficients of its dense output.
    dense: Vec<f64>,
    /// Whether they are known.
    is_dense: bool,
}

impl Dop853 {
    pub(super) fn new(n: usize) -> Self {
        let dense = vec![0.0; 2 * DENSE.len() * n];
        Self { plain: Explicit::new(&TABLEAU, n), by_kernel: None, dense, is_dense: false }
    }

    /// An estimate of the fastest rate of the motion times the length of the last step.
    pub(super) fn stiffness(&self, from: &State, to: &State) -> f64 {
        self.by_kernel.map_or_else(|| self.plain.stiffness(from, to), |estimate| estimate.stiffness)
    }

    /// Makes a step by the kernel; `None` if it cannot.
    fn attempt_by_kernel(
        &mut self,
        mechanism: &dyn Mechanism,
        (from, h): (&State, f64),
        task: &Task,
        evaluator: &mut Evaluator,
        to: &mut State,
    ) -> Option<StepEstimate> {
        if !evaluator.solver.projects_by_kernel(task.projection) {
            return None;
        }
        let request = StepRequest { h, tolerance: task.tolerance, residual: task.projection.1.residual };
        let dense = if self.is_dense { &mut self.dense[..] } else { &mut [] };
        let end = StateMut { q: &mut to.q, qd: &mut to.qd, qdd: &mut to.qdd, multipliers: &mut to.multipliers };
        let step = StepMut { end, corrections: &mut evaluator.solver.corrections, dense };
        let estimate = mechanism.dop853_step(&request, &from.as_ref(), step)?;
        self.is_dense &= estimate.error <= 1.0;
        *evaluator.evaluations += 12;
        Some(estimate)
    }
}

impl StepFormula for Dop853 {
    fn order(&self) -> i32 {
        self.plain.order()
    }

    fn beta(&self) -> f64 {
        self.plain.beta()
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
        self.is_dense = from.t + h > task.dense_from;
        self.by_kernel = self.attempt_by_kernel(mechanism, (from, h), task, evaluator, to);
        let Some(estimate) = self.by_kernel else {
            return self.plain.attempt(mechanism, from, h, task, evaluator, to);
        };
        to.t = task.end_of_step(from.t, h);
        to.corrections = estimate.corrections;
        if estimate.error <= 1.0 {
            evaluator.solver.stats.take_residual(estimate.residual);
        }
        Ok(estimate.error)
    }

    fn complete_dense_output(
        &mut self,
        mechanism: &dyn Mechanism,
        dense_output: &mut DenseOutput,
        task: &Task,
        evaluator: &mut Evaluator,
    ) -> Result<(), StepError> {
        if self.by_kernel.is_some() && dense_output.lacks(&TABLEAU) {
            if !self.is_dense {
                // Repeats the step to the same end.
                let h = dense_output.to.t - dense_output.from.t;
                let mut to = dense_output.to.clone();
                self.is_dense = true;
                self.by_kernel = self.attempt_by_kernel(mechanism, (&dense_output.from, h), task, evaluator, &mut to);
                if self.by_kernel.is_none() {
                    self.plain.attempt(mechanism, &dense_output.from, h, task, evaluator, &mut to)?;
                }
            }
            if self.is_dense && self.by_kernel.is_some() {
                *evaluator.evaluations += 3;
                dense_output.complete(&self.dense);
            }
        }
        // The plain functions complete the rest.
        self.plain.complete_dense_output(mechanism, dense_output, task, evaluator)
    }

    fn accepted(&mut self, _: &dyn Mechanism, _: &State, _: &State) -> Accepted {
        Accepted::default()
    }

    fn boxed_clone(&self) -> Box<dyn StepFormula> {
        Box::new(self.clone())
    }
}
