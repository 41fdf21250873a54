//! Static equilibrium: a position held at rest against the loads.

use qrm_core::Mechanism;

use crate::position::{LoopSolver, NotAssembled, Start, assemble};

/// A position in static equilibrium.
#[derive(Clone, Debug)]
pub struct StaticEquilibrium {
    /// The coordinates.
    pub q: Vec<f64>,
    /// The generalized force on each given coordinate that balances the loads, but those left out; zero for the others.
    pub forces: Vec<f64>,
    /// The multipliers.
    pub multipliers: Vec<f64>,
    /// The outputs at rest.
    pub outputs: Vec<f64>,
}

/// The reason why a position cannot be held.
#[derive(Clone, Debug)]
pub enum NoEquilibrium {
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
    /// The start is singular.
    Singular,
    /// Constraints depend on time.
    Driven,
    /// The path from the start to the position ends at a limit position.
    LimitPosition {
        /// The coordinates there.
        q: Vec<f64>,
        /// The constraint that cannot be satisfied beyond it.
        constraint: Option<usize>,
    },
    /// The forces at the position are not finite.
    NotFinite,
}

/// Moves continuously from the scene's start to a position, and balances it. `wanted` holds values for coordinates that
/// the scene gives at its start; other given coordinates keep their values. `left_out` is the work of the loads that
/// the balance leaves out, at a position and for a displacement of the coordinates.
///
/// # Errors
/// The position cannot be reached, or cannot be held.
pub fn static_equilibrium(
    mechanism: &dyn Mechanism,
    wanted: &[(usize, f64)],
    left_out: &dyn Fn(&[f64], &[f64]) -> f64,
) -> Result<StaticEquilibrium, NoEquilibrium> {
    if mechanism.is_driven() {
        return Err(NoEquilibrium::Driven);
    }
    let start = Start::new(mechanism);
    let drive = LoopSolver::new(mechanism, start.given.clone()).ok_or(NoEquilibrium::Singular)?;
    let (q, _) = assemble(mechanism, Start::new(mechanism)).map_err(NoEquilibrium::NotAssembled)?;
    let from = drive.solve_loops(q).ok_or(NoEquilibrium::Singular)?;
    let mut to = from.q.clone();
    for (coordinate, value) in wanted {
        to[*coordinate] = *value;
    }
    let position = drive
        .move_to(&from, &to)
        .map_err(|limit| NoEquilibrium::LimitPosition { constraint: drive.open_beyond(&limit), q: limit.position.q })?;
    let (multipliers, mut forces) = drive.balance(&position.q);
    for i in (0..forces.len()).filter(|i| start.given[*i]) {
        forces[i] += left_out(&position.q, &drive.tangent(&position, i));
    }
    let outputs = drive.outputs(&position.q, &multipliers);
    if !multipliers.iter().chain(&forces).chain(&outputs).all(|value| value.is_finite()) {
        return Err(NoEquilibrium::NotFinite);
    }
    Ok(StaticEquilibrium { q: position.q, forces, multipliers, outputs })
}
