//! The crossing of a corner inside a step.

use qrm_core::StateRef;

use super::super::corner::Corner;
use super::super::step_error::StepError;
use super::Corners;
use crate::event::location::{SHIFT, locate, touched};
use crate::state::State;

/// The largest ratio of a switching function at an end of a step to its change in the step, for which it may have two
/// zeros in the step.
const NEAR: f64 = 4.0;
/// The smallest fraction by which a step towards a jump is shortened, and the smallest fraction that remains.
const SHORTEST_PART: f64 = 0.01;

impl Corners {
    /// Whether the motion may meet a corner between two states of one step.
    pub(crate) fn may_meet(&mut self, from: &StateRef, to: &StateRef) -> bool {
        self.begin_at(from);
        self.values.swap(0, 1);
        self.evaluator.switching_functions(to.t, to.q, to.qd, &mut self.values[1]);
        self.t = to.t;
        self.stages_may_pass_corner = false;
        let [mut may, mut approaches, mut knows_noise] = [false; 3];
        for i in self.others.clone() {
            let [a, b] = [self.values[0][i], self.values[1][i]];
            let change = (b - a).abs();
            let is_near = a * b > 0.0 && a.abs().min(b.abs()) <= NEAR * change.max(self.changes[i]);
            let is_candidate = a * b < 0.0 || is_near || (a == 0.0 && b != 0.0);
            if is_candidate && !knows_noise {
                self.measure_rounding(from, 0);
                knows_noise = true;
            }
            self.candidates[i] = is_candidate && change > self.noise[i];
            may |= self.candidates[i];
            approaches |= a * b > 0.0 && b.abs() < a.abs() && b.abs() <= change;
            self.changes[i] = change;
        }
        self.stages_may_pass_corner = approaches && self.corrected_end_is_behind(from, to);
        may || self.stages_may_pass_corner
    }

    /// Whether stages of the last step may lie behind a corner that the end of the step does not reach.
    pub(in crate::integrate) fn stages_may_pass_corner(&self) -> bool {
        self.stages_may_pass_corner
    }

    /// The fraction of the last step before a corner that its end or its stages may have passed, by a secant.
    pub(in crate::integrate) fn part_before(&self) -> Option<f64> {
        let [begin, end] = &self.values;
        let [.., corrected] = &self.probe;
        let crossings = self.others.clone().flat_map(|i| {
            let corrected = if self.stages_may_pass_corner { corrected[i] } else { end[i] };
            [end[i], corrected].map(|end| (begin[i], end))
        });
        let parts = crossings.filter(|(a, b)| a * b < 0.0).map(|(a, b)| a / (a - b));
        parts.reduce(f64::min).map(|part| part.clamp(SHORTEST_PART, 1.0 - SHORTEST_PART))
    }

    /// Whether a switching function changes its sign up to an end by the trapezoidal rule, but not up to the end of the
    /// step: its last stages may have seen a jump that kept the end away.
    fn corrected_end_is_behind(&mut self, from: &StateRef, to: &StateRef) -> bool {
        let [q, qd, values] = &mut self.probe;
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

    /// Finds the first corner inside a step, and the state there or just behind it; `step` computes states inside the
    /// step. Corners nearer to its beginning than `shortest` do not count.
    ///
    /// # Errors
    /// A state inside the step could not be computed.
    pub(crate) fn first_inside(
        &mut self,
        [from, to]: [&State; 2],
        shortest: f64,
        step: &mut dyn FnMut(f64) -> Result<State, StepError>,
    ) -> Result<Option<State>, StepError> {
        let mut first: Option<State> = None;
        let Self { evaluator, values, candidates, found: of_first, .. } = self;
        let mut all = vec![0.0; values[0].len()];
        // All switching functions next to the ends, so that each is looked into only if it turns between them.
        let beside: Vec<Vec<f64>> = if self.others.clone().any(|i| candidates[i] && values[0][i] * values[1][i] > 0.0) {
            let shift = SHIFT * (to.t - from.t);
            let next = [from.moved_along(shift), to.moved_along(-shift)];
            next.map(|at| {
                evaluator.switching_functions(at.t, &at.q, &at.qd, &mut all);
                all.clone()
            })
            .into()
        } else {
            Vec::new()
        };
        for i in self.others.clone().filter(|i| candidates[*i]) {
            let [a, b] = [values[0][i], values[1][i]];
            // The function multiplied by the sign with which it rises through zero.
            let mut rising = |at: &State| {
                evaluator.switching_functions(at.t, &at.q, &at.qd, &mut all);
                -a.signum() * all[i]
            };
            let beyond = if a * b < 0.0 {
                Some(to.clone())
            } else if a * b > 0.0 {
                let turns = a.signum() * (beside[0][i] - a) < 0.0 && a.signum() * (beside[1][i] - b) < 0.0;
                if !turns {
                    continue;
                }
                let found = touched(from, to, &mut |at| Some(rising(at)), &mut |t| step(t).ok());
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

    /// The first corner on the tangent of the motion within a time so short that nothing else changes.
    pub(in crate::integrate) fn along_tangent(&mut self, from: &StateRef, h: f64) -> Option<Corner> {
        self.forget();
        self.begin_at(from);
        self.move_along(from, h);
        let ends = self.others.clone().map(|i| (self.values[1][i], self.probe[2][i]));
        let crossings = ends.filter(|(a, b)| a * b < 0.0);
        crossings.map(|(a, b)| from.t + h * (a / (a - b))).reduce(f64::min).map(Corner)
    }
}
