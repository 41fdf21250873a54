//! Why something could not be done, as the interface tells it.

use qrm_sim::integrate::StepError;
use qrm_sim::run::{Reason, SimError};

/// Why something could not be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// The operation is impossible or not allowed.
    Error(String),
    /// The operation fails at the state that the importer tried, but may succeed at a state nearer to the last one.
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
    /// The failure of a state that an importer tries.
    pub(crate) fn from_trial(error: SimError) -> Self {
        match error.reason {
            // Formulae that leave their domain at this state have a value at the last one.
            Reason::Failed { error: StepError::NotFinite, .. } => Self::Discard(error.to_string()),
            _ => Self::Error(error.to_string()),
        }
    }

    /// The failure as an error, where the tool cannot try another state.
    pub(crate) fn final_one(self) -> Self {
        match self {
            Self::Error(message) | Self::Discard(message) => Self::Error(message),
        }
    }
}
