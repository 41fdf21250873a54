//! Corners and jumps of the equations of motion: the zeros of their switching functions.

mod crossing;

use std::ops::Range;

use qrm_core::{Mechanism, StateRef, TapeEvaluator};

use super::corner::{Corner, EQUAL, equal};
use super::step_error::StepError;
use crate::solve::{Projection, ProjectionTolerance, Solver};
use crate::state::State;

/// The largest number of parts of a step; if corners need more, the motion slides along one.
pub(crate) const MOST_PARTS: usize = 64;
/// The fraction of the way to a jump at which a part of a step ends before it, so that no stage lies behind the jump.
pub(crate) const JUMP_MARGIN: f64 = 1e-3;
/// The largest distance, in multiples of the shortest one, by which a corner is crossed after it was found.
const MAX_CROSSING: f64 = 64.0;
/// Changes below this fraction of those caused by 16 units in the last place of the state are rounding errors.
const NOISE: f64 = 0.25;
/// A time along the tangent of a motion.
const ALONG: f64 = 1e-6;

/// The switching functions of a mechanism along a motion.
#[derive(Clone, Debug)]
pub(crate) struct Corners {
    /// Never constructed in programs without corners, so that the code for corners is not compiled there.
    _ends_steps: EndsSteps,
    evaluator: TapeEvaluator<'static, Vec<f64>>,
    /// The zeros of the functions that are linear in time, in order.
    times: Vec<Corner>,
    /// The range of the functions that are not linear in time.
    others: Range<usize>,
    /// The time of the values at the end of a step, and the values at both ends.
    t: f64,
    values: [Vec<f64>; 2],
    /// The changes of the values in the last step.
    changes: Vec<f64>,
    /// Whether each function may have a zero in the last step.
    candidates: Vec<bool>,
    /// Whether stages of the last step may lie behind a corner that the end of the step does not reach.
    stages_may_pass_corner: bool,
    /// Changes that are rounding errors.
    noise: Vec<f64>,
    /// The function of the last corner, and its sign before the corner.
    found: Option<(usize, f64)>,
    /// Buffers for a state moved along its tangent, and for the values there.
    probe: [Vec<f64>; 3],
}

/// Marks programs whose steps end at corners.
#[cfg(feature = "corners")]
#[derive(Clone, Copy, Debug)]
struct EndsSteps;
#[cfg(not(feature = "corners"))]
type EndsSteps = std::convert::Infallible;

#[cfg(feature = "corners")]
const ENDS_STEPS: Option<EndsSteps> = Some(EndsSteps);
#[cfg(not(feature = "corners"))]
const ENDS_STEPS: Option<EndsSteps> = None;

impl Corners {
    /// Creates the switching functions; `None` if there are none.
    pub(crate) fn new(mechanism: &dyn Mechanism) -> Option<Self> {
        let ends_steps = ENDS_STEPS?;
        let tape = mechanism.tape()?;
        let count = tape.switching_functions.results.len();
        if count == 0 {
            return None;
        }
        let evaluator = TapeEvaluator::with_parameters(tape, mechanism.parameters());
        let others = tape.linear_in_time as usize..count;
        let values = [vec![0.0; count], vec![0.0; count]];
        let changes = vec![f64::INFINITY; count];
        let n = mechanism.description().coordinates.len();
        let probe = [vec![0.0; n], vec![0.0; n], vec![0.0; count]];
        let mut corners = Self {
            _ends_steps: ends_steps,
            evaluator,
            times: Vec::new(),
            others,
            t: f64::NAN,
            values,
            changes,
            candidates: vec![false; count],
            stages_may_pass_corner: false,
            noise: vec![0.0; count],
            found: None,
            probe,
        };
        corners.find_times(n);
        Some(corners)
    }

    /// Finds the zeros of the functions that are linear in time.
    fn find_times(&mut self, n: usize) {
        let zero = vec![0.0; n];
        for (values, t) in self.values.iter_mut().zip([0.0, 1.0]) {
            self.evaluator.switching_functions(t, &zero, &zero, values);
        }
        let [at_zero, at_one] = &self.values;
        let zeros = at_zero.iter().zip(at_one).take(self.others.start).map(|(a, b)| a / (a - b));
        let mut times: Vec<f64> = zeros.filter(|t| t.is_finite()).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.dedup_by(|b, a| *b - *a <= equal(*a));
        self.times = times.into_iter().map(Corner).collect();
    }

