//! The linear equations of one state: accelerations, multipliers, projections.

mod accelerations;
mod buffers;
mod ldl;
mod least_squares;
mod lu;
mod matrix;
mod projection;
mod rank;
mod singular_position;
mod smallest_singular_value;
mod stats;

pub use accelerations::{Solver, Undetermined};
pub use buffers::{Dynamics, Linearization, LoopConstraints};
pub use ldl::{Ldl, PivotedLdl};
pub use least_squares::{Residuals, least_squares};
pub use lu::Lu;
pub use matrix::{Matrix, dot, largest};
pub use projection::{NotConverged, Projection, ProjectionTolerance};
pub use rank::constraint_rank;
pub use smallest_singular_value::SmallestSingularValue;
pub use stats::SolverStats;

pub(crate) use accelerations::{SaddlePoint, minv_ct, schur_complement, subtract_combination};
pub(crate) use matrix::is_positive;
pub(crate) use rank::row_products;
