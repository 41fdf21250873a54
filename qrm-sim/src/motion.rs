//! The state of a motion under way, step by step.

use qrm_mechanism::Mechanism;

use crate::linear::Vector;
use crate::projection::{NotConverged, Projection, Tolerance, project};
use crate::rk4;
use crate::solve::{Care, Solution, Undetermined, accelerations};

/// How steps are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Method {
    /// Metric of the projection after each step.
    pub projection: Projection,
    /// When a projection is good enough.
    pub tolerance: Tolerance,
}

/// A corrected state with the accelerations and multipliers that belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment<const N: usize, const M: usize> {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Vector<N>,
    /// Rates.
    pub qd: Vector<N>,
    /// Accelerations.
    pub qdd: Vector<N>,
    /// Multipliers.
    pub multipliers: Vector<M>,
    /// How often the coordinates were corrected after the step to here.
    pub corrections: u32,
}

/// Why a step could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Breakdown {
    /// The projection did not converge.
    NotConverged(NotConverged),
    /// No inertia resists a motion of this coordinate that the constraints allow.
    Massless(usize),
    /// A number became infinite or undefined.
    NotFinite,
}

impl From<NotConverged> for Breakdown {
    fn from(e: NotConverged) -> Self {
        if e.residual.is_finite() { Self::NotConverged(e) } else { Self::NotFinite }
    }
}

impl From<Undetermined> for Breakdown {
    fn from(e: Undetermined) -> Self {
        match e {
            Undetermined::Massless(coordinate) => Self::Massless(coordinate),
            Undetermined::NotFinite => Self::NotFinite,
        }
    }
}

/// Completes a state to a moment.
///
/// # Errors
/// The accelerations are not determined, or not finite.
#[inline(always)]
pub fn moment<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: Vector<N>,
    qd: Vector<N>,
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    let Solution { qdd, multipliers, .. } = accelerations(&mechanism.dynamics(t, &q, &qd), care)?;
    let is_finite = [&q, &qd, &qdd].into_iter().all(all_finite) && all_finite(&multipliers);
    if is_finite { Ok(Moment { t, q, qd, qdd, multipliers, corrections: 0 }) } else { Err(Breakdown::NotFinite) }
}

#[inline(always)]
fn all_finite<const N: usize>(x: &Vector<N>) -> bool {
    let mut sum = 0.0;
    // Zero times a number that is not finite is not a number, and stays so in a sum.
    for value in x {
        sum += value * 0.0;
    }
    sum == 0.0
}

/// The moment after a step that ends at `t_next`.
///
/// # Errors
/// The step could not be made.
#[inline(always)]
pub fn advance<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    method: &Method,
    from: &Moment<N, M>,
    t_next: f64,
    care: &mut Care,
) -> Result<Moment<N, M>, Breakdown> {
    let (mut q, mut qd, mass) = rk4::step(mechanism, from.t, t_next - from.t, (&from.q, &from.qd, &from.qdd), care)?;
    let projection = (method.projection, method.tolerance);
    let corrections = project(mechanism, projection, mass.as_ref(), &mut q, &mut qd, care)?;
    Ok(Moment { corrections, ..moment(mechanism, t_next, q, qd, care)? })
}
