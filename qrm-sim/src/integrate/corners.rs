//! Corners and jumps of the equations of motion: the zeros of their switching functions.

use std::ops::Range;

use qrm_core::{Mechanism, StateRef, TapeEvaluator};

use super::step_error::StepError;
use crate::root_finding::{locate, touched};
use crate::solve::{Projection, ProjectionTolerance, Solver};
use crate::state::State;

/// Most parts of a step; where corners ask for more, the motion slides along one.
pub(crate) const MOST_PARTS: usize = 64;
/// A part of a step towards a jump leaves this part of the way, so that no stage lies behind it.
pub(crate) const LEFT: f64 = 1e-3;
/// A switching function may have two zeros in a step where its smallest value at an end is less than so many of its
/// changes in a step.
const NEAR: f64 = 4.0;
/// Steps towards a jump are shortened by at least this part of them, and at most to it.
const SHORTEST_PART: f64 = 0.01;
/// A corner that was found is crossed by so many times the shortest way at most.
const MOST_UNITS: f64 = 64.0;
/// Changes below this part of those by a state that is moved by 16 units in the last place are rounding errors.
const NOISE: f64 = 0.25;
/// A time along the tangent of a motion.
const ALONG: f64 = 1e-6;
/// Times nearer to each other than this part of themselves are equal.
const EQUAL: f64 = 16.0 * f64::EPSILON;

/// The switching functions of a mechanism along a motion.
#[derive(Clone, Debug)]
pub(crate) struct Corners {
    /// No value where steps do not end at corners: what would use them is not compiled there.
    _ends_steps: EndsSteps,
    evaluator: TapeEvaluator<'static, Vec<f64>>,
    /// The zeros of those that are linear in time, in order.
    times: Vec<Corner>,
    /// The range of the functions that are not linear in time.
    others: Range<usize>,
    /// The time of the values at the end of a step, and the values at both ends.
    t: f64,
    values: [Vec<f64>; 2],
    /// The changes of the values in the last step.
    changes: Vec<f64>,
    /// For each function whether it may have a zero in the last step.
    candidates: Vec<bool>,
    /// Whether stages of the last step may lie behind a corner that its end does not reach.
    is_seen_by_stages: bool,
    /// Changes that are rounding errors.
    noise: Vec<f64>,
    /// The function of the corner that was found last, and its sign before.
    found: Option<(usize, f64)>,
    /// Room for a state that was moved a little, and for the values there.
    moved: [Vec<f64>; 3],
}

/// The mark of a program whose steps end at corners. Pages are to be small: they have none.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Clone, Copy, Debug)]
struct EndsSteps;
#[cfg(target_arch = "wasm32")]
type EndsSteps = std::convert::Infallible;

#[cfg(not(target_arch = "wasm32"))]
const ENDS_STEPS: Option<EndsSteps> = Some(EndsSteps);
#[cfg(target_arch = "wasm32")]
const ENDS_STEPS: Option<EndsSteps> = None;

/// The time at which the equations of motion have a corner or a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner(pub(crate) f64);

impl Corner {
    /// The shortest way from `t` to a corner for a step.
    pub(super) fn resolution(t: f64) -> f64 {
        4.0 * equal(t)
    }

    /// The end of a step towards it, where no stage is behind it yet.
    pub(crate) fn just_before(self) -> f64 {
        self.0 - equal(self.0)
    }

    /// The beginning of a step from it on.
    pub(crate) fn just_after(self) -> f64 {
        self.0 + equal(self.0)
    }
}

/// The distance within which times are equal.
fn equal(t: f64) -> f64 {
    (EQUAL * t.abs()).max(f64::MIN_POSITIVE)
}

