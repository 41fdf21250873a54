//! Steps by an explicit Runge-Kutta method.

use std::ops::Range;

use qrm_core::Mechanism;
use qrm_core::dop853::Row;

use super::dense_output::{DenseOutput, Stages};
use super::step_error::StepError;
use super::step_formula::{Accepted, Evaluator, StepFormula, Task};
use super::tableau::Tableau;
use crate::solve::{Projection, ProjectionTolerance, Solver};
use crate::state::State;

/// An explicit Runge-Kutta method with the stages of its last step.
#[derive(Clone, Debug)]
pub(super) struct Explicit {
    pub(super) tableau: &'static Tableau,
    stages: Stages,
    q: Vec<f64>,
    qd: Vec<f64>,
    /// Sums over stages.
    rate: Vec<f64>,
    acceleration: Vec<f64>,
    multipliers: Vec<f64>,
}

impl Explicit {
    pub(super) fn new(tableau: &'static Tableau, n: usize) -> Self {
        let zero = || vec![0.0; n];
        let stages = Stages::new(tableau, n);
        Self { tableau, stages, q: zero(), qd: zero(), rate: zero(), acceleration: zero(), multipliers: Vec::new() }
    }

    /// Makes a step to `t` by the robust accelerations, and projects its end.
    ///
    /// # Errors
    /// The step could not be made.
    pub(super) fn step(
        &mut self,
        mechanism: &dyn Mechanism,
        solver: &mut Solver,
        projection: (Projection, ProjectionTolerance),
        (from, t): (&State, f64),
        to: &mut State,
    ) -> Result<(), StepError> {
        let h = t - from.t;
        self.begin(from);
        for stage in 1..self.tableau.stages {
            self.argument(from, h, self.tableau.rows[stage]);
            let at = from.t + self.tableau.nodes[stage] * h;
            let qdd = &mut self.stages.accelerations[stage];
            solver.robust_accelerations(mechanism, at, (&self.q, &self.qd), (qdd, &mut self.multipliers))?;
            self.stages.rates[stage].copy_from_slice(&self.qd);
        }
        self.argument(from, h, self.tableau.weights);
        // The mass matrix of the last stage, which is close to the end of the step.
        solver.take_metric();
        self.finish(to, t);
        solver.projected_by_functions(mechanism, projection, to)
    }

    fn begin(&mut self, from: &State) {
        self.multipliers.resize(from.multipliers.len(), 0.0);
        self.stages.rates[0].copy_from_slice(&from.qd);
        self.stages.accelerations[0].copy_from_slice(&from.qdd);
    }

    /// Coordinates and rates at a step of length `h`, with the sums of a row.
    fn argument(&mut self, from: &State, h: f64, row: Row) {
        let Self { stages, q, qd, rate, acceleration, .. } = self;
        stages.sum(row, rate, acceleration);
        for i in 0..q.len() {
            q[i] = from.q[i] + h * rate[i];
            qd[i] = from.qd[i] + h * acceleration[i];
        }
    }

    fn finish(&self, to: &mut State, t: f64) {
        to.t = t;
        to.q.copy_from_slice(&self.q);
        to.qd.copy_from_slice(&self.qd);
    }

    /// Evaluates stages.
    fn evaluate(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        h: f64,
        stages: Range<usize>,
        evaluator: &mut Evaluator,
    ) -> Result<(), StepError> {
        for stage in stages {
            self.argument(from, h, self.tableau.rows[stage]);
            let t = from.t + self.tableau.nodes[stage] * h;
            let qdd = &mut self.stages.accelerations[stage];
            evaluator.solver.accelerations(mechanism, t, (&self.q, &self.qd), (qdd, &mut self.multipliers))?;
            self.stages.rates[stage].copy_from_slice(&self.qd);
            *evaluator.evaluations += 1;
        }
        Ok(())
    }

