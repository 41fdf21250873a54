//! The Gauss method of order 16, with its nodes in the lanes of vectors.

use qrm_core::{Convergence, GAUSS_NODES, GaussEnd, GaussRequest, GaussSteps, Mechanism, Width};

use super::adaptive::Adaptive;
use super::auto::Auto;
use super::dense_output::DenseOutput;
use super::dop853;
use super::method::Method;
use super::step_error::StepError;
use super::step_formula::{Accepted, Evaluator, StepFormula, Task};
use crate::state::State;

/// The Gauss method of order 16.
pub const GAUSS: &Method = &Method {
    name: "gauss",
    doc: "Gauss method of order 16 for a single run, not for stiff scenes; steps chosen by --tolerance",
    order: 16,
    is_for_stiff: false,
    needs_linearization: false,
    tableau: Some(&dop853::TABLEAU),
    formula: Some(|mechanism| Box::new(Gauss::new(mechanism))),
};

/// The number of accepted steps that compensate an attempt whose iteration does not converge. In stiff motions such
/// attempts occur every few steps.
const FAILURE: u32 = 8;
/// The error of such an attempt: the step is repeated with half the length.
const DIVERGED: f64 = 50.0;
/// The count of failures at which the method is given up.
const GIVEN_UP: u32 = 80;

/// The largest error of the polynomial's accelerations at the ends of a step, in multiples of the root of the
/// tolerance, as changes of rates. A larger error means that a load between an end and the nearest node was missed.
const ENDS: f64 = 20.0;

/// Steps of the Gauss method, with `auto` as the fallback.
#[derive(Clone, Debug)]
struct Gauss {
    /// The steps; `None` where the method does not suit the scene, the processor or the motion.
    steps: Option<Box<dyn GaussSteps>>,
    fallback: Auto,
    /// The work of the loads without potential in the last attempt; `None` if `auto` made it.
    attempted: Option<f64>,
    /// The work of the loads without potential in the last step; `None` if `auto` made it.
    work: Option<f64>,
    /// The count of failures: attempts that do not converge raise it, accepted steps lower it.
    failures: u32,
    /// The accelerations of a step's polynomials at its beginning and its end.
    extrapolated: [Vec<f64>; 2],
}

impl Gauss {
    fn new(mechanism: &dyn Mechanism) -> Self {
        let n = mechanism.description().coordinates.len();
        Self {
            steps: [Width::Eight, Width::Four].into_iter().find_map(|width| mechanism.gauss_steps(width)),
            fallback: Auto::new(n),
            attempted: None,
            work: None,
            failures: 0,
            extrapolated: [vec![0.0; n], vec![0.0; n]],
        }
    }
}

impl StepFormula for Gauss {
    fn order(&self) -> i32 {
        // Steps of the Gauss method are controlled by the error of their polynomials.
        if self.attempted.is_some() { 8 } else { self.fallback.order() }
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
        self.attempted = None;
        if let Some(steps) = &mut self.steps
            && !evaluator.solver.is_redundant()
        {
            let request = GaussRequest { h, tolerance: task.tolerance, is_within_last_step: false };
            let [begin, end] = &mut self.extrapolated;
            let end = GaussEnd { q: &mut to.q, qd: &mut to.qd, extrapolated: [begin, end] };
            if let Some(estimate) = steps.step(&request, &from.as_ref(), end) {
                *evaluator.evaluations += u64::from(estimate.iterations) * GAUSS_NODES as u64;
                self.attempted = Some(estimate.work);
                if estimate.convergence == Convergence::Diverged {
                    self.failures += FAILURE;
                    if self.failures >= GIVEN_UP {
                        self.steps = None;
                    }
                    return Ok(DIVERGED);
                }
                if estimate.error <= 1.0 {
                    self.failures = self.failures.saturating_sub(1);
                    to.t = task.end_of_step(from.t, h);
                    *evaluator.evaluations += 1;
                    evaluator.solver.projected(mechanism, task.projection, to)?;
                    let [begin, end] = &self.extrapolated;
                    let unseen = unseen(from, begin).max(unseen(to, end)) * h / (ENDS * task.tolerance.sqrt());
                    if unseen > 1.0 {
                        return Ok(unseen);
                    }
                }
                return Ok(estimate.error);
            }
        }
        self.fallback.attempt(mechanism, from, h, task, evaluator, to)
    }

    fn state_inside(
        &mut self,
        mechanism: &dyn Mechanism,
        step: &mut DenseOutput,
        task: &Task,
        evaluator: &mut Evaluator,
        to: &mut State,
    ) -> Result<(), StepError> {
        let (Some(_), Some(steps)) = (self.work, &mut self.steps) else {
            return self.fallback.state_inside(mechanism, step, task, evaluator, to);
        };
        // Inside the step the polynomials are less accurate than its end, so a shorter step is made.
        let from = &step.from;
        let request = GaussRequest { h: to.t - from.t, tolerance: task.tolerance, is_within_last_step: true };
        let [begin, end] = &mut self.extrapolated;
        let end = GaussEnd { q: &mut to.q, qd: &mut to.qd, extrapolated: [begin, end] };
        if let Some(estimate) = steps.step(&request, &from.as_ref(), end) {
            *evaluator.evaluations += u64::from(estimate.iterations) * GAUSS_NODES as u64 + 1;
            if estimate.convergence == Convergence::Converged {
                return evaluator.solver.projected(mechanism, task.projection, to);
            }
        }
        // The kernel is not valid at some node; `auto` evaluates other positions.
        let task = Task { end_time: to.t, ..*task };
        let mut other = Adaptive::new(mechanism, Box::new(self.fallback.clone()), task, from, evaluator.solver)?;
        other.advance_to(mechanism, task.end_time, evaluator.solver, to, None)?;
        *evaluator.evaluations += other.counts().evaluations;
        Ok(())
    }

    fn load_work(
        &mut self,
        mechanism: &dyn Mechanism,
        step: &mut DenseOutput,
        task: &Task,
        evaluator: &mut Evaluator,
        room: &mut State,
    ) -> Result<f64, StepError> {
        self.work.map_or_else(|| self.fallback.load_work(mechanism, step, task, evaluator, room), Ok)
    }

    fn accepted(&mut self, mechanism: &dyn Mechanism, from: &State, to: &State) -> Accepted {
        self.work = self.attempted;
        if self.work.is_some() {
            Accepted::default()
        } else {
            Accepted { is_fallback: true, ..self.fallback.accepted(mechanism, from, to) }
        }
    }

    fn boxed_clone(&self) -> Box<dyn StepFormula> {
        Box::new(self.clone())
    }
}

/// The largest difference between accelerations and those of the polynomials, relative to the size of the rates.
fn unseen(at: &State, extrapolated: &[f64]) -> f64 {
    let differences = at.qdd.iter().zip(extrapolated).map(|(own, other)| (own - other).abs());
    differences.zip(&at.qd).map(|(difference, rate)| difference / (1.0 + rate.abs())).fold(0.0, f64::max)
}
