//! Runs from a consistent start to an end, with error estimates.

mod balance;
mod companion;
mod companion_thread;
mod differences;
mod error;
mod error_estimate;
mod extreme_search;
mod extremes;
mod extremes_tracker;
mod first_state;
mod integral;
mod judgement;
mod monitor;
mod motion_between_rows;
mod observer;
mod outcome;
mod output_bounds;
mod quantities;
mod redundancy;
mod request;
mod run_health;
mod sampler;
mod simulate;
mod simulation;
mod singularity_monitor;
mod stop_condition;

pub use crate::event::End;
pub use balance::Balance;
pub use error::{Explanation, Reason, SimError, readable_size};
pub use error_estimate::{ErrorEstimate, ErrorEstimates};
pub use extremes::Extremes;
pub(crate) use extremes::Vertex;
pub use extremes_tracker::ExtremesTracker;
pub use judgement::{RejectionReason, accepted_fraction};
pub use observer::{Observer, Row};
pub use outcome::{NonFiniteQuantity, Outcome, StartError, Status};
pub use redundancy::Redundancy;
pub use request::Request;
pub use simulate::simulate;
pub use singularity_monitor::NearestSingularity;

pub use simulation::Simulation;

pub(crate) use error_estimate::rounding;
pub(crate) use first_state::{first_position, first_state};
pub(crate) use integral::Integral;
pub(crate) use judgement::{accepted_errors, is_balanced, worst};
pub(crate) use request::check_step;
pub(crate) use stop_condition::check_condition;
