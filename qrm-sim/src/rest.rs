//! A position held at rest against the loads.

use qrm_core::Mechanism;

use crate::assembly::{NotAssembled, assemble};
use crate::kinematics::Drive;

/// What holds a position at rest.
#[derive(Clone, Debug)]
pub struct Rest {
    /// The coordinates.
    pub q: Vec<f64>,
    /// The generalized force on each given coordinate that balances the loads; zero for the others.
    pub forces: Vec<f64>,
    /// The multipliers.
    pub multipliers: Vec<f64>,
    /// The outputs, without motion.
    pub outputs: Vec<f64>,
}

/// Why a position cannot be held.
#[derive(Clone, Debug)]
pub enum NoRest {
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
    /// The start itself is singular.
    Singular,
    /// Closures depend on time.
    Driven,
    /// The way from the start to the position ends here.
    Lock {
        /// The coordinates there.
        q: Vec<f64>,
        /// The constraint that cannot be closed beyond.
        constraint: Option<usize>,
    },
    /// The forces at the position are not finite.
    NotFinite,
}

/// Goes from the scene's start to a position without a jump, and balances it. `wanted` holds values for coordinates that
/// the scene gives at its start; the others of those stay as they are there.
///
/// # Errors
/// The position cannot be reached, or not be held.
pub fn rest<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    wanted: &[(usize, f64)],
) -> Result<Rest, NoRest> {
    if X::IS_DRIVEN {
        return Err(NoRest::Driven);
    }
    let start = mechanism.start();
    let drive = Drive::new(mechanism, start.given).ok_or(NoRest::Singular)?;
    let (q, _) = assemble(mechanism, &start).map_err(NoRest::NotAssembled)?;
    let from = drive.close(q).ok_or(NoRest::Singular)?;
    let mut to = from.q;
    for (coordinate, value) in wanted {
        to[*coordinate] = *value;
    }
    let position = drive
        .go(&from, &to)
        .map_err(|lock| NoRest::Lock { q: lock.position.q.to_vec(), constraint: lock.constraint })?;
    let (multipliers, forces) = drive.balance(&position.q);
    let outputs = drive.outputs(&position.q, &multipliers);
    if !multipliers.iter().chain(&forces).chain(&outputs).all(|value| value.is_finite()) {
        return Err(NoRest::NotFinite);
    }
    Ok(Rest { q: position.q.to_vec(), forces: forces.to_vec(), multipliers: multipliers.to_vec(), outputs })
}
