//! The classical Runge-Kutta step of order 4, without projection.

use qrm_core::Mechanism;

use crate::acceleration::by_plain_functions;
use crate::linear::{Ldl, Vector, along};
use crate::solve::{Care, Undetermined};

/// One step of length `h` from `(q, qd)`, where the accelerations `qdd` are known already; also the factors of the mass
/// matrix at the last stage, which lies close to the end of the step.
///
/// # Errors
/// At some stage the accelerations are not determined.
#[inline(always)]
pub fn step<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    h: f64,
    (q, qd, qdd): (&Vector<N>, &Vector<N>, &Vector<N>),
    care: &mut Care,
) -> Result<(Vector<N>, Vector<N>, Option<Ldl<N>>), Undetermined> {
    let mut stage = |t: f64, h: f64, v: &Vector<N>, a: &Vector<N>| {
        let v_next = along(qd, h, a);
        let solution = by_plain_functions(mechanism, t, &along(q, h, v), &v_next, care)?;
        Ok((v_next, solution.qdd, solution.mass))
    };
    let (v2, a2, _) = stage(t + 0.5 * h, 0.5 * h, qd, qdd)?;
    let (v3, a3, _) = stage(t + 0.5 * h, 0.5 * h, &v2, &a2)?;
    let (v4, a4, mass) = stage(t + h, h, &v3, &a3)?;
    let mean = |k: [&Vector<N>; 4]| -> Vector<N> {
        std::array::from_fn(|i| (k[0][i] + 2.0 * (k[1][i] + k[2][i]) + k[3][i]) / 6.0)
    };
    let (q, qd) = (along(q, h, &mean([qd, &v2, &v3, &v4])), along(qd, h, &mean([qdd, &a2, &a3, &a4])));
    Ok((q, qd, mass))
}
