//! Singular values of wide matrices.

use super::{Ldl, Matrix, Vector, dot};

/// The smallest singular value of a matrix, and the combination of its rows that is so short.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smallest<const R: usize> {
    /// The value.
    pub value: f64,
    /// The combination, of length one.
    pub rows: Vector<R>,
}

/// Turns of rows in pairs are at an end far earlier.
const MOST_SWEEPS: usize = 30;

/// The smallest singular value, accurate to rounding errors of its own size and not only of the largest one; `None` without
/// rows.
///
/// The rows are turned in pairs until they are at right angles (one-sided Jacobi); their lengths are the singular values.
pub fn smallest<const R: usize, const C: usize>(matrix: &Matrix<R, C>) -> Option<Smallest<R>> {
    let mut rows = *matrix;
    let mut turns: Matrix<R, R> = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..MOST_SWEEPS {
        let mut is_done = true;
        for p in 0..R {
            for q in p + 1..R {
                let (a, b, both) = (dot(&rows[p], &rows[p]), dot(&rows[q], &rows[q]), dot(&rows[p], &rows[q]));
                if !(both.abs() > 2.0 * f64::EPSILON * (a * b).sqrt()) {
                    continue;
                }
                is_done = false;
                let zeta = (b - a) / (2.0 * both);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cos = tangent.hypot(1.0).recip();
                turn(&mut rows, (p, q), cos, cos * tangent);
                turn(&mut turns, (p, q), cos, cos * tangent);
            }
        }
        if is_done {
            break;
        }
    }
    let lengths = rows.map(|row| dot(&row, &row).sqrt());
    let place = (0..R).min_by(|&a, &b| lengths[a].total_cmp(&lengths[b]))?;
    Some(Smallest { value: lengths[place], rows: turns[place] })
}

/// The same for many rows that change little from one call to the next, by two steps of inverse iteration from the last
/// combination; `None` where that is no way to find it.
pub fn tracked<const R: usize, const C: usize>(matrix: &Matrix<R, C>, last: &mut Vec<f64>) -> Option<Smallest<R>> {
    let products: Matrix<R, R> =
        std::array::from_fn(|i| std::array::from_fn(|j| if j <= i { dot(&matrix[i], &matrix[j]) } else { 0.0 }));
    let factors = Ldl::of_products(&products)?;
    if last.is_empty() {
        // No two parts alike: the combination must not be missed for symmetry.
        last.extend((0..R).map(|k| 1.0 + 0.1 * (k as f64).sin()));
    }
    let mut x: Vector<R> = std::array::from_fn(|i| last[i]);
    let mut length = f64::NAN;
    for _ in 0..2 {
        x = factors.solve(&x);
        length = dot(&x, &x).sqrt();
        x = x.map(|value| value / length);
    }
    last.copy_from_slice(&x);
    length.is_finite().then(|| Smallest { value: length.sqrt().recip(), rows: x })
}

fn turn<const R: usize, const C: usize>(rows: &mut Matrix<R, C>, (p, q): (usize, usize), cos: f64, sin: f64) {
    for i in 0..C {
        let (x, y) = (rows[p][i], rows[q][i]);
        rows[p][i] = cos * x - sin * y;
        rows[q][i] = sin * x + cos * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_rows_at_right_angles_it_is_the_shorter_one() {
        let found = smallest(&[[3.0, 0.0, 0.0], [0.0, 0.0, 1e-12]]).expect("two rows");
        assert_eq!((found.value, found.rows), (1e-12, [0.0, 1.0]));
        assert_eq!(smallest::<0, 3>(&[]), None);
    }

    #[test]
    fn product_and_sum_of_squares_are_those_of_the_matrix() {
        // Two rows at an angle of 1e-7: |a| |b| sin = largest * smallest.
        let found = smallest(&[[1.0, 0.0], [2.0, 2e-7]]).expect("two rows");
        let largest = (5.0_f64 + 4e-14).sqrt();
        assert!((found.value * largest / 2e-7 - 1.0).abs() < 1e-12, "{found:?}");
        // The combination that is so short.
        let sum: Vec<f64> = (0..2).map(|i| found.rows[0] * [1.0, 0.0][i] + found.rows[1] * [2.0, 2e-7][i]).collect();
        assert!((sum[0].hypot(sum[1]) / found.value - 1.0).abs() < 1e-7);
    }

    #[test]
    fn three_rows_of_which_one_is_the_sum_of_the_others() {
        let found = smallest(&[[1.0, 2.0, 0.5], [3.0, -1.0, 2.0], [4.0, 1.0, 2.5]]).expect("three rows");
        assert!(found.value < 1e-15, "{found:?}");
        let third = 1.0 / 3.0_f64.sqrt();
        assert!(found.rows.iter().all(|part| (part.abs() - third).abs() < 1e-14), "{found:?}");
    }
}
