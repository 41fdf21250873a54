//! Steps whose length is chosen by a tolerance, each followed by a projection; rows can have any time.

mod step;

use qrm_core::Mechanism;

use super::companion_limit::CompanionLimit;
use super::corner::Corner;
use super::corners::Corners;
use super::dense_output::DenseOutput;
use super::first_step::first_step;
use super::step_balance::StepBalance;
use super::step_control::StepControl;
use super::step_error::StepError;
use super::step_formula::{Accepted, Evaluator, StepFormula, Task};
use super::transitions::Transitions;
use crate::solve::Solver;
use crate::state::State;

/// Keeps a state between rows.
pub(super) type KeepState<'a> = dyn FnMut(&State) + 'a;

/// The states between rows that are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum IntermediateRows {
    /// The states at the ends of steps.
    StepEnds,
    /// The states at the ends of steps, and some inside steps that are long compared with the time between rows.
    Samples,
}

/// A motion whose steps are chosen by a tolerance.
#[derive(Clone, Debug)]
pub(super) struct Adaptive {
    formula: Box<dyn StepFormula>,
    task: Task,
    /// The corners of the equations of motion; `None` if there are none.
    corners: Option<Corners>,
    /// The number of attempts above which the run is given up.
    most_attempts: u64,
    /// The corner at which the last step ended.
    corner: Option<Corner>,
    /// Smooth transitions of forces; `None` if there are none.
    transitions: Option<Box<Transitions>>,
    /// The last step.
    dense_output: DenseOutput,
    /// The end of the current step.
    next: State,
    control: StepControl,
    counts: Counts,
    /// The number of requested rows.
    rows: u64,
    /// The time of the last requested row.
    asked: f64,
    balance: StepBalance,
    /// The begin and end of each accepted step since the last `forget_steps`, and their kinds.
    steps: Vec<[f64; 2]>,
    kinds: Vec<Accepted>,
    /// The limit of the steps, if this is a companion run.
    companion_limit: CompanionLimit,
}

/// The numbers of steps and evaluations of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Accepted steps.
    pub accepted: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the accelerations.
    pub evaluations: u64,
    /// Steps by an implicit method.
    pub implicit: u64,
    /// Explicit steps limited by stability instead of accuracy.
    pub stability_bound: u64,
    /// Steps made by `auto` where the chosen method is not applicable.
    pub fallback: u64,
}

/// The largest number of steps of a motion, in addition to `MAX_STEPS_PER_ROW` for each row.
const MAX_STEPS: u64 = 1_000_000;
/// The number of steps that each row adds to `MAX_STEPS`.
const MAX_STEPS_PER_ROW: u64 = 1000;
/// The number of steps that a state between rows may take in addition to those of the run.
const FEW: u64 = 100;
/// The number of steps after which progress is checked.
const CHECKED: u64 = 5000;
/// The smallest fraction of the way to the next row that counts as progress.
const MIN_PROGRESS: f64 = 1e-3;
/// The number of states between rows in a step.
const SAMPLES: f64 = 8.0;
/// The largest number of states between rows in a step as long as that of the scene: near singular positions steps are
/// tiny.
const SAMPLES_PER_SCENE_STEP: f64 = 64.0;

impl Adaptive {
    /// Begins at a state; estimates the first step from the derivatives there.
    ///
    /// # Errors
    /// The accelerations near the start are not determined.
    pub(super) fn new(
        mechanism: &dyn Mechanism,
        formula: Box<dyn StepFormula>,
        task: Task,
        first: &State,
        solver: &mut Solver,
    ) -> Result<Self, StepError> {
        let mut counts = Counts::default();
        let mut evaluator = Evaluator { evaluations: &mut counts.evaluations, solver };
        let h = first_step(mechanism, (&task, formula.order()), first, &mut evaluator)?;
        Ok(Self {
            formula,
            task,
            corners: Corners::new(mechanism),
            most_attempts: u64::MAX,
            corner: None,
            transitions: Transitions::new(mechanism),
            dense_output: DenseOutput::new(first.clone(), first.clone()),
            next: first.clone(),
            control: StepControl::new(h),
            counts,
            rows: 0,
            asked: first.t,
            balance: StepBalance::new(mechanism, first),
            steps: Vec::new(),
            kinds: Vec::new(),
            companion_limit: CompanionLimit::default(),
        })
    }

    /// Creates a copy that can go back to a state in the last step, or before it.
    #[must_use]
    pub(super) fn restarted(&self, from: &State) -> Self {
        let mut again = self.clone();
        again.asked = from.t;
        if from.t < self.dense_output.from.t {
            again.dense_output = DenseOutput::new(from.clone(), from.clone());
            again.most_attempts = 2 * self.attempts() + FEW;
            again.corner = None;
            if let Some(corners) = &mut again.corners {
                corners.forget();
            }
        }
        again
    }

    /// Gives the motion up after a number of attempts from here.
    pub(super) fn limit_attempts(&mut self, most: u64) {
        self.most_attempts = self.most_attempts.min(self.attempts().saturating_add(most));
    }

