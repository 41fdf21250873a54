//! The number of independent constraints.

use qrm_core::Mechanism;

use super::buffers::LoopConstraints;
use super::ldl::{Ldl, PivotedLdl};
use super::matrix::{Matrix, dot, largest, subtract_combination};
use super::projection_settings::ProjectionTolerance;

/// The distance of tested positions from a singular one, in rad, or relative to the largest length among the
/// coordinates.
const NEIGHBOUR_DISTANCE: f64 = 1e-2;
/// The number of tested times before and after, each twice as far away, for a driven mechanism.
const LATER: i32 = 12;
/// The largest number of corrections of such a position.
const ITERATIONS: usize = 30;
/// The smallest part of a coordinate in a motion that is not a rounding error.
const ROUNDING: f64 = 1e-6;

/// Computes the rank of `C_q` at a position and in its neighbourhood: the number of independent constraints.
///
/// If the rank drops only at a singular position, the rank in its neighbourhood counts. A mechanism with `n`
/// coordinates has `n` minus this number degrees of freedom.
pub fn constraint_rank(mechanism: &dyn Mechanism, t: f64, q: &[f64]) -> usize {
    let count = mechanism.description().constraints.len();
    let mut constraints = LoopConstraints::zero(q.len(), count);
    constraints.evaluate(mechanism, t, q);
    let products = row_products(&constraints.constraint_jacobian);
    if Ldl::with_size(count).factor_products(&products) {
        return count;
    }
    let factors = PivotedLdl::new(&products);
    let here = factors.rank;
    if here == count {
        return count;
    }
    let description = mechanism.description();
    let lengths = (0..q.len()).filter(|&i| !description.is_angle(i)).map(|i| q[i].abs()).fold(0.0, f64::max);
    let length = if lengths > 0.0 { lengths } else { 1.0 };
    let size = |i: usize| if description.is_angle(i) { 1.0 } else { length };
    let mut most = here;
    let is_neighbour =
        |position: &[f64]| (0..q.len()).any(|i| (position[i] - q[i]).abs() > 0.5 * NEIGHBOUR_DISTANCE * size(i));
    if mechanism.is_driven() {
        // A driven mechanism changes its position only with time.
        let step = mechanism.schedule().step;
        let times = (0..LATER).flat_map(|k| [1.0, -1.0].map(|sign| t + sign * step * 2.0_f64.powi(k)));
        let positions = times.filter_map(|t| closed(mechanism, t, q, count));
        let found = positions.filter(|(position, _)| is_neighbour(position)).take(2);
        return found.fold(here, |most, (_, jacobian)| most.max(PivotedLdl::new(&row_products(&jacobian)).rank));
    }
    for motion in motions(&constraints.constraint_jacobian, &factors) {
        let longest = (0..q.len()).map(|i| motion[i].abs() / size(i)).fold(0.0, f64::max);
        for distance in [NEIGHBOUR_DISTANCE, -NEIGHBOUR_DISTANCE] {
            let guess: Vec<f64> = q.iter().zip(&motion).map(|(q, part)| q + distance / longest * part).collect();
            let closed = closed(mechanism, t, &guess, here).or_else(|| closed(mechanism, t, &guess, count));
            // Residuals also vanish if corrections lead back to the singular position, which does not count.
            if let Some((position, jacobian)) = closed
                && is_neighbour(&position)
            {
                most = most.max(PivotedLdl::new(&row_products(&jacobian)).rank);
            }
            if most == count {
                return count;
            }
        }
    }
    most
}

/// `C_q C_q'`
pub(crate) fn row_products(jacobian: &Matrix) -> Matrix {
    let count = jacobian.rows();
    Matrix::from_fn(count, count, |i, j| dot(&jacobian[i], &jacobian[j]))
}

/// The motions of each coordinate that the constraints allow.
fn motions(jacobian: &Matrix, factors: &PivotedLdl) -> Vec<Vec<f64>> {
    let (count, n) = (jacobian.rows(), jacobian.columns());
    let motion = |i: usize| {
        let mut weights: Vec<f64> = (0..count).map(|k| jacobian[k][i]).collect();
        factors.solve(&mut weights);
        let mut motion = vec![0.0; n];
        motion[i] = 1.0;
        subtract_combination(&mut motion, jacobian, &weights);
        (largest(&motion).1 > ROUNDING).then_some(motion)
    };
    (0..n).filter_map(motion).collect()
}

/// The closed position near a guess, with `rank` independent constraints, and `C_q` there.
fn closed(mechanism: &dyn Mechanism, t: f64, guess: &[f64], rank: usize) -> Option<(Vec<f64>, Matrix)> {
    let mut q = guess.to_vec();
    let mut constraints = LoopConstraints::zero(q.len(), mechanism.description().constraints.len());
    for _ in 0..=ITERATIONS {
        constraints.evaluate(mechanism, t, &q);
        if largest(&constraints.residuals).1 <= ProjectionTolerance::default().residual {
            return Some((q, constraints.constraint_jacobian));
        }
        let jacobian = &constraints.constraint_jacobian;
        PivotedLdl::with_rank(&row_products(jacobian), rank).solve(&mut constraints.residuals);
        subtract_combination(&mut q, jacobian, &constraints.residuals);
    }
    None
}
