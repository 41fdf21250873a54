//! The linear equations of one state: accelerations, multipliers, projections.

mod buffers;
mod ldl;
mod least_squares;
mod lu;
mod matrix;
mod projection;
mod projection_settings;
mod rank;
mod response;
mod saddle_point;
mod singular_position;
mod smallest_singular_value;
mod solver;
mod stats;

pub use buffers::{Dynamics, Linearization, LoopConstraints};
pub use ldl::{Ldl, PivotedLdl};
pub use least_squares::{Residuals, least_squares};
pub use lu::Lu;
pub use matrix::{Matrix, dot, largest};
pub use projection_settings::{NotConverged, Projection, ProjectionTolerance};
pub use rank::constraint_rank;
pub use saddle_point::Undetermined;
pub use smallest_singular_value::SmallestSingularValue;
pub use solver::Solver;
pub use stats::SolverStats;

pub(crate) use matrix::{is_positive, subtract_combination};
pub(crate) use rank::row_products;
pub(crate) use response::Response;
pub(crate) use saddle_point::{SaddlePoint, minv_ct, schur_complement};
