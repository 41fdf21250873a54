//! Projection and accelerations of a state by a kernel.

use crate::angles::Angles;
use crate::kernel::{Kernel, MAX_GROWTH};
use crate::scalar::Scalar;
use crate::step_end::StepEnd;
use crate::vectors::largest;

/// A buffer for a state.
#[derive(Debug)]
pub struct StateMut<'a> {
    /// Coordinates.
    pub q: &'a mut [f64],
    /// Rates.
    pub qd: &'a mut [f64],
    /// Accelerations.
    pub qdd: &'a mut [f64],
    /// Multipliers.
    pub multipliers: &'a mut [f64],
}

/// The outcome of a projection.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProjectionResult {
    /// Largest residual of a constraint before the projection, in its unit.
    pub residual: f64,
    /// The number of corrections of the coordinates.
    pub corrections: u32,
}

/// Computes the accelerations and multipliers of a state at time `t`. With a `tolerance`, first projects the state up
/// to that residual. Returns `None` where the kernel is not valid at the position, or a number is not finite.
#[inline]
pub(crate) fn complete<K: Kernel<f64, N, M>, const N: usize, const M: usize>(
    kernel: &K,
    t: f64,
    tolerance: Option<f64>,
    state: StateMut,
) -> Option<ProjectionResult> {
    let [n, m] = kernel.sizes();
    let (q, qd) = (padded(state.q, n)?, padded(state.qd, n)?);
    let angles = Angles::new(&q, kernel.has_angle());
    let mut end = StepEnd { q, qd, increment: [0.0; N], angles, corrections: 0 };
    let mut residual = None;
    loop {
        let position = kernel.position(t, &end.q, &end.angles);
        if let Some(tolerance) = tolerance {
            let open = largest(&kernel.residuals(&position));
            residual.get_or_insert(open);
            if end.project_coordinates::<K, M>(kernel, &position) {
                continue;
            }
            if !(open <= tolerance) {
                return None;
            }
            end.project_rates(kernel, &position);
        }
        let (qdd, multipliers) = kernel.accelerations(&position, t, &end.q, &end.qd, &end.angles);
        let is_finite = are_finite(&qdd) && are_finite(&multipliers) && are_finite(&end.q) && are_finite(&end.qd);
        if !(kernel.growth_factor(&position) <= MAX_GROWTH && is_finite) {
            return None;
        }
        state.q.copy_from_slice(&end.q[..n]);
        state.qd.copy_from_slice(&end.qd[..n]);
        state.qdd.copy_from_slice(&qdd[..n]);
        state.multipliers.copy_from_slice(&multipliers[..m]);
        return Some(ProjectionResult { residual: residual.unwrap_or(0.0), corrections: end.corrections });
    }
}

/// The first `count` numbers, padded with zeros; `None` if there are fewer.
#[inline(always)]
pub(crate) fn padded<R: Scalar, const K: usize>(numbers: &[f64], count: usize) -> Option<[R; K]> {
    if numbers.len() != count || count > K {
        return None;
    }
    let mut padded = [R::zero(); K];
    for i in 0..count {
        padded[i] = R::from_f64(numbers[i]);
    }
    Some(padded)
}

#[inline]
fn are_finite(numbers: &[f64]) -> bool {
    // Zero times a number that is not finite is not a number.
    let mut sum = 0.0;
    for number in numbers {
        sum += number * 0.0;
    }
    sum == 0.0
}
