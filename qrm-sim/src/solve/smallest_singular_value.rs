//! Singular values of wide matrices.

use super::ldl::Ldl;
use super::matrix::{Matrix, dot};

/// The smallest singular values of successive matrices of the same size, without allocations.
#[derive(Clone, Debug)]
pub struct SmallestSingularValue {
    /// The normalized combination of rows with that length.
    pub combination: Vec<f64>,
    rows: Matrix,
    rotations: Matrix,
    products: Matrix,
    /// The rows with a nonzero entry in each column: constraints contain few coordinates.
    rows_of_columns: Vec<Vec<usize>>,
    factors: Ldl,
    is_tracking: bool,
    /// The number of smaller singular values to skip.
    redundant: usize,
}

/// The largest number of sweeps of row rotations; far fewer are needed.
const MOST_SWEEPS: usize = 30;

/// The relative change at which inverse iteration ends.
const SETTLED: f64 = 1e-6;
const MOST_INVERSE_ITERATIONS: usize = 20;
/// The smallest pivot, as a fraction of its diagonal entry, of products of rows that determine a singular value: pivots
/// are squares of such values, and are known to about five digits here.
const SMALLEST_PRODUCT: f64 = 1e-11;
/// The part of a fixed combination in the first one.
const MIXED: f64 = 1e-3;

/// The number of rows above which singular values are tracked from matrix to matrix instead of being recomputed.
const TRACKING_MIN_ROWS: usize = 16;

impl SmallestSingularValue {
    /// Creates buffers for matrices of this size.
    pub fn new(rows: usize, columns: usize) -> Self {
        Self {
            combination: (0..rows).map(asymmetric_start).collect(),
            rows: Matrix::zero(rows, columns),
            rotations: Matrix::zero(rows, rows),
            products: Matrix::zero(rows, rows),
            rows_of_columns: vec![Vec::new(); columns],
            factors: Ldl::with_size(rows),
            is_tracking: rows > TRACKING_MIN_ROWS,
            redundant: 0,
        }
    }

    /// Creates buffers for matrices of this size and rank; singular values that are zero because of the rank do not
    /// count.
    pub fn with_rank(rows: usize, columns: usize, rank: usize) -> Self {
        let room = Self::new(rows, columns);
        Self { is_tracking: room.is_tracking && rank == rows, redundant: rows - rank, ..room }
    }

    /// Finds the smallest singular value; `None` without rows.
    ///
    /// With many rows, the search begins with the last combination, and is fastest if the matrix has changed little.
    pub fn find(&mut self, matrix: &Matrix) -> Option<f64> {
        if self.is_tracking
            && let Some(value) = self.track(matrix)
        {
            Some(value)
        } else {
            self.recompute(matrix)
        }
    }

    /// Computes the smallest singular value, accurate relative to its own size.
    ///
    /// The rows are rotated in pairs until they are orthogonal (one-sided Jacobi); their lengths are then the singular
    /// values.
    fn recompute(&mut self, matrix: &Matrix) -> Option<f64> {
        let Self { rows, rotations, .. } = self;
        let count = matrix.rows();
        rows.copy_from(matrix);
        rotations.entries_mut().fill(0.0);
        (0..count).for_each(|k| rotations[k][k] = 1.0);
        for _ in 0..MOST_SWEEPS {
            let mut is_done = true;
            for p in 0..count {
                for q in p + 1..count {
                    let (a, b, both) = (dot(&rows[p], &rows[p]), dot(&rows[q], &rows[q]), dot(&rows[p], &rows[q]));
                    if !(both.abs() > 2.0 * f64::EPSILON * (a * b).sqrt()) {
                        continue;
                    }
                    is_done = false;
                    let zeta = (b - a) / (2.0 * both);
                    let tangent = zeta.signum() / (zeta.abs() + (zeta * zeta + 1.0).sqrt());
                    let cos = (tangent * tangent + 1.0).sqrt().recip();
                    rotate(rows, (p, q), cos, cos * tangent);
                    rotate(rotations, (p, q), cos, cos * tangent);
                }
            }
            if is_done {
                break;
            }
        }
        let length = |k: usize| dot(&rows[k], &rows[k]).sqrt();
        let is_shorter = |a: usize, b: usize| length(a).total_cmp(&length(b)).then(a.cmp(&b)).is_lt();
        let shorter = |place: usize| (0..count).filter(|&other| is_shorter(other, place)).count();
        let place = if self.redundant == 0 {
            (0..count).min_by(|&a, &b| length(a).total_cmp(&length(b)))?
        } else {
            (0..count).find(|&place| shorter(place) == self.redundant)?
        };
        self.combination.copy_from_slice(&rotations[place]);
        Some(length(place))
    }

