//! Saddle-point systems of ordinary numbers, solved in double-double precision.

use qrm_core::Scalar;

use super::elimination::Elimination;
use super::{Number, write_saddle};
use crate::solve::Dynamics;

/// The factors of `[M C_q'; C_q 0]`.
///
/// Where masses differ by many orders of magnitude, the Schur complement `C_q M^-1 C_q'` has no digits in double
/// precision, although the solution is well determined.
pub(crate) struct PreciseSaddlePoint {
    factors: Elimination,
}

impl PreciseSaddlePoint {
    /// Factors the system; `None` if it is singular.
    pub(crate) fn factored(dynamics: &Dynamics) -> Option<Self> {
        let precise = |entries: &[f64]| entries.iter().map(|entry| Number::from_f64(*entry)).collect::<Vec<_>>();
        let (n, m) = (dynamics.mass_matrix.rows(), dynamics.constraint_jacobian.rows());
        let jacobian = precise(dynamics.constraint_jacobian.entries());
        let rows: Vec<usize> = (0..m).collect();
        let mut factors = Elimination::zero(n + m);
        write_saddle(factors.entries_mut(), n, &precise(dynamics.mass_matrix.entries()), (&jacobian, &rows));
        factors.factor().then_some(Self { factors })
    }

    /// The solution for a right-hand side, `x` then `w`.
    pub(crate) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let right: Vec<Number> = right.iter().map(|x| Number::from_f64(*x)).collect();
        let mut solution = vec![Number::zero(); right.len()];
        self.factors.solve(&right, &mut solution);
        solution.into_iter().map(Scalar::to_f64).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass of 1e4 and one of 1e-9, held together by two constraints that differ by the heavy one's motion alone.
    #[test]
    fn masses_may_differ_by_many_orders_of_magnitude() {
        let mut dynamics = Dynamics::zero(3, 2);
        for (i, mass) in [1e4, 1e4, 1e-9].into_iter().enumerate() {
            dynamics.mass_matrix[i][i] = mass;
        }
        dynamics.constraint_jacobian.entries_mut().copy_from_slice(&[1.0, 0.0, 1.0, 0.0, 1.0, 1.0]);
        let solution = PreciseSaddlePoint::factored(&dynamics).expect("regular").solve(&[3.0, 1.0, 0.0, 0.0, 0.0]);
        // x1 = x2 = -x3; 2e4 x1 + 1e-9 x1 = 4 and w1 = 3 - 1e4 x1, w2 = 1 - 1e4 x2.
        let x = 4.0 / (2e4 + 1e-9);
        for (found, exact) in solution.iter().zip([x, x, -x, 3.0 - 1e4 * x, 1.0 - 1e4 * x]) {
            assert!((found - exact).abs() <= 1e-14 * exact.abs(), "{found} instead of {exact}");
        }
    }
}
