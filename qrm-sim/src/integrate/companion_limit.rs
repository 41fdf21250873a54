//! The limit of a companion's steps: those of its run.

use std::collections::VecDeque;

/// The largest ratio of a companion's step to that of the run beside it. A tighter tolerance alone may leave both with
/// the same steps, whose difference is no estimate; with this ratio errors of order 4 fall to an eleventh.
pub(crate) const COMPANION_STEP_RATIO: f64 = 0.55;

/// Begin and end of the steps of a run that its companion has not passed, and of the one before.
#[derive(Clone, Debug, Default)]
pub(super) struct CompanionLimit(VecDeque<[f64; 2]>);

impl CompanionLimit {
    /// Takes up begin and end of the next steps of the run.
    pub(super) fn extend(&mut self, steps: &[[f64; 2]]) {
        self.0.extend(steps);
    }

    /// The longest step of the companion from a time on, `longest` at most.
    pub(super) fn longest(&mut self, t: f64, mut longest: f64) -> f64 {
        // The last step stays: more may follow.
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
