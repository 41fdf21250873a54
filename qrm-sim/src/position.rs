//! Positions of a mechanism: the start, the solution of its loops, and the range of its given coordinates.

mod assembly;
mod assembly_branch;
mod loop_solver;
mod start;
mod start_uncertainty;

pub use assembly::{NotAssembled, assemble_from_guesses};
pub use assembly_branch::assemble;
pub use loop_solver::{LimitPosition, LoopSolver, Position};
pub use start::Start;

pub(crate) use assembly::{DependentCoordinates, completed};
pub(crate) use assembly_branch::AssemblyBranch;
pub(crate) use loop_solver::CONTINUATION;
pub(crate) use start_uncertainty::StartUncertainty;
#[cfg(feature = "events")]
pub(crate) use start_uncertainty::start_uncertainty;
