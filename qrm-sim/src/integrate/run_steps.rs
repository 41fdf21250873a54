//! The steps of another run that those of this one stay below.

use std::collections::VecDeque;

/// The part of a step of another run that steps beside it are at most: errors of order 4 fall to an eleventh.
pub(crate) const COMPANION_STEP_RATIO: f64 = 0.55;

/// Steps of another run: the first of them is under way, and more follow.
#[derive(Clone, Debug, Default)]
pub(super) struct RunSteps(VecDeque<[f64; 2]>);

impl RunSteps {
    /// Takes up begin and end of more steps.
    pub(super) fn extend(&mut self, steps: &[[f64; 2]]) {
        self.0.extend(steps);
    }

    /// The longest step from a time on, of those that are no longer than `longest`.
    pub(super) fn longest(&mut self, t: f64, mut longest: f64) -> f64 {
        while self.0.len() > 1 && self.0[0][1] <= t {
            self.0.pop_front();
        }
        // A step that begins in a long step of the run may end in shorter ones behind it.
        for [begin, end] in &self.0 {
            if *begin >= t + longest {
                break;
            }
            longest = longest.min((begin - t).max(COMPANION_STEP_RATIO * (end - begin)));
        }
        longest
    }
}