    /// The numbers of steps and evaluations.
    pub(super) fn counts(&self) -> Counts {
        self.counts
    }

    /// The begin and end of each accepted step since the last `forget_steps`.
    pub(super) fn steps(&self) -> &[[f64; 2]] {
        &self.steps
    }

    /// The kinds of these steps.
    pub(super) fn kinds(&self) -> &[Accepted] {
        &self.kinds
    }

    /// Forgets the recorded steps.
    pub(super) fn forget_steps(&mut self) {
        self.steps.clear();
        self.kinds.clear();
    }

    /// Limits the steps by those of another run at the same time; `steps` are the next ones.
    pub(super) fn limit_steps_by(&mut self, steps: &[[f64; 2]]) {
        self.companion_limit.extend(steps);
    }

    /// The largest difference between the change of the energy and the work of the loads without potential, over the
    /// ends of all steps.
    pub(super) fn imbalance(&self) -> f64 {
        self.balance.imbalance
    }

    /// Whether no load without potential has had power at the ends of steps.
    pub(super) fn is_conservative(&self) -> bool {
        !self.balance.has_power
    }

    /// Advances to the projected state at a time not before the last requested one; `inner` receives intermediate
    /// states.
    ///
    /// # Errors
    /// The motion cannot be continued to that time.
    pub(super) fn advance_to(
        &mut self,
        mechanism: &dyn Mechanism,
        t: f64,
        solver: &mut Solver,
        to: &mut State,
        mut inner: Option<(IntermediateRows, &mut KeepState)>,
    ) -> Result<(), StepError> {
        self.rows += 1;
        let (mut checked, mut then) = (self.attempts(), self.dense_output.to.t);
        let begin = std::mem::replace(&mut self.asked, t);
        let is_sampled = matches!(inner, Some((IntermediateRows::Samples, _)));
        self.task.dense_from = if is_sampled || self.balance.has_power { f64::NEG_INFINITY } else { t };
        self.keep_behind_corner([begin, t], &mut inner);
        loop {
            if let Some((which, inner)) = &mut inner {
                if *which == IntermediateRows::Samples {
                    self.sample(mechanism, [begin, t], solver, *inner)?;
                }
                let end = &self.dense_output.to;
                if begin < end.t && end.t < t {
                    inner(end);
                }
            }
            if self.dense_output.to.t >= t {
                break;
            }
            let (attempts, now) = (self.attempts(), self.dense_output.to.t);
            if attempts > self.most_attempts {
                return Err(StepError::TooManySteps { attempts, h: self.control.h });
            }
            if attempts > checked + CHECKED {
                let is_stuck = now - then < MIN_PROGRESS * (t - then);
                if is_stuck || attempts > MAX_STEPS + MAX_STEPS_PER_ROW * self.rows {
                    return Err(StepError::TooManySteps { attempts, h: self.control.h.min(self.task.bounds.longest) });
                }
                (checked, then) = (attempts, now);
            }
            self.step(mechanism, solver, true)?;
            self.keep_behind_corner([now.max(begin), t], &mut inner);
        }
        if self.dense_output.to.t == t {
            to.clone_from(&self.dense_output.to);
            return Ok(());
        }
        let mut evaluator = Evaluator { evaluations: &mut self.counts.evaluations, solver };
        to.t = t;
        self.formula.state_inside(mechanism, &mut self.dense_output, &self.task, &mut evaluator, to)
    }

    /// Keeps the state at which the last step began, if it lies between two times: it is the one behind a corner.
    fn keep_behind_corner(&self, [begin, end]: [f64; 2], inner: &mut Option<(IntermediateRows, &mut KeepState)>) {
        let from = &self.dense_output.from;
        if cfg!(feature = "corners")
            && begin < from.t
            && from.t < end
            && let Some((_, inner)) = inner
        {
            inner(from);
        }
    }

    /// States inside the last step, between two times.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    fn sample(
        &mut self,
        mechanism: &dyn Mechanism,
        [begin, end]: [f64; 2],
        solver: &mut Solver,
        inner: &mut KeepState,
    ) -> Result<(), StepError> {
        let [from, to] = [self.dense_output.from.t, self.dense_output.to.t];
        let [first, last] = [from.max(begin), to.min(end)];
        let spacing = ((to - from) / SAMPLES).max(mechanism.schedule().step / SAMPLES_PER_SCENE_STEP);
        if last - first > spacing {
            // These states serve observers, and do not count as evaluations of the method.
            let mut evaluator = Evaluator { evaluations: &mut 0, solver };
            let parts = ((last - first) / spacing).ceil();
            let mut state = self.dense_output.to.clone();
            for i in 1..parts as u32 {
                state.t = first + (last - first) * f64::from(i) / parts;
                self.formula.state_inside(mechanism, &mut self.dense_output, &self.task, &mut evaluator, &mut state)?;
                inner(&state);
            }
        }
        Ok(())
    }

    /// The number of attempted steps.
    fn attempts(&self) -> u64 {
        self.counts.accepted + self.counts.rejected
    }
}
