//! The linear equations of one state: accelerations, multipliers, projections.

mod buffers;
mod ldl;
mod least_squares;
mod lu;
mod matrix;
mod nonzeros;
mod precise;
mod projection;
mod projection_settings;
mod rank;
mod response;
mod saddle_point;
mod singular_position;
mod singularity_distance;
mod smallest_singular_value;
mod solver;
mod stage_interpolation;
mod stats;
mod tree_linearization;

pub use buffers::{Dynamics, Linearization, LoopConstraints};
pub use ldl::{Ldl, PivotedLdl};
pub use least_squares::{Residuals, least_squares};
pub use lu::Lu;
pub use matrix::{Matrix, dot, largest};
pub use projection_settings::{NotConverged, Projection, ProjectionTolerance};
pub use rank::{constraint_rank, constraint_without_gradient};
pub use saddle_point::Undetermined;
pub use smallest_singular_value::SmallestSingularValue;
pub use solver::Solver;
pub use stats::SolverStats;

pub(crate) use matrix::{is_positive, subtract_combination};
pub(crate) use precise::{Number, PreciseEquations, PreciseSaddlePoint};
pub(crate) use rank::row_products;
pub(crate) use response::Response;
pub(crate) use saddle_point::{SaddlePoint, minv_ct, schur_complement};
pub(crate) use singular_position::{INTERPOLATED, SingularPositions};
pub(crate) use singularity_distance::{IRREGULAR, NEAR, SINGULAR, SingularityDistance};
pub(crate) use solver::MultiplierRounding;
pub(crate) use tree_linearization::{has_momenta, linearization_of_tree};
