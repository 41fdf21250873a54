//! Advances a motion from one row to the next, by any method.

mod block;

use qrm_core::{Mechanism, RowLayout};

use super::adaptive::{Adaptive, Counts, IntermediateRows};
use super::dense_output::quintic;
use super::fixed::{Fixed, StepContext};
use super::formula::Formula;
use super::methods::MethodSettings;
use super::step_error::StepError;
use crate::solve::{INTERPOLATED, IRREGULAR, Linearization, SINGULAR, Solver, SolverStats, largest};
use crate::state::State;

/// The largest number of stored values of states between rows.
const MOST_INNER: usize = 1 << 20;
/// The distance of states on both sides of a position near a singular one, in rad or m.
const SIDE: f64 = 0.02;
/// The largest difference between a row and the polynomial through the states on both sides, in rad or m.
const SMOOTH: f64 = 1e-9;
/// The largest number of attempted steps to a state on a side. A motion that takes more is no polynomial there.
const MOST_TO_SIDE: u64 = 50;

/// A method and its data between rows.
#[derive(Clone, Debug)]
pub struct Integrator {
    /// The method.
    pub settings: MethodSettings,
    solver: Solver,
    steps: Steps,
    /// A buffer for the two rows of a step.
    pair: [State; 2],
    layout: RowLayout,
    /// The choice of the states between rows that are kept; `inner` holds those of the last block.
    keeps_inner: Option<IntermediateRows>,
    inner: Vec<f64>,
    /// Pairs of states on both sides of positions near singular ones, if steps are chosen by a tolerance; without
    /// coordinates where the motion is no polynomial.
    sides: Vec<State>,
}

#[derive(Clone, Debug)]
enum Steps {
    /// Each row is a step.
    Fixed(Box<Fixed>),
    /// Steps are chosen by a tolerance.
    Adaptive(Box<Adaptive>),
}

impl Integrator {
    /// Begins at a state.
    ///
    /// # Errors
    /// The method is not applicable to the scene, or the accelerations near the start are not determined.
    pub fn new(
        mechanism: &dyn Mechanism,
        settings: MethodSettings,
        first: &State,
        end_time: f64,
    ) -> Result<Self, StepError> {
        let layout = RowLayout { n: first.q.len(), m: first.multipliers.len() };
        let mut solver = Solver::at(mechanism, first.t, &first.q);
        let steps = match settings.method.formula {
            None => Steps::Fixed(Box::new(Fixed::new(mechanism, first))),
            Some(_) if settings.method.needs_linearization && !Linearization::is_known(mechanism) => {
                return Err(StepError::NoLinearization);
            }
            Some(formula) => {
                let formula = formula(mechanism);
                let adaptive = Adaptive::new(mechanism, formula, settings.task(end_time), first, &mut solver)?;
                Steps::Adaptive(Box::new(adaptive))
            }
        };
        let pair = [first.clone(), first.clone()];
        Ok(Self { settings, solver, steps, pair, layout, keeps_inner: None, inner: Vec::new(), sides: Vec::new() })
    }

    /// Keeps states between rows, if the method chooses steps that are shorter than the rows.
    pub(crate) fn keep_inner_rows(&mut self, which: IntermediateRows) {
        self.keeps_inner = Some(which);
    }

    /// The begin and end of each step of the last block, if steps are chosen by a tolerance.
    pub(crate) fn steps(&self) -> &[[f64; 2]] {
        match &self.steps {
            Steps::Fixed(_) => &[],
            Steps::Adaptive(adaptive) => adaptive.steps(),
        }
    }

    /// Sets the number of steps for the part of a fixed step behind a corner.
    pub(crate) fn set_steps_behind_corners(&mut self, count: u32) {
        if let Steps::Fixed(fixed) = &mut self.steps {
            fixed.steps_behind_corners = count;
        }
    }

    /// The end and formula of each step since the last call, if steps are chosen by a tolerance.
    pub(crate) fn take_steps(&mut self) -> Vec<(f64, Formula)> {
        let Steps::Adaptive(adaptive) = &mut self.steps else { return Vec::new() };
        let formula = |kind| Formula::new(self.settings.method, kind);
        let steps = adaptive.steps().iter().zip(adaptive.kinds()).map(|([_, end], kind)| (*end, formula(kind)));
        let steps = steps.collect();
        adaptive.forget_steps();
        steps
    }