    /// The first corner after `t` whose time is known.
    pub(crate) fn next_time(&self, t: f64) -> Option<Corner> {
        self.times.iter().copied().find(|corner| corner.just_before() > t)
    }

    /// The known corner at `t`, after which a step begins.
    pub(crate) fn at(&self, t: f64) -> Option<Corner> {
        self.times.iter().copied().find(|corner| corner.just_before() <= t && t < corner.just_after())
    }

    /// Moves a state at which a switching function is zero away from the zero, by `longest` in time at most or by the
    /// smallest such time, so that its sign is that of the motion behind it. The function of the last corner is treated
    /// likewise: it may lack a unit in the last place.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn move_off_zero(
        &mut self,
        mechanism: &dyn Mechanism,
        (projection, solver): ((Projection, ProjectionTolerance), &mut Solver),
        longest: f64,
        state: &mut State,
    ) -> Result<(), StepError> {
        let found = self.found.take();
        if !self.is_at(state) && !self.is_before(found, state) {
            return Ok(());
        }
        let from = state.clone();
        let mut far = equal(from.t);
        let nearest = MAX_CROSSING * Corner::resolution(from.t);
        while self.is_at(state) && far <= longest.max(equal(from.t)) || self.is_before(found, state) && far <= nearest {
            state.clone_from(&from);
            solver.cross(mechanism, projection, from.t + far, state)?;
            far *= 4.0;
        }
        if self.is_at(state) {
            // The motion rests at the zero.
            state.clone_from(&from);
        }
        Ok(())
    }

    /// Whether a function still has its sign from before the corner.
    fn is_before(&mut self, found: Option<(usize, f64)>, state: &State) -> bool {
        found.is_some_and(|(i, sign)| {
            self.evaluator.switching_functions(state.t, &state.q, &state.qd, &mut self.probe[2]);
            self.probe[2][i] * sign > 0.0
        })
    }

    /// Whether a switching function is zero at a state, and nonzero along its tangent.
    pub(crate) fn is_at(&mut self, state: &State) -> bool {
        let state = state.as_ref();
        self.begin_at(&state);
        if !self.values[1][self.others.clone()].contains(&0.0) {
            return false;
        }
        self.measure_rounding(&state, 1);
        self.move_along(&state, ALONG);
        self.others.clone().any(|i| self.values[1][i] == 0.0 && self.probe[2][i].abs() > self.noise[i])
    }

    /// Evaluates the functions at a state, unless it is the end of the last step.
    fn begin_at(&mut self, at: &StateRef) {
        if self.t != at.t {
            self.evaluator.switching_functions(at.t, at.q, at.qd, &mut self.values[1]);
            self.changes.fill(f64::INFINITY);
            self.t = at.t;
        }
    }

    /// Evaluates the functions at a state moved along its rates and accelerations.
    fn move_along(&mut self, at: &StateRef, h: f64) {
        let [q, qd, values] = &mut self.probe;
        for i in 0..q.len() {
            q[i] = at.q[i] + h * at.qd[i];
            qd[i] = at.qd[i] + h * at.qdd[i];
        }
        self.evaluator.switching_functions(at.t + h, q, qd, values);
    }

    /// Records the changes of the values caused by rounding errors of the state at one end of the last step.
    fn measure_rounding(&mut self, at: &StateRef, end: usize) {
        let [q, qd, _] = &mut self.probe;
        for (perturbed, exact) in [(q, at.q), (qd, at.qd)] {
            for (i, (perturbed, exact)) in perturbed.iter_mut().zip(exact).enumerate() {
                *perturbed = exact * (1.0 + if i % 2 == 0 { EQUAL } else { -EQUAL });
            }
        }
        let [q, qd, _] = &self.probe;
        self.evaluator.switching_functions(at.t, q, qd, &mut self.noise);
        for (noise, exact) in self.noise.iter_mut().zip(&self.values[end]) {
            *noise = NOISE * (*noise - exact).abs();
        }
    }

    /// Allows the last corner to be found again, if the motion is still before it.
    pub(super) fn forget_found(&mut self) {
        self.found = None;
    }

    /// Forgets the values at the end of the last step.
    pub(crate) fn forget(&mut self) {
        self.t = f64::NAN;
    }
}
