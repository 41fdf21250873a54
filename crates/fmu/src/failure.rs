//! Failures, and their status in the interface.

use qrm_sim::integrate::StepError;
use qrm_sim::run::{Reason, SimError};

/// The reason of a failure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// The operation is impossible or not allowed.
    Error(String),
    /// The operation fails at the state tried by the importer, but may succeed at a state closer to the previous one.
    Discard(String),
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Self::Error(message)
    }
}

impl From<&str> for Failure {
    fn from(message: &str) -> Self {
        Self::Error(message.to_owned())
    }
}

impl Failure {
    /// Creates the failure of a state tried by an importer.
    pub(crate) fn from_trial(error: SimError) -> Self {
        match error.reason {
            // Formulae that leave their domain at this state had a value at the previous one.
            Reason::Failed { error: StepError::NotFinite, .. } => Self::Discard(error.to_string()),
            _ => Self::Error(error.to_string()),
        }
    }

    /// Turns the failure into an error, if the importer cannot try another state.
    pub(crate) fn final_one(self) -> Self {
        match self {
            Self::Error(message) | Self::Discard(message) => Self::Error(message),
        }
    }
}
