//! Why a step could not be made.

use crate::solve::{NotConverged, Undetermined};

/// Why a step could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepError {
    /// The projection did not converge.
    NotConverged(NotConverged),
    /// No inertia resists a motion of this coordinate that the constraints allow.
    Massless(usize),
    /// The steps became so short that time stands still.
    StepTooShort {
        /// The last one.
        h: f64,
    },
    /// The steps are so short against the rows that the run would not end.
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
    /// Friction depends on the forces in joints, and constraints repeat others: the forces are not unique.
    FrictionNotUnique,
    /// The method needs derivatives that the scene does not ask for.
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
