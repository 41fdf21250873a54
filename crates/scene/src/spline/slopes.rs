//! Slopes of cubic splines at their points.

/// The coefficients of an equation for the slopes, left of the diagonal, on it and right of it, and its right-hand
/// side: second derivatives are equal on both sides of point `i`, which lies between the points `before` and `after`.
fn row(x: &[f64], y: &[f64], [before, i, after]: [usize; 3], period: f64) -> [f64; 4] {
    let wrapped = |length: f64| if length > 0.0 { length } else { length + period };
    let (left, right) = (wrapped(x[i] - x[before]), wrapped(x[after] - x[i]));
    let chords = [(y[i] - y[before]) / left, (y[after] - y[i]) / right];
    [right, 2.0 * (left + right), left, 3.0 * (right * chords[0] + left * chords[1])]
}

/// The slopes of the natural spline at its points.
pub(super) fn natural_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let last = x.len() - 1;
    let chord = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
    let mut rows = vec![[0.0, 2.0, 1.0, 3.0 * chord(0)]];
    rows.extend((1..last).map(|i| row(x, y, [i - 1, i, i + 1], 0.0)));
    rows.push([1.0, 2.0, 0.0, 3.0 * chord(last - 1)]);
    tridiagonal(&rows, &rows.iter().map(|row| row[3]).collect::<Vec<f64>>())
}

/// The slopes of the periodic spline at its points. The equations are tridiagonal except for two corners, which a
/// multiple of another solution compensates.
pub(super) fn periodic_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let count = x.len() - 1;
    let period = x[count] - x[0];
    let mut rows: Vec<[f64; 4]> =
        (0..count).map(|i| row(x, y, [(i + count - 1) % count, i, (i + 1) % count], period)).collect();
    let (upper, lower) = (rows[0][0], rows[count - 1][2]);
    let shift = -rows[0][1];
    rows[0][1] -= shift;
    rows[count - 1][1] -= upper * lower / shift;
    let right: Vec<f64> = rows.iter().map(|row| row[3]).collect();
    let mut corner = vec![0.0; count];
    (corner[0], corner[count - 1]) = (shift, lower);
    let (slopes, other) = (tridiagonal(&rows, &right), tridiagonal(&rows, &corner));
    let of = |v: &[f64]| v[0] + upper / shift * v[count - 1];
    let factor = of(&slopes) / (1.0 + of(&other));
    let mut slopes: Vec<f64> = slopes.iter().zip(&other).map(|(slope, other)| slope - factor * other).collect();
    slopes.push(slopes[0]);
    slopes
}

/// Solves diagonally dominant tridiagonal equations.
fn tridiagonal(rows: &[[f64; 4]], right: &[f64]) -> Vec<f64> {
    let count = rows.len();
    let (mut diagonal, mut x) = (rows.iter().map(|row| row[1]).collect::<Vec<f64>>(), right.to_vec());
    for i in 1..count {
        let ratio = rows[i][0] / diagonal[i - 1];
        diagonal[i] -= ratio * rows[i - 1][2];
        x[i] -= ratio * x[i - 1];
    }
    x[count - 1] /= diagonal[count - 1];
    for i in (0..count - 1).rev() {
        x[i] = (x[i] - rows[i][2] * x[i + 1]) / diagonal[i];
    }
    x
}
