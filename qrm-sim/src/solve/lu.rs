//! General square systems by elimination with pivots.

use super::matrix::Matrix;
use super::nonzeros::Nonzeros;

/// The factors of a square matrix, with row exchanges.
#[derive(Clone, Debug)]
pub struct Lu {
    factors: Matrix,
    /// The nonzero entries of the factors.
    nonzeros: Nonzeros,
    order: Vec<usize>,
    /// The determinant; zero if the matrix is singular. That of a large matrix may exceed all doubles, or be below
    /// them.
    pub determinant: f64,
    /// Whether all pivots are finite and not zero.
    pub is_regular: bool,
}

impl Lu {
    /// Factors a matrix.
    pub fn new(matrix: Matrix) -> Self {
        let mut lu = Self::from_matrix(matrix);
        lu.factor();
        lu
    }

    /// Creates buffers for a matrix of this size.
    pub(crate) fn with_size(n: usize) -> Self {
        Self::from_matrix(Matrix::zero(n, n))
    }

    /// Creates buffers that hold a matrix, which is not factored yet.
    fn from_matrix(factors: Matrix) -> Self {
        let order = Vec::with_capacity(factors.columns());
        Self { factors, nonzeros: Nonzeros::default(), order, determinant: 1.0, is_regular: true }
    }

    /// Factors the matrix with these entries.
    pub(crate) fn factor_of(&mut self, entry: impl Fn(usize, usize) -> f64) {
        let n = self.factors.columns();
        for i in 0..n {
            for j in 0..n {
                self.factors[i][j] = entry(i, j);
            }
        }
        self.factor();
    }

    /// Replaces the matrix by its factors.
    fn factor(&mut self) {
        let Self { factors, nonzeros, order, determinant, is_regular } = self;
        let n = factors.columns();
        order.clear();
        order.extend(0..n);
        (*determinant, *is_regular) = (1.0, true);
        let mut others = Vec::with_capacity(n);
        for k in 0..n {
            let pivot = (k..n).max_by(|&a, &b| factors[a][k].abs().total_cmp(&factors[b][k].abs())).unwrap_or(k);
            if pivot != k {
                factors.swap_rows(pivot, k);
                order.swap(pivot, k);
                *determinant = -*determinant;
            }
            *determinant *= factors[k][k];
            *is_regular &= factors[k][k].is_finite() && factors[k][k] != 0.0;
            if factors[k][k] == 0.0 {
                break;
            }
            let (above, below) = factors.entries_mut().split_at_mut((k + 1) * n);
            let pivot_row = &above[k * n..];
            others.clear();
            others.extend((k + 1..n).filter(|&j| pivot_row[j] != 0.0));
            let is_dense = 2 * others.len() > n - k;
            for row in below.chunks_exact_mut(n).filter(|row| row[k] != 0.0) {
                row[k] /= pivot_row[k];
                let multiple = row[k];
                if is_dense {
                    row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]).for_each(|(own, other)| *own -= multiple * other);
                } else {
                    others.iter().for_each(|&j| row[j] -= multiple * pivot_row[j]);
                }
            }
        }
        nonzeros.find(factors.iter());
    }

    /// The solution for a right-hand side; not finite if the matrix is singular.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; right.len()];
        self.solve_into(right, &mut x);
        x
    }

    /// The solution for a right-hand side, written to `x`; not finite if the matrix is singular.
    pub(crate) fn solve_into(&self, right: &[f64], x: &mut [f64]) {
        let n = self.order.len();
        x.iter_mut().zip(&self.order).for_each(|(x, &i)| *x = right[i]);
        for i in 0..n {
            let (before, row) = (self.nonzeros.before_diagonal(i), &self.factors[i]);
            x[i] = before.iter().fold(x[i], |rest, &j| rest - row[j] * x[j]);
        }
        for i in (0..n).rev() {
            let (after, row) = (self.nonzeros.after_diagonal(i), &self.factors[i]);
            x[i] = after.iter().fold(x[i], |rest, &j| rest - row[j] * x[j]) / row[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix<const N: usize>(rows: [[f64; N]; N]) -> Matrix {
        Matrix::from_fn(N, N, |i, j| rows[i][j])
    }

    #[test]
    fn a_singular_matrix_has_no_determinant() {
        assert_eq!(Lu::new(matrix([[0.0, 0.0], [0.0, 1.0]])).determinant, 0.0);
        assert_eq!(Lu::new(matrix([[1.0, 2.0], [2.0, 4.0]])).determinant, 0.0);
    }

    #[test]
    fn a_large_matrix_of_small_numbers_is_regular() {
        let lu = Lu::new(Matrix::from_fn(200, 200, |i, j| if i == j { 1e-3 } else { 0.0 }));
        assert_eq!(lu.determinant, 0.0);
        assert!(lu.is_regular && lu.solve(&[1.0; 200]).iter().all(|x| (x - 1e3).abs() < 1e-9));
        assert!(!Lu::new(matrix([[1.0, 2.0], [2.0, 4.0]])).is_regular);
        assert!(!Lu::new(matrix([[f64::NAN]])).is_regular);
    }

    #[test]
    fn solves_with_rows_exchanged() {
        let lu = Lu::new(matrix([[0.0, 2.0, 1.0], [1.0, 1.0, 0.0], [3.0, 0.0, 4.0]]));
        assert!((lu.determinant + 11.0).abs() < 1e-14, "{}", lu.determinant);
        let x = lu.solve(&[7.0, 3.0, 15.0]);
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(x, y)| (x - y).abs() < 1e-14), "{x:?}");
    }
}
