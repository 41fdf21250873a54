//! Gauss-Newton correction of positions and rates after a step.

use qrm_core::Mechanism;

use crate::linear::{Ldl, Vector, largest};
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

/// Residuals up to this size, in m or rad, are rounding errors: near a singular position a correction would magnify them.
const ROUNDING: f64 = 4e-16;
/// Residuals up to this size, in m or rad, may be rounding errors: near a singular position they are magnified. A run
/// says where it had to be content with one.
const SETTLED: f64 = 1e-9;

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

/// Moves `q` onto the constraints at time `t` and `qd` onto their tangent, and says how often `q` was moved.
///
/// # Errors
/// The residual is still above the tolerance after the allowed iterations.
#[inline(always)]
pub fn project<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    (projection, tolerance): (Projection, Tolerance),
    mass: Option<&Ldl<N>>,
    t: f64,
    q: &mut Vector<N>,
    qd: &mut Vector<N>,
    care: &mut Care,
) -> Result<u32, NotConverged> {
    if M == 0 || projection == Projection::None {
        return Ok(0);
    }
    // A mass matrix that is singular by itself is no metric: those steps fall back to the plain one.
    let mass = mass.filter(|_| projection == Projection::Mass);
    let start = *q;
    let (mut open, mut before) = (0.0, f64::INFINITY);
    let mut iterations = 0;
    loop {
        let closure = mechanism.closure(t, q);
        let (constraint, residual) = largest(&closure.constraints);
        let is_closed = residual <= tolerance.residual;
        // A residual at the size of rounding errors that corrections no longer lower is as good as it gets.
        let is_settled = !is_closed && residual > 0.5 * before && residual <= SETTLED;
        if !is_closed && !is_settled && (iterations == tolerance.iterations || !residual.is_finite()) {
            return Err(NotConverged { constraint, residual, iterations });
        }
        let corrector = Corrector::new(&closure.constraint_jacobian, mass);
        if is_settled {
            care.note_settled(constraint, residual);
        } else if residual > ROUNDING {
            // The Jacobian is here anyway: one more correction of a closed position costs next to nothing and takes
            // the residual far below the tolerance.
            corrector.correct(q, &closure.constraints, care);
        }
        if iterations == 0 {
            open = residual;
        }
        if is_closed || is_settled {
            care.note_correction(open, &start, q);
            if mass.is_some() {
                // Rates belong to the position as it is now, in its own metric.
                let closure = mechanism.closure(t, q);
                let own = Ldl::new(&mechanism.mass_matrix(q));
                let corrector = Corrector::new(&closure.constraint_jacobian, own.as_ref());
                corrector.correct(qd, &closure.drift(qd), care);
            } else {
                corrector.correct(qd, &closure.drift(qd), care);
            }
            return Ok(iterations + u32::from(is_closed));
        }
        before = residual;
        iterations += 1;
    }
}