    /// Finds the smallest singular value by inverse iteration from the last combination; `None` if it does not
    /// converge.
    fn track(&mut self, matrix: &Matrix) -> Option<f64> {
        self.products.entries_mut().fill(0.0);
        self.rows_of_columns.iter_mut().for_each(Vec::clear);
        for (i, row) in matrix.iter().enumerate() {
            for (k, rows) in self.rows_of_columns.iter_mut().enumerate().filter(|(k, _)| row[*k] != 0.0) {
                rows.push(i);
                rows.iter().for_each(|&j| self.products[i][j] += row[k] * matrix[j][k]);
            }
        }
        if !self.factors.factor_products_above(&self.products, SMALLEST_PRODUCT) {
            return None;
        }
        // No part may stay zero: another combination may become the shortest.
        for (k, part) in self.combination.iter_mut().enumerate() {
            *part += MIXED * asymmetric_start(k);
        }
        let mut length = f64::NAN;
        for _ in 0..MOST_INVERSE_ITERATIONS {
            let before = length;
            self.factors.solve(&mut self.combination);
            length = dot(&self.combination, &self.combination).sqrt();
            self.combination.iter_mut().for_each(|part| *part /= length);
            if (length - before).abs() <= SETTLED * length {
                return Some(length.sqrt().recip());
            }
        }
        None
    }
}

/// The parts of a combination without symmetry, so that symmetric problems miss no value.
fn asymmetric_start(k: usize) -> f64 {
    1.0 + 0.1 * (k as f64).sin()
}

fn rotate(rows: &mut Matrix, (p, q): (usize, usize), cos: f64, sin: f64) {
    for i in 0..rows.columns() {
        let (x, y) = (rows[p][i], rows[q][i]);
        rows[p][i] = cos * x - sin * y;
        rows[q][i] = sin * x + cos * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smallest<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> Option<(f64, Vec<f64>)> {
        let mut smallest = SmallestSingularValue::new(R, C);
        let value = smallest.find(&Matrix::from_fn(R, C, |i, j| rows[i][j]))?;
        Some((value, smallest.combination))
    }

    #[test]
    fn of_rows_at_right_angles_it_is_the_shorter_one() {
        let found = smallest([[3.0, 0.0, 0.0], [0.0, 0.0, 1e-12]]).expect("two rows");
        assert_eq!(found, (1e-12, vec![0.0, 1.0]));
        assert_eq!(smallest::<0, 3>([]), None);
    }

    #[test]
    fn product_and_sum_of_squares_are_those_of_the_matrix() {
        // Two rows at an angle of 1e-7: |a| |b| sin = largest * smallest.
        let (value, parts) = smallest([[1.0, 0.0], [2.0, 2e-7]]).expect("two rows");
        let largest = (5.0_f64 + 4e-14).sqrt();
        assert!((value * largest / 2e-7 - 1.0).abs() < 1e-12, "{value:e}");
        // The shortest combination.
        let sum: Vec<f64> = (0..2).map(|i| parts[0] * [1.0, 0.0][i] + parts[1] * [2.0, 2e-7][i]).collect();
        assert!((sum[0].hypot(sum[1]) / value - 1.0).abs() < 1e-7);
    }

    #[test]
    fn three_rows_of_which_one_is_the_sum_of_the_others() {
        let (value, parts) = smallest([[1.0, 2.0, 0.5], [3.0, -1.0, 2.0], [4.0, 1.0, 2.5]]).expect("three rows");
        assert!(value < 1e-15, "{value:e}");
        let third = 1.0 / 3.0_f64.sqrt();
        assert!(parts.iter().all(|part| (part.abs() - third).abs() < 1e-14), "{parts:?}");
    }
}
