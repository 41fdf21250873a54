//! The control of step lengths by errors.

/// The length of a step relative to the length that would just be accepted.
const SAFETY: f64 = 0.8;
/// The smallest ratio of a step to the previous one.
const SHRINK: f64 = 0.2;
/// The largest ratio of a step to the previous one, if that was accepted at once.
const GROW: f64 = 6.0;

/// The PI control of step lengths (Hairer, Wanner II, IV.2).
#[derive(Clone, Copy, Debug)]
pub(super) struct StepControl {
    /// Length of the next step.
    pub(super) h: f64,
    last_error: f64,
    /// Whether the last attempt was rejected.
    was_rejected: bool,
}

impl StepControl {
    /// Begins with a step of length `h`.
    pub(super) fn new(h: f64) -> Self {
        Self { h, last_error: 1e-4, was_rejected: false }
    }

    /// Repeats the rejected step with length `h`.
    pub(super) fn reject(&mut self, h: f64) {
        self.h = h;
        self.was_rejected = true;
    }

    /// Chooses the next length after an accepted step of length `h`, from its error and, with the exponent `beta`, that
    /// of the previous accepted step.
    pub(super) fn accept(&mut self, h: f64, error: f64, order: i32, beta: f64) {
        let error = error.max(1e-10);
        let factor = SAFETY * error.powf(0.75 * beta - 1.0 / f64::from(order)) * self.last_error.powf(beta);
        let most = if self.was_rejected { 1.0 } else { GROW };
        *self = Self { h: h * factor.clamp(SHRINK, most), last_error: error.max(1e-4), was_rejected: false };
    }
}

/// The length that replaces `h` after a failed step.
pub(super) fn shorter_for_failure(h: f64) -> f64 {
    h * SHRINK
}

/// The length that replaces `h` after a step of this order with an error above 1.
pub(super) fn shorter_for_error(h: f64, error: f64, order: i32) -> f64 {
    let factor = if error.is_finite() { SAFETY * error.powf(-1.0 / f64::from(order)) } else { SHRINK };
    h * factor.clamp(SHRINK, 0.9)
}

/// The length that replaces `h` after a step in which a force changed `change` times as much as allowed.
pub(super) fn shorter_for_change(h: f64, change: f64) -> f64 {
    h * (SAFETY / change).max(SHRINK)
}
