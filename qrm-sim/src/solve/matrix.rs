//! Dense matrices in flat storage, and vectors as slices.

use std::ops::{Index, IndexMut};

/// A matrix, stored row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    columns: usize,
    entries: Vec<f64>,
}

impl Matrix {
    /// A matrix of zeros.
    pub fn zero(rows: usize, columns: usize) -> Self {
        Self { columns, entries: vec![0.0; rows * columns] }
    }

    /// Creates a matrix from its entries.
    pub fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut matrix = Self::zero(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                matrix[i][j] = entry(i, j);
            }
        }
        matrix
    }

    /// The number of rows; zero for a matrix without columns.
    pub fn rows(&self) -> usize {
        self.entries.len().checked_div(self.columns).unwrap_or(0)
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All entries, row by row.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// All entries, mutable, row by row.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.entries
    }

    /// The rows in their order.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.entries.chunks_exact(self.columns.max(1))
    }

    /// The Frobenius norm of the difference to another matrix of the same size.
    pub fn distance(&self, other: &Self) -> f64 {
        // Independent sums, which a processor adds at the same time.
        let mut sums = [0.0; 8];
        for (own, other) in self.entries.chunks(sums.len()).zip(other.entries.chunks(sums.len())) {
            sums.iter_mut().zip(own.iter().zip(other)).for_each(|(sum, (a, b))| *sum += (a - b) * (a - b));
        }
        sums.iter().sum::<f64>().sqrt()
    }

    /// Exchanges two rows.
    pub fn swap_rows(&mut self, a: usize, b: usize) {
        for j in 0..self.columns {
            self.entries.swap(a * self.columns + j, b * self.columns + j);
        }
    }

    /// Exchanges two columns.
    pub fn swap_columns(&mut self, a: usize, b: usize) {
        for row in self.entries.chunks_exact_mut(self.columns.max(1)) {
            row.swap(a, b);
        }
    }

    /// Copies the entries of another matrix of the same size, without a new allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.entries.copy_from_slice(&other.entries);
    }
}

impl Index<usize> for Matrix {
    type Output = [f64];
    #[inline(always)]
    fn index(&self, row: usize) -> &[f64] {
        &self.entries[row * self.columns..(row + 1) * self.columns]
    }
}

impl IndexMut<usize> for Matrix {
    #[inline(always)]
    fn index_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.entries[row * self.columns..(row + 1) * self.columns]
    }
}

/// `x . y`
#[inline(always)]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (x, y) in x.iter().zip(y) {
        sum += x * y;
    }
    sum
}

/// `x -= rows' weights`
pub(crate) fn subtract_combination(x: &mut [f64], rows: &Matrix, weights: &[f64]) {
    for (row, weight) in rows.iter().zip(weights) {
        for (x, entry) in x.iter_mut().zip(row) {
            *x -= weight * entry;
        }
    }
}

/// The index of the largest absolute value, and that value; not a number if any entry is not.
pub fn largest(x: &[f64]) -> (usize, f64) {
    let mut found = (0, 0.0);
    for (i, value) in x.iter().enumerate() {
        if !(value.abs() <= found.1) {
            found = (i, value.abs());
        }
        if found.1.is_nan() {
            break;
        }
    }
    found
}

/// Whether a symmetric matrix is positive semidefinite, by elimination with the largest diagonal entries first.
pub(crate) fn is_positive(mut matrix: Matrix) -> bool {
    let n = matrix.columns();
    let largest = (0..n).map(|i| matrix[i][i]).fold(f64::NEG_INFINITY, f64::max);
    let rounding = 1e-12 * largest.max(0.0);
    for _ in 0..n {
        if (0..n).any(|i| matrix[i][i] < -rounding) {
            return false;
        }
        let pivot = (0..n).max_by(|&i, &j| matrix[i][i].total_cmp(&matrix[j][j])).unwrap_or(0);
        let row = matrix[pivot].to_vec();
        if !(row[pivot] > rounding) {
            // The remaining diagonal is zero: entries off the diagonal then belong to pairs of a positive and a
            // negative eigenvalue.
            return matrix.entries().iter().all(|entry| entry.abs() <= rounding);
        }
        for i in 0..n {
            for j in 0..n {
                matrix[i][j] -= row[i] * row[j] / row[pivot];
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_where_they_belong() {
        let mut matrix = Matrix::from_fn(2, 3, |i, j| (10 * i + j) as f64);
        assert_eq!((matrix.rows(), matrix.columns(), &matrix[1]), (2, 3, &[10.0, 11.0, 12.0][..]));
        matrix.swap_rows(0, 1);
        matrix.swap_columns(0, 2);
        assert_eq!(matrix.entries(), [12.0, 11.0, 10.0, 2.0, 1.0, 0.0]);
        assert_eq!((Matrix::zero(0, 3).rows(), Matrix::zero(3, 0).rows()), (0, 0));
    }

    #[test]
    fn positive_matrices_have_no_negative_eigenvalue() {
        let is_positive = |entries: [[f64; 3]; 3]| is_positive(Matrix::from_fn(3, 3, |i, j| entries[i][j]));
        assert!(is_positive([[5.0, 2.0, 1.0], [2.0, 3.0, 1.0], [1.0, 1.0, 2.0]]));
        // Eigenvalues -1, 2, 3.
        assert!(!is_positive([[0.5, 1.5, 0.0], [1.5, 0.5, 0.0], [0.0, 0.0, 3.0]]));
        // The first pivot leaves 1 - 3/2 in the diagonal.
        assert!(!is_positive([[6.0, 3.0, 3.0], [3.0, 1.0, 1.5], [3.0, 1.5, 2.0]]));
        // Singular, of rank one and two.
        assert!(is_positive([[4.0, 2.0, 6.0], [2.0, 1.0, 3.0], [6.0, 3.0, 9.0]]));
        assert!(is_positive([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]));
        assert!(is_positive([[0.0; 3]; 3]));
        assert!(!is_positive([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]));
        assert!(!is_positive([[2.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]));
    }

    #[test]
    fn a_value_that_is_not_a_number_is_the_largest() {
        assert!(largest(&[1.0, f64::NAN, 2.0]).1.is_nan());
        assert_eq!(largest(&[1.0, -3.0, 2.0]), (1, 3.0));
    }
}
