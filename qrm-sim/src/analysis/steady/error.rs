//! Why there is no steady motion.

use super::super::sensitivity::SensitivityError;
use crate::integrate::StepError;
use crate::position::Start;
use crate::run::StartError;

/// Why there is no steady motion.
#[derive(Clone, Debug)]
pub enum NoSteadyMotion {
    /// The motion cannot begin.
    Start(StartError),
    /// The given coordinates at the start are not as many as degrees of freedom, or do not determine the others.
    NotGiven,
    /// The coordinate of the phase is not given at the start, or none is.
    NoPhase,
    /// The method has fixed steps, and the period is not known before.
    FixedSteps,
    /// The motion before the search cannot be continued.
    Settling {
        /// The time at the beginning of the step.
        t: f64,
        /// The reason.
        error: StepError,
    },
    /// The motion comes to rest.
    AtRest {
        /// The time by which it has.
        t: f64,
    },
    /// The search leads to a state of rest.
    LeadsToRest,
    /// The coordinate of the phase neither turns nor oscillates.
    NoCycle {
        /// The coordinate.
        coordinate: usize,
        /// The time of its last turn or reversal; zero without one.
        last: f64,
        /// The time up to which the motion was followed.
        t: f64,
    },
    /// A period of the search cannot be followed with derivatives.
    Motion(SensitivityError),
    /// Newton's method does not converge.
    NotFound {
        /// The difference between the end and the start of a period, relative to the ranges of coordinates and rates.
        residual: f64,
        /// The start of that period.
        start: Box<Start>,
        /// The period.
        period: f64,
    },
    /// The given coordinates return after the period, and this other one does not.
    OtherBranch {
        /// The coordinate.
        coordinate: usize,
        /// The difference.
        difference: f64,
    },
    /// Coordinates and rates return after the period, and this acceleration, or that multiplier, does not: loads depend
    /// on the number of turns, or on time with another period.
    LoadsDiffer {
        /// The coordinate that is accelerated, or else the constraint.
        quantity: Result<usize, usize>,
        /// The value at some time, and that a period later.
        values: [f64; 2],
    },
    /// The motion is one of many at one value of a parameter, and no branch of single motions.
    OneOfMany,
    /// On a branch, the coordinate of the phase turns back at its start.
    PhaseTurnsBack {
        /// The coordinate.
        coordinate: usize,
    },
    /// A branch begins and ends at the same value of its parameter.
    NoRange,
    /// The eigenvalues of the return map cannot be computed.
    NoEigenvalues,
    /// The caller wanted no more.
    Interrupted {
        /// The time of the motion under way.
        t: f64,
    },
}

impl From<SensitivityError> for NoSteadyMotion {
    fn from(error: SensitivityError) -> Self {
        match error {
            SensitivityError::Interrupted { t } => Self::Interrupted { t },
            SensitivityError::Start(error) => Self::Start(error),
            error => Self::Motion(error),
        }
    }
}