    /// The estimated error of a step against the tolerance.
    fn error(&mut self, mechanism: &dyn Mechanism, task: &Task, from: &State, to: (&[f64], &[f64]), h: f64) -> f64 {
        let Self { tableau, stages, rate, acceleration, .. } = self;
        let mut sums = [0.0; 2];
        for (sum, row) in sums.iter_mut().zip(tableau.errors) {
            stages.sum(row, rate, acceleration);
            for i in 0..rate.len() {
                let [of_q, of_qd] = task.error_scales(mechanism, i, from, to);
                *sum += (rate[i] / of_q).powi(2) + (acceleration[i] / of_qd).powi(2);
            }
        }
        (tableau.error)(sums, h, 2.0 * rate.len().max(1) as f64)
    }

    /// Estimates the fastest rate of the motion times the length of the step: the difference of the derivatives at the
    /// last stage and at the end of the step, over the distance of the two (Hairer, Wanner II, IV.2). Rates are
    /// weighted by the change that they cause in a step.
    pub(super) fn stiffness(&self, from: &State, to: &State) -> f64 {
        let h = to.t - from.t;
        let (last, n) = (self.tableau.stages - 1, from.q.len());
        let (mut rate, mut acceleration) = (vec![0.0; n], vec![0.0; n]);
        self.stages.sum(self.tableau.rows[last], &mut rate, &mut acceleration);
        // Distances below rounding errors carry no information.
        let (mut apart, mut differ) = (f64::EPSILON * f64::EPSILON, 0.0);
        for i in 0..n {
            let dq = to.q[i] - (from.q[i] + h * rate[i]);
            let dv = h * (to.qd[i] - (from.qd[i] + h * acceleration[i]));
            let da = h * h * (to.qdd[i] - self.stages.accelerations[last][i]);
            apart += dq * dq + dv * dv;
            differ += dv * dv + da * da;
        }
        (differ / apart).sqrt()
    }
}

impl StepFormula for Explicit {
    fn order(&self) -> i32 {
        self.tableau.order
    }

    fn beta(&self) -> f64 {
        self.tableau.beta
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
        self.begin(from);
        self.evaluate(mechanism, from, h, 1..self.tableau.stages, evaluator)?;
        self.argument(from, h, self.tableau.weights);
        self.finish(to, task.end_of_step(from.t, h));
        // Some estimates need the end of the step; the others avoid its evaluation.
        let end = self.tableau.stages;
        let needs_end = self.tableau.errors.iter().any(|row| row.iter().any(|(stage, _)| *stage == end));
        let early = (!needs_end).then(|| self.error(mechanism, task, from, (&to.q, &to.qd), h));
        if let Some(error) = early.filter(|error| !(*error <= 1.0)) {
            return Ok(error);
        }
        evaluator.solver.projected(mechanism, task.projection, to)?;
        *evaluator.evaluations += 1;
        self.stages.rates[end].copy_from_slice(&to.qd);
        self.stages.accelerations[end].copy_from_slice(&to.qdd);
        Ok(early.unwrap_or_else(|| self.error(mechanism, task, from, (&to.q, &to.qd), h)))
    }

    fn complete_dense_output(
        &mut self,
        mechanism: &dyn Mechanism,
        dense_output: &mut DenseOutput,
        _task: &Task,
        evaluator: &mut Evaluator,
    ) -> Result<(), StepError> {
        if !dense_output.lacks(self.tableau) {
            return Ok(());
        }
        let h = dense_output.to.t - dense_output.from.t;
        self.evaluate(mechanism, &dense_output.from, h, self.tableau.stages + 1..self.tableau.rows.len(), evaluator)?;
        dense_output.complete_by(self.tableau, &self.stages);
        Ok(())
    }

    fn accepted(&mut self, _: &dyn Mechanism, _: &State, _: &State) -> Accepted {
        Accepted::default()
    }

    fn boxed_clone(&self) -> Box<dyn StepFormula> {
        Box::new(self.clone())
    }
}
