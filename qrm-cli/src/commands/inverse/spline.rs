//! Interpolation by a natural cubic spline.

/// The coefficients of each piece of the natural cubic spline through points whose abscissae increase, by powers of the
/// distance from its beginning, the constant first. Two derivatives are continuous, and the second one vanishes at both
/// ends.
///
/// The second derivatives follow from a tridiagonal system: de Boor, A Practical Guide to Splines, chapter 4.
pub(super) fn natural_spline(x: &[f64], y: &[f64]) -> Vec<[f64; 4]> {
    let count = x.len() - 1;
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let slope: Vec<f64> = y.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    let diagonal: Vec<f64> = h.windows(2).map(|pair| 2.0 * (pair[0] + pair[1])).collect();
    let right: Vec<f64> = slope.windows(2).map(|pair| 6.0 * (pair[1] - pair[0])).collect();
    let second = [vec![0.0], tridiagonal(&diagonal, h.get(1..count).unwrap_or_default(), &right), vec![0.0]].concat();
    let piece = |i: usize| {
        let (a, b) = (second[i], second[i + 1]);
        [y[i], slope[i] - h[i] * (2.0 * a + b) / 6.0, a / 2.0, (b - a) / (6.0 * h[i])]
    };
    (0..count).map(piece).collect()
}

/// Solves a symmetric tridiagonal system; `beside[i]` couples the unknowns `i` and `i + 1`.
fn tridiagonal(diagonal: &[f64], beside: &[f64], right: &[f64]) -> Vec<f64> {
    let count = diagonal.len();
    let (mut pivots, mut x) = (diagonal.to_vec(), right.to_vec());
    for i in 1..count {
        let ratio = beside[i - 1] / pivots[i - 1];
        pivots[i] -= ratio * beside[i - 1];
        x[i] -= ratio * x[i - 1];
    }
    for i in (0..count).rev() {
        let next = if i + 1 < count { beside[i] * x[i + 1] } else { 0.0 };
        x[i] = (x[i] - next) / pivots[i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pieces_are_known_in_closed_form() {
        // The second derivative in the middle of a hat of height 1 is -3.
        assert_eq!(natural_spline(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0]), [[0.0, 1.5, 0.0, -0.5], [1.0, 0.0, -1.5, 0.5]]);
        assert_eq!(natural_spline(&[0.0, 2.0], &[1.0, 5.0]), [[1.0, 2.0, 0.0, 0.0]]);
    }

    #[test]
    fn pieces_meet_with_two_derivatives() {
        let x = [0.0, 0.7, 1.1, 2.0, 2.3, 3.5];
        let y = [1.0, -2.0, 0.5, 3.0, 2.0, 1.0];
        let pieces = natural_spline(&x, &y);
        let at = |piece: usize, place: f64| {
            let ([a, b, c, d], s) = (pieces[piece], place - x[piece]);
            [a + s * (b + s * (c + s * d)), b + s * (2.0 * c + 3.0 * s * d), 2.0 * c + 6.0 * s * d]
        };
        for i in 1..5 {
            let (left, right) = (at(i - 1, x[i]), at(i, x[i]));
            for (left, right) in left.iter().zip(right) {
                assert!((left - right).abs() < 1e-12, "{i}: {left} {right}");
            }
            assert_eq!(right[0], y[i]);
        }
        assert!(at(0, 0.0)[2].abs() < 1e-13 && at(4, 3.5)[2].abs() < 1e-13);
    }
}
