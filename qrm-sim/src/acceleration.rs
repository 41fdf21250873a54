//! Accelerations at any position, singular ones too.

use qrm_core::Mechanism;

use crate::linear::{Ldl, Vector, along, largest};
use crate::projection::{Projection, Tolerance, project};
use crate::solve::{Care, Solution, Undetermined, accelerations};

/// How far the positions beside a singular one are, in rad or m: rounding errors in them are magnified by one over this, and
/// what is in between is wrong by its fourth power.
const ASIDE: f64 = 1e-4;

/// `qdd` and the multipliers, by the kernel where it suits the position.
///
/// # Errors
/// The accelerations are not determined.
#[inline(always)]
pub(crate) fn evaluate<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: &Vector<N>,
    qd: &Vector<N>,
    care: &mut Care,
) -> Result<(Vector<N>, Vector<M>), Undetermined> {
    if let Some(solution) = mechanism.accelerations(t, q, qd) {
        return Ok(solution);
    }
    let Solution { qdd, multipliers, .. } = by_plain_functions(mechanism, t, q, qd, care)?;
    Ok((qdd, multipliers))
}

/// `qdd` and the multipliers by the plain functions.
///
/// Where constraints depend on each other at one position alone, or one of them vanishes, they say too little there and next to
/// it, but not farther away: the accelerations a little before and a little after, along the motion, tell what they are in
/// between.
///
/// # Errors
/// The accelerations are not determined.
#[inline(always)]
pub(crate) fn by_plain_functions<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: &Vector<N>,
    qd: &Vector<N>,
    care: &mut Care,
) -> Result<Solution<N, M>, Undetermined> {
    let before = care.suspicious_constraints;
    let solution = accelerations(&mechanism.dynamics(t, q, qd), care)?;
    if care.suspicious_constraints == before {
        return Ok(solution);
    }
    Ok(bridged(mechanism, t, q, qd).map_or(solution, |(qdd, multipliers)| Solution { qdd, multipliers, ..solution }))
}

/// What is in between, from both sides; `None` if the constraints say too little there too, or the mechanism rests.
#[cold]
fn bridged<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: &Vector<N>,
    qd: &Vector<N>,
) -> Option<(Vector<N>, Vector<M>)> {
    let speed = largest(qd).1;
    if !(speed > 0.0 && speed.is_finite()) {
        return None;
    }
    let beside = |way: f64| {
        let mut care = Care::default();
        // Closures that depend on time are closed at the time when the motion is there.
        let t = if X::IS_DRIVEN { t + way / speed } else { t };
        let (mut position, mut rates) = (along(q, way / speed, qd), *qd);
        let mass = Ldl::new(&mechanism.mass_matrix(&position));
        let closing = (Projection::Mass, Tolerance::default());
        project(mechanism, closing, mass.as_ref(), t, &mut position, &mut rates, &mut care).ok()?;
        let solution = accelerations(&mechanism.dynamics(t, &position, &rates), &mut care).ok()?;
        (care.suspicious_constraints == 0).then_some(solution)
    };
    let (far_before, before) = (beside(-2.0 * ASIDE)?, beside(-ASIDE)?);
    let (after, far_after) = (beside(ASIDE)?, beside(2.0 * ASIDE)?);
    // The cubic through all four, in the middle.
    let middle = |outer: f64, inner: f64| (4.0 * inner - outer) / 6.0;
    let qdd = |i: usize| middle(far_before.qdd[i] + far_after.qdd[i], before.qdd[i] + after.qdd[i]);
    let multiplier = |k: usize| {
        middle(far_before.multipliers[k] + far_after.multipliers[k], before.multipliers[k] + after.multipliers[k])
    };
    Some((std::array::from_fn(qdd), std::array::from_fn(multiplier)))
}
