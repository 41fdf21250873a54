//! Linear equations with interval coefficients.

use qrm_core::Interval;

use super::matrix::{IntervalMatrix, sum};

/// Linear equations with a unique solution for every matrix in an interval matrix `A`.
///
/// With an approximate inverse `R` of the midpoints and `G = I - R A`, a solution is `x = R b + G x`. If `|G| d <= g d`
/// with positive weights `d` and `g < 1`, every matrix has an inverse, and `x` is at most `|R b| / (1 - g)` in the norm
/// with these weights (S. M. Rump, Verification methods, Acta Numerica 19, 2010).
#[derive(Clone, Debug)]
pub(super) struct IntervalLinearSolver {
    /// `R`.
    inverse: IntervalMatrix,
    /// `G`.
    deviation: IntervalMatrix,
    weights: Vec<Interval>,
    /// Contains `1 - g`.
    margin: Interval,
}

/// The number of passes that adapt the weights to the matrix.
const WEIGHT_PASSES: usize = 8;
/// The number of passes that tighten the enclosure of a solution.
const PASSES: usize = 2;

impl IntervalLinearSolver {
    /// Creates the equations of a square matrix; `None` if it is not proved that all of its matrices have an inverse.
    pub(super) fn new(matrix: &IntervalMatrix) -> Option<Self> {
        if !matrix.is_finite() {
            return None;
        }
        let inverse = IntervalMatrix::from_matrix(&matrix.mid().try_inverse()?);
        let product = inverse.times(matrix);
        let size = matrix.rows();
        let deviation = IntervalMatrix::from_fn(size, size, |i, j| {
            (if i == j { Interval::ONE } else { Interval::ZERO }) - product.at(i, j)
        });
        let sizes = IntervalMatrix::from_fn(size, size, |i, j| Interval::point(deviation.at(i, j).magnitude()));
        let mut weights = vec![Interval::ONE; size];
        for _ in 0..WEIGHT_PASSES {
            weights = sizes.applied(&weights).into_iter().map(|grown| Interval::point(1.0 + grown.hi())).collect();
        }
        let contraction = norm(&sizes.applied(&weights), &weights);
        let margin = Interval::ONE - Interval::point(contraction);
        (margin.lo() > 0.0).then_some(Self { inverse, deviation, weights, margin })
    }

    /// An enclosure of the solutions.
    pub(super) fn solve(&self, right: &[Interval]) -> Vec<Interval> {
        let first = self.inverse.applied(right);
        let bound = Interval::point(norm(&first, &self.weights)) / self.margin;
        let ball = |weight: &Interval| {
            let size = (bound * *weight).hi();
            Interval::new(-size, size)
        };
        let solution = self.weights.iter().map(ball).collect();
        (0..PASSES).fold(solution, |solution, _| sum(&first, &self.deviation.applied(&solution)))
    }

    /// Enclosures of the solutions for each column of a matrix.
    pub(super) fn solve_columns(&self, right: &IntervalMatrix) -> IntervalMatrix {
        let columns: Vec<Vec<Interval>> = (0..right.columns()).map(|j| self.solve(&right.column(j))).collect();
        IntervalMatrix::from_fn(right.rows(), right.columns(), |i, j| columns[j][i])
    }
}

/// An upper bound of the largest ratio of a component to its weight.
fn norm(vector: &[Interval], weights: &[Interval]) -> f64 {
    let ratio = |(value, weight): (&Interval, &Interval)| (Interval::point(value.magnitude()) / *weight).hi();
    vector.iter().zip(weights).map(ratio).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(entries: [[f64; 2]; 2], width: f64) -> IntervalMatrix {
        IntervalMatrix::from_fn(2, 2, |i, j| Interval::new(entries[i][j] - width, entries[i][j] + width))
    }

    #[test]
    fn solutions_at_all_corners_are_contained() {
        // Unknowns of very different sizes, like accelerations and forces.
        let (entries, width) = ([[100.0, 0.3], [0.2, 1e-3]], 1e-6);
        let linear = IntervalLinearSolver::new(&matrix(entries, width)).expect("all have an inverse");
        let right = [1.0, 2.0];
        let solution = linear.solve(&right.map(Interval::point));
        for corner in 0..16 {
            let entry = |k: usize| entries[k / 2][k % 2] + if corner >> k & 1 == 1 { width } else { -width };
            let [a, b, c, d] = [0, 1, 2, 3].map(entry);
            let determinant = a * d - b * c;
            let exact = [(d * right[0] - b * right[1]) / determinant, (a * right[1] - c * right[0]) / determinant];
            assert!(solution.iter().zip(exact).all(|(solution, exact)| solution.contains(exact)), "{corner}");
        }
    }

    #[test]
    fn a_singular_matrix_within_is_seen() {
        assert!(IntervalLinearSolver::new(&matrix([[1.0, 1.0], [1.0, 1.1]], 0.01)).is_some());
        assert!(IntervalLinearSolver::new(&matrix([[1.0, 1.0], [1.0, 1.1]], 0.06)).is_none());
        assert!(IntervalLinearSolver::new(&matrix([[1.0, 1.0], [1.0, 1.0]], 0.0)).is_none());
    }
}