    /// Limits steps that are chosen by a tolerance by those of another run at the same time.
    pub(crate) fn limit_steps_by(&mut self, steps: &[[f64; 2]]) {
        if let Steps::Adaptive(adaptive) = &mut self.steps {
            adaptive.forget_steps();
            adaptive.limit_steps_by(steps);
        }
    }

    /// The states between the rows of the last block, as rows.
    pub(crate) fn inner_rows(&self) -> &[f64] {
        &self.inner
    }

    /// Statistics of the linear solves so far.
    pub fn stats(&self) -> &SolverStats {
        &self.solver.stats
    }

    /// The largest correction of each coordinate.
    pub fn corrections(&self) -> &[f64] {
        &self.solver.corrections
    }

    /// The number of constraints that are independent at regular positions.
    pub(crate) fn rank(&self) -> usize {
        self.solver.rank()
    }

    /// The solver of the linear equations.
    pub(crate) fn solver(&self) -> &Solver {
        &self.solver
    }

    /// The solver of the linear equations.
    pub(crate) fn solver_mut(&mut self) -> &mut Solver {
        &mut self.solver
    }

    /// Advances from a row to the next one, at `t`, by the generated kernel if the method allows it.
    ///
    /// # Errors
    /// The motion cannot be continued to that time.
    pub fn advance(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        t: f64,
        to: &mut State,
    ) -> Result<(), StepError> {
        let asks_kernel = self.is_by_kernel();
        self.advance_by(asks_kernel, mechanism, from, t, to)
    }

    fn is_by_kernel(&self) -> bool {
        self.settings.is_by_kernel() && !self.solver.is_redundant() && !self.solver.avoids_kernels
    }

    /// Advances from a row to the next one, at `t`, by the plain functions.
    ///
    /// # Errors
    /// The motion cannot be continued to that time.
    pub(crate) fn advance_by_functions(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        t: f64,
        to: &mut State,
    ) -> Result<(), StepError> {
        self.advance_by(false, mechanism, from, t, to)
    }

    fn advance_by(
        &mut self,
        asks_kernel: bool,
        mechanism: &dyn Mechanism,
        from: &State,
        t: f64,
        to: &mut State,
    ) -> Result<(), StepError> {
        let Self { settings, solver, steps, layout, keeps_inner, inner, .. } = self;
        let mut keep = |state: &State| {
            let begin = inner.len();
            if begin < MOST_INNER {
                inner.resize(begin + layout.width(), 0.0);
                state.write(&mut inner[begin..]);
            }
        };
        match steps {
            Steps::Fixed(fixed) => {
                fixed.advance(&mut StepContext { mechanism, settings, solver, asks_kernel }, from, t, to, &mut keep)
            }
            Steps::Adaptive(adaptive) => {
                let inner = keeps_inner.map(|which| (which, &mut keep as &mut dyn FnMut(&State)));
                adaptive.advance_to(mechanism, t, solver, to, inner)
            }
        }
    }

    /// Computes the state at a time between the row `from` and the last one.
    ///
    /// # Errors
    /// The motion cannot be continued to that time.
    pub fn between(&mut self, mechanism: &dyn Mechanism, from: &State, t: f64) -> Result<State, StepError> {
        let mut to = from.clone();
        if t == from.t {
            return Ok(to);
        }
        self.step_between(mechanism, from, t, u64::MAX, &mut to)?;
        let fraction = self.solver.singularity_fraction(mechanism, INTERPOLATED, t, (&to.q, &to.qd));
        if fraction.is_some()
            && let Some(state) = self.across(mechanism, from, t)
        {
            return Ok(state);
        }
        if fraction.is_some_and(|fraction| fraction < SINGULAR) {
            // Kernels lose digits of the rates so near a singular position, and reach another branch at last.
            to.clone_from(from);
            self.solver.avoids_kernels = true;
            let made = self.step_between(mechanism, from, t, u64::MAX, &mut to);
            self.solver.avoids_kernels = false;
            made?;
        }
        self.solver.refine(mechanism, IRREGULAR, &mut to);
        Ok(to)
    }

