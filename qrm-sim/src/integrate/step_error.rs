//! The reasons why a step could not be made.

use crate::solve::{NotConverged, Undetermined};

/// The reason why a step could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepError {
    /// The projection did not converge.
    NotConverged(NotConverged),
    /// A motion of this coordinate that the constraints allow has no inertia.
    Massless(usize),
    /// The step fell below the resolution of time.
    StepTooShort {
        /// The last step.
        h: f64,
    },
    /// Steps are so short compared with the rows that the run would not end.
    TooManySteps {
        /// The number of attempts.
        attempts: u64,
        /// The last step.
        h: f64,
    },
    /// A number became infinite or undefined.
    NotFinite,
    /// A force became infinite or undefined.
    ForcesNotFinite,
    /// Friction depends on joint forces, and redundant constraints make these non-unique.
    FrictionNotUnique,
    /// This constraint has no gradient at the start and near it, so that no force can hold it.
    NoGradient(usize),
    /// The method needs derivatives that the scene does not request.
    NoLinearization,
}

impl From<NotConverged> for StepError {
    fn from(e: NotConverged) -> Self {
        if e.residual.is_finite() { Self::NotConverged(e) } else { Self::NotFinite }
    }
}

impl From<Undetermined> for StepError {
    fn from(e: Undetermined) -> Self {
        match e {
            Undetermined::Massless(coordinate) => Self::Massless(coordinate),
            Undetermined::NotFinite => Self::NotFinite,
            Undetermined::ForcesNotFinite => Self::ForcesNotFinite,
        }
    }
}
