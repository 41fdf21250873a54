//! Nonlinear least squares by the method of Levenberg and Marquardt.

use super::ldl::Ldl;
use super::matrix::Matrix;

/// The largest number of iterations.
const MAX_ITERATIONS: usize = 200;

/// The residuals at a position, and their derivatives with respect to the coordinates.
#[derive(Clone, Debug)]
pub struct Residuals {
    /// The residuals.
    pub values: Vec<f64>,
    /// The derivatives, one row for each residual.
    pub jacobian: Matrix,
}

impl Residuals {
    /// Creates buffers for `count` residuals.
    pub fn zero(count: usize, coordinates: usize) -> Self {
        Self { values: vec![0.0; count], jacobian: Matrix::zero(count, coordinates) }
    }
}

/// Minimizes the sum of squares of `count` residuals over the coordinates that are not held.
pub fn least_squares(
    from: &[f64],
    is_held: &[bool],
    count: usize,
    evaluate: &mut dyn FnMut(&[f64], &mut Residuals),
) -> Vec<f64> {
    let n = from.len();
    let mut residuals = Residuals::zero(count, n);
    let mut trial = residuals.clone();
    let mut cost = |residuals: &mut Residuals, q: &[f64]| {
        evaluate(q, residuals);
        residuals.values.iter().map(|residual| residual.powi(2)).sum::<f64>()
    };
    let mut q = from.to_vec();
    let mut next = q.clone();
    let mut slope = vec![0.0; n];
    let mut row = vec![0.0; n];
    let mut normal = Matrix::zero(n, n);
    let mut factors = Ldl::with_size(n);
    let mut damping = 1e-3;
    let mut now = cost(&mut residuals, &q);
    for _ in 0..MAX_ITERATIONS {
        normal.entries_mut().fill(0.0);
        slope.fill(0.0);
        for (derivatives, residual) in residuals.jacobian.iter().zip(&residuals.values) {
            for i in 0..n {
                row[i] = if is_held[i] { 0.0 } else { derivatives[i] };
            }
            for i in 0..n {
                slope[i] -= row[i] * residual;
                for j in 0..n {
                    normal[i][j] += row[i] * row[j];
                }
            }
        }
        let size = (0..n).fold(0.0, |most: f64, i| most.max(normal[i][i]));
        for i in 0..n {
            normal[i][i] += if is_held[i] { 1.0 } else { damping * size + f64::MIN_POSITIVE };
        }
        if !factors.factor(&normal) {
            damping *= 10.0;
            continue;
        }
        factors.solve(&mut slope);
        for i in 0..n {
            next[i] = q[i] + slope[i];
        }
        // Shorter steps have no effect either.
        if next == q {
            break;
        }
        let then = cost(&mut trial, &next);
        if then < now {
            std::mem::swap(&mut residuals, &mut trial);
            q.copy_from_slice(&next);
            now = then;
            damping = (damping * 0.1).max(1e-15);
        } else if damping > 1e6 || now == 0.0 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_valley_of_rosenbrock_ends_at_one_and_one() {
        let mut valley = |q: &[f64], residuals: &mut Residuals| {
            residuals.values.copy_from_slice(&[10.0 * (q[1] - q[0] * q[0]), 1.0 - q[0]]);
            residuals.jacobian = Matrix::from_fn(2, 2, |i, j| [[-20.0 * q[0], 10.0], [-1.0, 0.0]][i][j]);
        };
        let found = least_squares(&[-1.2, 1.0], &[false; 2], 2, &mut valley);
        assert!(found.iter().all(|value| (value - 1.0).abs() < 1e-12), "{found:?}");
        assert_eq!(least_squares(&[-1.2, 1.0], &[true; 2], 2, &mut valley), [-1.2, 1.0]);
        let half = least_squares(&[0.5, 1.0], &[true, false], 2, &mut valley);
        assert!(half[0] == 0.5 && (half[1] - 0.25).abs() < 1e-12, "{half:?}");
    }
}
