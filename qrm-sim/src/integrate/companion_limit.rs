//! The limit of a companion's steps by the steps of its run.

use std::collections::VecDeque;

/// The largest ratio of a companion's step to that of its run. A tighter tolerance alone may leave both with the same
/// steps, and their difference would be no estimate. With this ratio errors of order 4 decrease to an eleventh.
pub(crate) const COMPANION_STEP_RATIO: f64 = 0.55;

/// The begin and end of the steps of a run that its companion has not passed, and of the step before.
#[derive(Clone, Debug, Default)]
pub(super) struct CompanionLimit(VecDeque<[f64; 2]>);

impl CompanionLimit {
    /// Adds the next steps of the run.
    pub(super) fn extend(&mut self, steps: &[[f64; 2]]) {
        self.0.extend(steps);
    }

    /// The longest step of the companion from a time on, at most `longest`.
    pub(super) fn longest(&mut self, t: f64, mut longest: f64) -> f64 {
        // The last step stays, since more may follow.
        while self.0.len() > 1 && self.0[0][1] <= t {
            self.0.pop_front();
        }
        // A step that begins in a long step of the run may end in a shorter one after it.
        for [begin, end] in &self.0 {
            if *begin >= t + longest {
                break;
            }
            longest = longest.min((begin - t).max(COMPANION_STEP_RATIO * (end - begin)));
        }
        longest
    }
}
