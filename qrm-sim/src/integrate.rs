//! Integration methods, which advance a motion from one state to the next.
//!
//! A method is a row in [`METHODS`]. RK4 makes steps of the requested length; the others choose their steps by a
//! tolerance and compute the rows in between by dense output.

mod adaptive;
mod auto;
mod classical;
mod companion_limit;
mod corner;
mod corners;
mod dense_output;
mod dop853;
mod dopri5;
mod explicit;
mod first_step;
mod fixed;
mod formula;
mod gauss;
mod implicit;
mod integrator;
mod method;
mod methods;
mod projected_state;
pub(crate) mod rodas;
mod step_balance;
mod step_bounds;
mod step_control;
mod step_error;
mod step_formula;
mod tableau;
mod transitions;

pub use adaptive::Counts;
pub(crate) use adaptive::IntermediateRows;
pub use auto::AUTO;
pub use classical::RK4;
pub(crate) use companion_limit::COMPANION_STEP_RATIO;
pub(crate) use corner::Corner;
pub(crate) use corners::{Corners, JUMP_MARGIN, MOST_PARTS};
pub(crate) use dense_output::{quintic, quintic_coefficients};
pub use dop853::DOP853;
pub use dopri5::DOPRI5;
pub(crate) use formula::Formula;
pub use gauss::GAUSS;
pub use integrator::Integrator;
pub use method::Method;
pub use methods::{METHODS, MethodSettings, method_named};
pub use rodas::RODAS;
pub use step_bounds::StepBounds;
pub use step_error::StepError;
pub(crate) use tableau::Tableau;
