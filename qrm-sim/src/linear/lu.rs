//! General square systems.

use super::{Matrix, Vector};

/// Factors of a square matrix, rows exchanged.
#[derive(Clone, Copy, Debug)]
pub struct Lu<const M: usize> {
    factors: Matrix<M, M>,
    order: [usize; M],
    /// The determinant; zero if the matrix is singular.
    pub determinant: f64,
}

impl<const M: usize> Lu<M> {
    /// Factors a matrix.
    pub fn new(matrix: &Matrix<M, M>) -> Self {
        let mut factors = *matrix;
        let mut order: [usize; M] = std::array::from_fn(|i| i);
        let mut determinant = 1.0;
        for k in 0..M {
            let pivot = (k..M).max_by(|&a, &b| factors[a][k].abs().total_cmp(&factors[b][k].abs())).unwrap_or(k);
            if pivot != k {
                factors.swap(pivot, k);
                order.swap(pivot, k);
                determinant = -determinant;
            }
            determinant *= factors[k][k];
            if factors[k][k] == 0.0 {
                break;
            }
            for i in k + 1..M {
                factors[i][k] /= factors[k][k];
                for j in k + 1..M {
                    factors[i][j] -= factors[i][k] * factors[k][j];
                }
            }
        }
        Self { factors, order, determinant }
    }

    /// Solves for a right-hand side; not finite if the matrix is singular.
    pub fn solve(&self, right: &Vector<M>) -> Vector<M> {
        let mut x: Vector<M> = std::array::from_fn(|i| right[self.order[i]]);
        for i in 0..M {
            for j in 0..i {
                x[i] -= self.factors[i][j] * x[j];
            }
        }
        for i in (0..M).rev() {
            for j in i + 1..M {
                x[i] -= self.factors[i][j] * x[j];
            }
            x[i] /= self.factors[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::Lu;

    #[test]
    fn a_singular_matrix_has_no_determinant() {
        assert_eq!(Lu::new(&[[0.0, 0.0], [0.0, 1.0]]).determinant, 0.0);
        assert_eq!(Lu::new(&[[1.0, 2.0], [2.0, 4.0]]).determinant, 0.0);
    }

    #[test]
    fn solves_with_rows_exchanged() {
        let lu = Lu::new(&[[0.0, 2.0, 1.0], [1.0, 1.0, 0.0], [3.0, 0.0, 4.0]]);
        assert!((lu.determinant + 11.0).abs() < 1e-14, "{}", lu.determinant);
        let x = lu.solve(&[7.0, 3.0, 15.0]);
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(x, y)| (x - y).abs() < 1e-14), "{x:?}");
    }
}