impl Corners {
    /// The switching functions; `None` if there are none.
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
        let moved = [vec![0.0; n], vec![0.0; n], vec![0.0; count]];
        let mut corners = Self {
            _ends_steps: ends_steps,
            evaluator,
            times: Vec::new(),
            others,
            t: f64::NAN,
            values,
            changes,
            candidates: vec![false; count],
            is_seen_by_stages: false,
            noise: vec![0.0; count],
            found: None,
            moved,
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

    /// The first corner behind `t` whose time is known.
    pub(crate) fn next_time(&self, t: f64) -> Option<Corner> {
        self.times.iter().copied().find(|corner| corner.just_before() > t)
    }

    /// The known corner at `t`, behind which a step is to begin.
    pub(crate) fn at(&self, t: f64) -> Option<Corner> {
        self.times.iter().copied().find(|corner| corner.just_before() <= t && t < corner.just_after())
    }

    /// Moves a state at which a switching function is zero off there, at most so far in time: its sign is to be that of
    /// the motion behind. So is the sign of the function whose corner was found last, which may lack a unit in the last
    /// place.
    ///
    /// # Errors
    /// The projection does not converge, or the accelerations are not determined.
    pub(super) fn leave(
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
        let nearest = MOST_UNITS * Corner::resolution(from.t);
        while self.is_at(state) && far <= longest || self.is_before(found, state) && far <= nearest {
            state.clone_from(&from);
            solver.cross(mechanism, projection, from.t + far, state)?;
            far *= 4.0;
        }
        if self.is_at(state) {
            // It rests there.
            state.clone_from(&from);
        }
        Ok(())
    }

    /// Whether a function has the sign still that it had before its corner.
    fn is_before(&mut self, found: Option<(usize, f64)>, state: &State) -> bool {
        found.is_some_and(|(i, sign)| {
            self.evaluator.switching_functions(state.t, &state.q, &state.qd, &mut self.moved[2]);
            self.moved[2][i] * sign > 0.0
        })
    }

    /// Whether a switching function is zero at a state, and not along its tangent.
    pub(crate) fn is_at(&mut self, state: &State) -> bool {
        let state = state.as_ref();
        self.begin_at(&state);
        if !self.values[1][self.others.clone()].contains(&0.0) {
            return false;
        }
        self.note_noise(&state, 1);
        self.move_along(&state, ALONG);
        self.others.clone().any(|i| self.values[1][i] == 0.0 && self.moved[2][i].abs() > self.noise[i])
    }

    /// Evaluates the functions at a state, unless it is the end of the last step.
    fn begin_at(&mut self, at: &StateRef) {
        if self.t != at.t {
            self.evaluator.switching_functions(at.t, at.q, at.qd, &mut self.values[1]);
            self.changes.fill(f64::INFINITY);
            self.t = at.t;
        }
    }

    /// Evaluates the functions at a state that is moved along its rates and accelerations.
    fn move_along(&mut self, at: &StateRef, h: f64) {
        let [q, qd, values] = &mut self.moved;
        for i in 0..q.len() {
            q[i] = at.q[i] + h * at.qd[i];
            qd[i] = at.qd[i] + h * at.qdd[i];
        }
        self.evaluator.switching_functions(at.t + h, q, qd, values);
    }

    /// Notes how much the values change where a state changes by rounding errors: one at an end of the last step.
    fn note_noise(&mut self, at: &StateRef, end: usize) {
        let [q, qd, _] = &mut self.moved;
        for (perturbed, exact) in [(q, at.q), (qd, at.qd)] {
            for (i, (perturbed, exact)) in perturbed.iter_mut().zip(exact).enumerate() {
                *perturbed = exact * (1.0 + if i % 2 == 0 { EQUAL } else { -EQUAL });
            }
        }
        let [q, qd, _] = &self.moved;
        self.evaluator.switching_functions(at.t, q, qd, &mut self.noise);
        for (noise, exact) in self.noise.iter_mut().zip(&self.values[end]) {
            *noise = NOISE * (*noise - exact).abs();
        }
    }

    /// Whether the motion may meet a corner between two states of one step.
    pub(crate) fn may_meet(&mut self, from: &StateRef, to: &StateRef) -> bool {
        self.begin_at(from);
        self.values.swap(0, 1);
        self.evaluator.switching_functions(to.t, to.q, to.qd, &mut self.values[1]);
        self.t = to.t;
        self.is_seen_by_stages = false;
        let [mut may, mut approaches, mut knows_noise] = [false; 3];
        for i in self.others.clone() {
            let [a, b] = [self.values[0][i], self.values[1][i]];
            let change = (b - a).abs();
            let is_near = a * b > 0.0 && a.abs().min(b.abs()) <= NEAR * change.max(self.changes[i]);
            let is_candidate = a * b < 0.0 || is_near || (a == 0.0 && b != 0.0);
            if is_candidate && !knows_noise {
                self.note_noise(from, 0);
                knows_noise = true;
            }
            self.candidates[i] = is_candidate && change > self.noise[i];
            may |= self.candidates[i];
            approaches |= a * b > 0.0 && b.abs() < a.abs() && b.abs() <= change;
            self.changes[i] = change;
        }
        self.is_seen_by_stages = approaches && self.corrected_end_is_behind(from, to);
        may || self.is_seen_by_stages
    }

    /// Whether stages of the last step may lie behind a corner that its end does not reach.
    pub(super) fn is_seen_by_stages(&self) -> bool {
        self.is_seen_by_stages
    }

    /// The part of the last step that lies before a corner which its end or its stages may have passed, by a secant.
    pub(super) fn part_before(&self) -> Option<f64> {
        let [begin, end] = &self.values;
        let [.., corrected] = &self.moved;
        let crossings = self.others.clone().flat_map(|i| {
            let corrected = if self.is_seen_by_stages { corrected[i] } else { end[i] };
            [end[i], corrected].map(|end| (begin[i], end))
        });
        let parts = crossings.filter(|(a, b)| a * b < 0.0).map(|(a, b)| a / (a - b));
        parts.reduce(f64::min).map(|part| part.clamp(SHORTEST_PART, 1.0 - SHORTEST_PART))
    }

    /// Whether a switching function changes its sign up to an end by the trapezoidal rule, and not up to the end of the
    /// step: a jump that its last stages saw may have kept it from there.
    fn corrected_end_is_behind(&mut self, from: &StateRef, to: &StateRef) -> bool {
        let [q, qd, values] = &mut self.moved;
        let half = 0.5 * (to.t - from.t);
        for i in 0..q.len() {
            qd[i] = from.qd[i] + half * (from.qdd[i] + to.qdd[i]);
            q[i] = to.q[i];
        }
        self.evaluator.switching_functions(to.t, q, qd, values);
        let [begin, end] = &self.values;
        self.others.clone().any(|i| {
            let is_behind = begin[i] * end[i] > 0.0 && begin[i] * values[i] < 0.0;
            is_behind && (values[i] - begin[i]).abs() > self.noise[i]
        })
    }

    /// The first corner that the motion meets inside a step, and the state there or just behind it; `step` makes states
    /// inside the step. Corners nearer to its beginning than `shortest` do not count.
    ///
    /// # Errors
    /// A state inside the step could not be made.
    pub(crate) fn first_inside(
        &mut self,
        [from, to]: [&State; 2],
        shortest: f64,
        step: &mut dyn FnMut(f64) -> Result<State, StepError>,
    ) -> Result<Option<State>, StepError> {
        let mut first: Option<State> = None;
        let Self { evaluator, values, candidates, found: of_first, .. } = self;
        let mut all = vec![0.0; values[0].len()];
        for i in self.others.clone().filter(|i| candidates[*i]) {
            let [a, b] = [values[0][i], values[1][i]];
            // The function with a sign by which it rises through zero.
            let mut rising = |at: &State| {
                evaluator.switching_functions(at.t, &at.q, &at.qd, &mut all);
                -a.signum() * all[i]
            };
            let beyond = if a * b < 0.0 {
                Some(to.clone())
            } else if a * b > 0.0 {
                let found = touched(from, to, &mut |at| Some(rising(at)), step);
                found.filter(|found| rising(found) >= 0.0)
            } else {
                None
            };
            let Some(beyond) = beyond else { continue };
            let found = locate(from, &beyond, &mut rising, step)?;
            if found.t - from.t >= shortest && first.as_ref().is_none_or(|first| found.t < first.t) {
                first = Some(found);
                *of_first = Some((i, a.signum()));
            }
        }
        Ok(first)
    }

    /// The first corner that the tangent of the motion meets within a time so short that nothing else changes.
    pub(super) fn along_tangent(&mut self, from: &StateRef, h: f64) -> Option<Corner> {
        self.forget();
        self.begin_at(from);
        self.move_along(from, h);
        let ends = self.others.clone().map(|i| (self.values[1][i], self.moved[2][i]));
        let crossings = ends.filter(|(a, b)| a * b < 0.0);
        crossings.map(|(a, b)| from.t + h * (a / (a - b))).reduce(f64::min).map(Corner)
    }

    /// Leaves the corner that was found last to be found again, where the motion is before it still.
    pub(super) fn forget_found(&mut self) {
        self.found = None;
    }

    /// Forgets the values at the end of the last step.
    pub(crate) fn forget(&mut self) {
        self.t = f64::NAN;
    }
}
