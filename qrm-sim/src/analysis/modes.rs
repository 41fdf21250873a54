//! Modes: the natural frequencies of a mechanism about an equilibrium, how they are damped, and how parameters change
//! them.

mod damped;
mod error;
mod null_space;
mod rest;
mod seeds;
mod undamped;

use nalgebra::{Complex, DMatrix, DVector};
use qrm_core::{Mechanism, Tape};

use super::equilibria::Equilibrium;

pub use damped::DampedMode;
pub use error::NoModes;
pub use undamped::{Mode, ModeKind};

pub(super) use rest::{RestEquations, RestState};
pub(super) use seeds::{constants, seeded};
use undamped::ReducedEquations;

/// Rounding errors of a sum or product in the equations, in parts of its terms.
pub(super) const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// The modes about an equilibrium.
#[derive(Clone, Debug)]
pub struct Modes {
    /// The modes without damping, those with the smallest squares of frequencies first.
    pub undamped: Vec<Mode>,
    /// The squares of frequencies, in 1/s^2, that are not real: growing oscillations of loads that are not
    /// conservative. One of each pair, with a positive imaginary part.
    pub complex_squares: Vec<Complex<f64>>,
    /// The eigenvalues with damping, one of each complex pair, the slowest decay first.
    pub damped: Vec<DampedMode>,
    /// The stability of the equilibrium.
    pub stability: EquilibriumStability,
    /// The estimated errors of the coordinates of the equilibrium.
    pub q_errors: Vec<f64>,
}

/// The stability of an equilibrium: the fate of small deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EquilibriumStability {
    /// They die down.
    AsymptoticallyStable,
    /// They stay small: nothing damps some of the oscillations.
    Stable,
    /// They stay small, or move the mechanism along a line of equilibria.
    Free,
    /// Some grow.
    Unstable,
    /// The linear equations do not tell, within their errors.
    Undecided,
}

/// Computes the modes about an equilibrium.
///
/// With `N`, whose columns are the motions that the constraints allow, small deviations `N a` follow
/// `N'Mbar N a'' + N'D N a' + N'K N a = 0`, where `K = (C_q' lambda - fbar)_q` and `D = -fbar_qd` come from the tape on
/// dual numbers. The derivatives of a frequency by parameters contain the move of the equilibrium.
///
/// # Errors
/// The position is singular, a motion has no inertia, or the eigenvalues cannot be computed: see [`NoModes`].
pub fn modes(mechanism: &dyn Mechanism, tape: &Tape, equilibrium: &Equilibrium) -> Result<Modes, NoModes> {
    let mut equations = RestEquations::new(mechanism, tape);
    let at = equations.at(&equilibrium.q, &equilibrium.preferred)?;
    let by = equations.by_parameters(&at);
    let reduced = ReducedEquations::new(&at)?;
    let rounding = rounding(&equations, &at, &by.forces, &by.constraints);
    let (undamped, complex_squares) = undamped::modes(&mut equations, &at, &reduced, &by, &rounding)?;
    let q_errors = q_errors(&at, &reduced, &rounding);
    let damped = damped::modes(&at, &reduced, &undamped, &complex_squares, &q_errors)?;
    let stability = stability(&reduced, &undamped, &complex_squares, &damped);
    Ok(Modes { undamped, complex_squares, damped, stability, q_errors })
}

/// The rounding errors of the equations at rest.
struct Rounding {
    forces: DVector<f64>,
    constraints: DVector<f64>,
}

/// The changes by the last digits of coordinates and parameters, and the rounding of sums.
fn rounding(
    equations: &RestEquations,
    at: &RestState,
    forces_by: &DMatrix<f64>,
    constraints_by: &DMatrix<f64>,
) -> Rounding {
    let q = DVector::from_column_slice(&at.q).abs();
    let parameters = DVector::from_column_slice(equations.parameters()).abs();
    let transposed = at.jacobian.transpose().abs();
    let terms = at.forces.abs() + transposed * at.multipliers.abs();
    let unbalanced = at.jacobian.transpose() * &at.multipliers - &at.forces;
    Rounding {
        forces: (terms + &at.stiffness_terms * &q + forces_by.abs() * &parameters) * ROUNDING + unbalanced.abs(),
        constraints: (at.jacobian.abs() * &q + constraints_by.abs() * &parameters) * ROUNDING,
    }
}

/// The errors of the coordinates by the rounding errors of the equations.
fn q_errors(at: &RestState, reduced: &ReducedEquations, rounding: &Rounding) -> Vec<f64> {
    let null_space = &at.null_space;
    let own = (&null_space.basis * &reduced.compliance).abs() * (null_space.basis.transpose().abs() * &rounding.forces);
    // A residual of a constraint moves the dependent coordinates, and changes the forces there.
    let mut moved = DVector::zeros(at.q.len());
    for (k, residual) in rounding.constraints.iter().enumerate() {
        let mut unit = DVector::zeros(rounding.constraints.len());
        unit[k] = *residual;
        let particular = null_space.particular(&unit);
        let follows =
            &null_space.basis * (&reduced.compliance * (null_space.basis.transpose() * (&at.stiffness * &particular)));
        moved += (particular - follows).abs();
    }
    own.iter().zip(moved.iter()).zip(&at.q).map(|((own, moved), q)| own + moved + ROUNDING * q.abs()).collect()
}

fn stability(
    reduced: &ReducedEquations,
    undamped: &[Mode],
    complex_squares: &[Complex<f64>],
    damped: &[DampedMode],
) -> EquilibriumStability {
    let is_free = undamped.iter().any(|mode| mode.kind() == ModeKind::Free);
    let grows = |mode: &DampedMode| mode.value.re > mode.error;
    let decays = |mode: &DampedMode| mode.value.re < -mode.error;
    let is_conservative = complex_squares.is_empty() && reduced.is_symmetric;
    let oscillates = |mode: &Mode| mode.kind() == ModeKind::Oscillation;
    if damped.iter().any(grows) {
        EquilibriumStability::Unstable
    } else if damped.iter().all(decays) {
        EquilibriumStability::AsymptoticallyStable
    } else if is_free {
        EquilibriumStability::Free
    } else if is_conservative && reduced.dissipates && undamped.iter().all(oscillates) {
        EquilibriumStability::Stable
    } else {
        EquilibriumStability::Undecided
    }
}