    /// The state at a time near a singular position, where stages of a step hardly determine accelerations: it begins
    /// with the polynomial between states on both sides. `None` if the equations do not determine it.
    fn across(&mut self, mechanism: &dyn Mechanism, from: &State, t: f64) -> Option<State> {
        let duration = SIDE / largest(&from.qd).1;
        if !cfg!(feature = "extremes") || !duration.is_finite() {
            return None;
        }
        let [before, after] = self.sides_around(mechanism, from, t, duration)?;
        let mut state = quintic(&before, &after, t);
        self.solver.refine(mechanism, INTERPOLATED, &mut state).then_some(state)
    }

    /// The states on both sides of a position, which are kept if steps are chosen by a tolerance; `None` if they take
    /// many steps.
    fn sides_around(&mut self, mechanism: &dyn Mechanism, from: &State, t: f64, duration: f64) -> Option<[State; 2]> {
        let is_known = |pair: &[State]| pair.iter().all(|side| !side.q.is_empty());
        // A corner between the states would bend the motion.
        let is_smooth = |pair: &[State]| {
            let at = quintic(&pair[0], &pair[1], from.t);
            at.q.iter().zip(&from.q).all(|(own, other)| (own - other).abs() <= SMOOTH)
        };
        let kept = self.sides.chunks_exact(2).find(|pair| {
            let is_between = pair[0].t <= t && t + 0.5 * duration <= pair[1].t;
            is_between && (from.t < pair[0].t || !is_known(pair) || is_smooth(pair))
        });
        if let Some(pair) = kept {
            return is_known(pair).then(|| [pair[0].clone(), pair[1].clone()]);
        }
        let side = |t: f64| self.side(mechanism, from, t).unwrap_or(State { t, ..State::default() });
        let pair = [(t - duration).max(from.t), t + duration].map(side);
        if !self.is_fixed() {
            self.sides.extend_from_slice(&pair);
        }
        is_known(&pair).then_some(pair)
    }

    /// The state on a side; `None` if it takes many steps.
    fn side(&mut self, mechanism: &dyn Mechanism, from: &State, t: f64) -> Option<State> {
        let mut at = from.clone();
        if t > from.t {
            self.step_between(mechanism, from, t, MOST_TO_SIDE, &mut at).ok()?;
        }
        self.solver.refine(mechanism, IRREGULAR, &mut at);
        Some(at)
    }

    /// Steps from a state to a time. A method that chooses its steps gives up after `most_attempts` of them.
    fn step_between(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        t: f64,
        most_attempts: u64,
        to: &mut State,
    ) -> Result<(), StepError> {
        match &self.steps {
            Steps::Fixed(_) => {
                // These intermediate states do not belong to the block.
                let kept = self.inner.len();
                let made = self.advance(mechanism, from, t, to);
                self.inner.truncate(kept);
                made
            }
            Steps::Adaptive(adaptive) => {
                let mut again = adaptive.restarted(from);
                again.limit_attempts(most_attempts);
                again.advance_to(mechanism, t, &mut self.solver, to, None)
            }
        }
    }

    /// The largest difference between energy and work at the end of any step; `None` if rows are the steps.
    pub fn imbalance(&self) -> Option<f64> {
        match &self.steps {
            Steps::Fixed(_) => None,
            Steps::Adaptive(adaptive) => Some(adaptive.imbalance()),
        }
    }

    /// Whether no load without potential did work inside a step, as far as known.
    pub(crate) fn is_conservative(&self) -> bool {
        match &self.steps {
            Steps::Fixed(_) => true,
            Steps::Adaptive(adaptive) => adaptive.is_conservative(),
        }
    }

    /// Whether each row is a step.
    pub fn is_fixed(&self) -> bool {
        matches!(self.steps, Steps::Fixed(_))
    }

    /// The numbers of steps and evaluations in a run of `rows` rows.
    pub fn counts(&self, rows: u64) -> Counts {
        match &self.steps {
            Steps::Fixed(_) => Counts { accepted: rows, evaluations: 4 * rows, ..Counts::default() },
            Steps::Adaptive(adaptive) => adaptive.counts(),
        }
    }
}
