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
/// The distance of positions that are to be regular, in the same units, and the largest number of motions to them.
const REGULAR_DISTANCE: f64 = 0.3;
const MOTIONS: usize = 2;
/// The largest entry of a gradient that is looked at more closely.
const SMALL_GRADIENT: f64 = 1e-5;
/// The distance, in parts of a coordinate or of 1, within which a residual without gradient determines a position: the
/// root of the tolerance of residuals, less than ten times.
const UNDETERMINED: f64 = 3e-6;
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
    let motions = motions(&constraints.constraint_jacobian, &factors);
    let near = positions_near(mechanism, t, q, motions, NEIGHBOUR_DISTANCE, here);
    let mut most = here;
    for (_, jacobian) in near {
        most = most.max(PivotedLdl::new(&row_products(&jacobian)).rank);
        if most == count {
            break;
        }
    }
    most
}

/// The Jacobians at a closed position and at some others along its motion, with `rank` independent constraints.
pub(super) fn neighbours(
    mechanism: &dyn Mechanism,
    t: f64,
    (q, qd): (&[f64], &[f64]),
    rank: usize,
) -> impl Iterator<Item = Matrix> {
    let jacobian = LoopConstraints::at(mechanism, t, q).constraint_jacobian;
    let motions = if largest(qd).1 > 0.0 {
        vec![qd.to_vec()]
    } else {
        let factors = PivotedLdl::with_rank(&row_products(&jacobian), rank);
        motions(&jacobian, &factors).into_iter().take(MOTIONS).collect()
    };
    let others = positions_near(mechanism, t, q, motions, REGULAR_DISTANCE, rank);
    std::iter::once(jacobian).chain(others.map(|(_, jacobian)| jacobian).collect::<Vec<_>>())
}

/// The closed positions at a distance from one, and `C_q` there, along some motions that the constraints allow, in
/// both directions. A driven mechanism changes its position only with time: there the next positions before and after.
fn positions_near<'a>(
    mechanism: &'a dyn Mechanism,
    t: f64,
    q: &'a [f64],
    motions: Vec<Vec<f64>>,
    distance: f64,
    rank: usize,
) -> Box<dyn Iterator<Item = (Vec<f64>, Matrix)> + 'a> {
    let description = mechanism.description();
    let count = description.constraints.len();
    let lengths = (0..q.len()).filter(|&i| !description.is_angle(i)).map(|i| q[i].abs()).fold(0.0, f64::max);
    let length = if lengths > 0.0 { lengths } else { 1.0 };
    let size = move |i: usize| if description.is_angle(i) { 1.0 } else { length };
    // Residuals also vanish if corrections lead back, which does not count.
    let is_neighbour =
        move |position: &[f64]| (0..q.len()).any(|i| (position[i] - q[i]).abs() > 0.5 * distance * size(i));
    if mechanism.is_driven() {
        let step = mechanism.schedule().step;
        let times = (0..LATER).flat_map(move |k| [1.0, -1.0].map(|sign| t + sign * step * 2.0_f64.powi(k)));
        let positions = times.filter_map(move |t| closed(mechanism, t, q, count));
        return Box::new(positions.filter(move |(position, _)| is_neighbour(position)).take(2));
    }
    let guesses = motions.into_iter().flat_map(move |motion| {
        let longest = (0..q.len()).map(|i| motion[i].abs() / size(i)).fold(0.0, f64::max);
        [distance, -distance].map(|distance| -> Vec<f64> {
            q.iter().zip(&motion).map(|(q, part)| q + distance / longest * part).collect()
        })
    });
    let closed = guesses
        .filter_map(move |guess| closed(mechanism, t, &guess, rank).or_else(|| closed(mechanism, t, &guess, count)));
    Box::new(closed.filter(move |(position, _)| is_neighbour(position)))
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

/// The constraint that has no gradient at a closed position, nor at those near it, though its residual changes: no
/// force can hold it. The result is `None` if every constraint has a gradient somewhere.
///
/// A gradient is none if it is not larger than its change within the distance to which a residual without gradient
/// determines a position.
pub fn constraint_without_gradient(mechanism: &dyn Mechanism, t: f64, q: &[f64]) -> Option<usize> {
    let jacobian = LoopConstraints::at(mechanism, t, q).constraint_jacobian;
    let is_small = |k: usize| largest(&jacobian[k]).1 <= SMALL_GRADIENT;
    let vanishes = |k: usize, q: &[f64], jacobian: &Matrix| {
        let change = |i: usize| {
            let mut moved = q.to_vec();
            moved[i] += UNDETERMINED * moved[i].abs().max(1.0);
            let changed = LoopConstraints::at(mechanism, t, &moved).constraint_jacobian;
            changed[k].iter().zip(&jacobian[k]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let most = (0..q.len()).map(change).fold(0.0, f64::max);
        most > 0.0 && largest(&jacobian[k]).1 <= most
    };
    let mut candidates = (0..jacobian.rows()).filter(|&k| is_small(k) && vanishes(k, q, &jacobian));
    candidates.find(|&k| {
        let factors = PivotedLdl::new(&row_products(&jacobian));
        let motions = motions(&jacobian, &factors);
        let mut near = positions_near(mechanism, t, q, motions, NEIGHBOUR_DISTANCE, factors.rank);
        near.all(|(position, jacobian)| vanishes(k, &position, &jacobian))
    })
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
