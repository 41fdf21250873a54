//! The result of a run, or the reason why it could not begin.

use std::time::Duration;

use super::error_estimate::ErrorEstimates;
use super::redundancy::Redundancy;
use super::singularity_monitor::NearestSingularity;
use crate::integrate::{Counts, StepError};
use crate::position::NotAssembled;
use crate::solve::{SolverStats, largest};

/// The result of a run, with the data on its accuracy.
#[derive(Debug)]
pub struct Outcome {
    /// The reason why it ended.
    pub status: Status,
    /// Length of the steps.
    pub step: f64,
    /// The numbers of steps and evaluations.
    pub counts: Counts,
    /// Time of the last row.
    pub end_time: f64,
    /// Coordinates at the end.
    pub q: Vec<f64>,
    /// Rates at the end.
    pub qd: Vec<f64>,
    /// Time spent on integration alone.
    pub integration: Duration,
    /// The constraint with the largest residual in any row, and that residual.
    pub residual_position: (usize, f64),
    /// The constraint with the largest rate of its residual in any row, and that rate.
    pub residual_velocity: (usize, f64),
    /// Largest change of the energy, if no load without potential did work.
    pub energy_drift: Option<f64>,
    /// Largest difference between the change of the energy and the work of the loads without potential, as far as that
    /// work is known.
    pub energy_imbalance: f64,
    /// The position nearest to a singular one; `None` without constraints.
    pub nearest_singular: Option<NearestSingularity>,
    /// The outputs whose extremes between rows are not known.
    pub extremes_of_rows: Vec<usize>,
    /// The coordinate that follows least surely from the given ones at the start, and its possible error; `None` if that
    /// is as small as rounding errors.
    pub start_uncertainty: Option<(usize, f64)>,
    /// Redundant constraints; `None` if all are independent.
    pub redundancy: Option<Redundancy>,
    /// Largest kinetic energy in any row.
    pub largest_kinetic_energy: f64,
    /// Largest energy in any row, kinetic and potential.
    pub largest_energy: f64,
    /// The tolerance of a method that chooses its steps.
    pub tolerance: Option<f64>,
    /// The smallest and the largest value of each coordinate in any row.
    pub ranges: Vec<[f64; 2]>,
    /// The largest correction of each coordinate after a step.
    pub corrections: Vec<f64>,
    /// Estimated errors.
    pub errors: Option<ErrorEstimates>,
    /// Whether the companion run for the error estimate failed.
    pub companion_failed: bool,
    /// The time at which the stop condition may have become true before the end, within errors of the motion, and its
    /// distance from true there.
    pub condition_undecided: Option<(f64, f64)>,
    /// Statistics of the linear solves.
    pub stats: SolverStats,
}

impl Outcome {
    /// Estimated largest error of a coordinate in any row.
    pub fn estimated_error(&self) -> Option<f64> {
        self.errors.as_ref().map(|errors| largest(errors.coordinates()).1)
    }
}

/// The reason why a run ended.
#[derive(Debug)]
pub enum Status {
    /// The end time was reached.
    Completed,
    /// The stop condition became true.
    Stopped,
    /// The latest end came before the stop condition became true.
    StopNotReached {
        /// Time at which the condition was nearest to true.
        nearest_time: f64,
        /// The distance from true at that time.
        missing: f64,
    },
    /// Bounds do not tell whether the stop condition becomes true: it comes near to that, and changes fast.
    StopUndecided {
        /// The times between which it does or does not.
        between: [f64; 2],
    },
    /// The observer ended the run.
    Interrupted,
    /// A step could not be made.
    Failed(StepError),
    /// A row had a value that is not finite.
    NotFinite {
        /// The time of the row.
        t: f64,
        /// The quantity that is not finite.
        what: NonFiniteQuantity,
    },
    /// A row could not be kept.
    Unwritable(std::io::Error),
}

impl Status {
    /// Whether the run reached its end.
    pub fn is_done(&self) -> bool {
        matches!(self, Self::Completed | Self::Stopped)
    }
}

/// A value of a row that is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NonFiniteQuantity {
    /// An output.
    Output(usize),
    /// The energy.
    Energy,
    /// The stop condition.
    Condition,
}

/// The reason why a run could not begin.
#[derive(Clone, Debug, PartialEq)]
pub enum StartError {
    /// The constraints cannot be satisfied.
    NotAssembled(NotAssembled),
    /// The stop condition has no finite value at the start.
    ConditionNotFinite,
    /// The stop condition holds at the start.
    ConditionHolds,
    /// The accelerations at the start are not determined.
    Step(StepError),
    /// The given rates do not determine the rate of this coordinate, at a dead point.
    RateNotDetermined(usize),
    /// The step is below the resolution of time.
    StepTooShort {
        /// The step.
        step: f64,
        /// The end.
        end_time: f64,
    },
}
