//! Why there are no derivatives.

use crate::bounds::Unresolved;
use crate::integrate::StepError;
use crate::run::StartError;

/// Why there are no derivatives.
#[derive(Clone, Debug, PartialEq)]
pub enum SensitivityError {
    /// The motion cannot begin.
    Start(StartError),
    /// A step could not be made.
    Step {
        /// The time at its beginning.
        t: f64,
        /// The reason.
        error: StepError,
    },
    /// The constraint Jacobian loses rank, or nearly so, in the step after this time. The motion is continued there by
    /// means that have no derivatives.
    Singular {
        /// The time at the beginning of the step.
        t: f64,
    },
    /// At this time `C_q` nearly loses rank, and an output that was asked for takes accelerations or multipliers, whose
    /// derivatives are lost there.
    ForcesNearSingular {
        /// The time.
        t: f64,
    },
    /// At or after this time some formula has no finite value, or no finite derivative, as a root at zero.
    NotSmooth {
        /// The time.
        t: f64,
    },
    /// An output changes so fast before this row that its integral and its extremes are not known.
    Unresolved {
        /// The time of the row.
        t: f64,
        /// The output.
        output: usize,
    },
    /// The stop condition did not become true.
    EventNotReached {
        /// The latest end.
        end_time: f64,
    },
    /// The condition touches zero without crossing it: a small change of a parameter may move the end far.
    GrazingEvent {
        /// The time.
        t: f64,
    },
    /// The caller wanted no more.
    Interrupted {
        /// The time of the motion under way.
        t: f64,
    },
    /// There is no parameter of this name.
    NoParameter {
        /// The name.
        name: String,
    },
}

impl From<Unresolved> for SensitivityError {
    fn from(Unresolved { t, output }: Unresolved) -> Self {
        Self::Unresolved { t, output }
    }
}
