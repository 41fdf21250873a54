//! Gauss-Newton correction of positions and rates after a step.

use qrm_mechanism::Mechanism;

use crate::linear::{Ldl, Vector, largest, multiply};
use crate::solve::{Care, Corrector};

/// In which metric the correction is smallest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// No correction.
    None,
    /// Least change of the coordinates.
    Euclidean,
    /// Least change of the mass-weighted coordinates.
    #[default]
    Mass,
}

/// When a correction of positions is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest residual of a constraint, in its unit.
    pub residual: f64,
    /// Most iterations.
    pub iterations: u32,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { residual: 1e-12, iterations: 10 }
    }
}

/// Where corrections no longer lower a residual, rounding errors do not let them: up to this many times the tolerance
/// that is said, not refused.
const SETTLED: f64 = 1e3;

/// The correction of positions did not converge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotConverged {
    /// The constraint that is farthest from closed.
    pub constraint: usize,
    /// Its residual.
    pub residual: f64,
    /// How many iterations were made.
    pub iterations: u32,
}

/// Moves `q` onto the constraints and `qd` onto their tangent; returns how many evaluations of the constraints it took.
///
/// # Errors
/// The residual is still above the tolerance after the allowed iterations.
#[inline(always)]
pub fn project<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    (projection, tolerance): (Projection, Tolerance),
    mass: Option<&Ldl<N>>,
    q: &mut Vector<N>,
    qd: &mut Vector<N>,
    care: &mut Care,
) -> Result<u32, NotConverged> {
    if M == 0 || projection == Projection::None {
        return Ok(0);
    }
    // A mass matrix that is singular by itself is no metric: those steps fall back to the plain one.
    let mass = mass.filter(|_| projection == Projection::Mass);
    let mut before = f64::INFINITY;
    for iteration in 0..=tolerance.iterations {
        let closure = mechanism.closure(q);
        let (constraint, residual) = largest(&closure.constraints);
        let is_settled = residual > 0.5 * before && residual <= SETTLED * tolerance.residual;
        let is_closed = residual <= tolerance.residual || is_settled;
        before = residual;
        if is_settled {
            care.note_settled(constraint, residual);
        }
        if !is_closed && (iteration == tolerance.iterations || !residual.is_finite()) {
            return Err(NotConverged { constraint, residual, iterations: iteration });
        }
        // The Jacobian is here anyway: one more correction costs next to nothing and takes the residual far below
        // the tolerance.
        let corrector = Corrector::new(&closure.constraint_jacobian, mass);
        corrector.correct(q, &closure.constraints, care);
        if is_closed {
            corrector.correct(qd, &multiply(&closure.constraint_jacobian, qd), care);
            return Ok(iteration + 1);
        }
    }
    Ok(tolerance.iterations)
}
