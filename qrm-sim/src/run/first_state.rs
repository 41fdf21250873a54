//! The consistent state at the start of a motion.

use qrm_core::Mechanism;

use super::outcome::StartError;
use crate::integrate::StepError;
use crate::position::{AssemblyBranch, Start};
use crate::solve::{Solver, constraint_rank, constraint_without_gradient};
use crate::state::State;

/// Computes the consistent state at the start of a mechanism's motion.
///
/// # Errors
/// The constraints cannot be satisfied, or the accelerations are not determined.
pub(crate) fn first_state(
    mechanism: &dyn Mechanism,
    branch: &AssemblyBranch,
    start: Start,
) -> Result<State, StartError> {
    let mut first = first_position(mechanism, branch, start)?;
    Solver::at(mechanism, first.t, &first.q).complete(mechanism, &mut first).map_err(StartError::Step)?;
    Ok(first)
}

/// Computes the first state without accelerations and multipliers.
pub(crate) fn first_position(
    mechanism: &dyn Mechanism,
    branch: &AssemblyBranch,
    start: Start,
) -> Result<State, StartError> {
    let (q, qd) = branch.assemble(mechanism, start).map_err(StartError::NotAssembled)?;
    let description = mechanism.description();
    let count = description.constraints.len();
    if !description.friction.is_empty() && constraint_rank(mechanism, 0.0, &q) < count {
        return Err(StartError::Step(StepError::FrictionNotUnique));
    }
    // A page has no room for this test, which the command that wrote it has made.
    if cfg!(feature = "events")
        && let Some(constraint) = constraint_without_gradient(mechanism, 0.0, &q)
    {
        return Err(StartError::Step(StepError::NoGradient(constraint)));
    }
    let mut first = State::zero(q.len(), count);
    (first.q, first.qd) = (q, qd);
    Ok(first)
}
