//! Interpolation by cubic splines.

/// What a spline does at its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Its second derivative vanishes there.
    Natural,
    /// It goes on with its first piece: the last value is the first one.
    Periodic,
}

/// A cubic spline through points: two derivatives are continuous.
#[derive(Clone, Debug)]
pub struct Spline {
    pieces: Vec<[f64; 4]>,
}

impl Spline {
    /// The spline through points whose abscissae increase; at least two of them.
    ///
    /// The second derivatives follow from a tridiagonal system, which a periodic spline closes to a ring: de Boor, A
    /// Practical Guide to Splines, chapter 4.
    pub fn new(x: &[f64], y: &[f64], end: End) -> Self {
        let count = x.len() - 1;
        let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let slope: Vec<f64> = y.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
        let second = match end {
            End::Natural => {
                let inner = count.saturating_sub(1);
                let diagonal: Vec<f64> = (0..inner).map(|i| 2.0 * (h[i] + h[i + 1])).collect();
                let right: Vec<f64> = (0..inner).map(|i| 6.0 * (slope[i + 1] - slope[i])).collect();
                let beside = h.get(1..count).unwrap_or_default();
                let solved = tridiagonal(&diagonal, beside, &right);
                [vec![0.0], solved, vec![0.0]].concat()
            }
            End::Periodic => {
                let before = |i: usize| (i + count - 1) % count;
                let diagonal: Vec<f64> = (0..count).map(|i| 2.0 * (h[before(i)] + h[i])).collect();
                let right: Vec<f64> = (0..count).map(|i| 6.0 * (slope[i] - slope[before(i)])).collect();
                let mut solved = ring(&diagonal, &h, &right);
                solved.push(solved[0]);
                solved
            }
        };
        let piece = |i: usize| {
            let (a, b) = (second[i], second[i + 1]);
            [y[i], slope[i] - h[i] * (2.0 * a + b) / 6.0, a / 2.0, (b - a) / (6.0 * h[i])]
        };
        Self { pieces: (0..count).map(piece).collect() }
    }

    /// The coefficients of each piece by powers of the distance from its beginning, the constant first.
    pub fn pieces(&self) -> impl Iterator<Item = [f64; 4]> {
        self.pieces.iter().copied()
    }
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

/// Solves a symmetric tridiagonal system closed to a ring, in which `beside` couples each unknown with the next one and
/// the last with the first, by the formula of Sherman and Morrison.
fn ring(diagonal: &[f64], beside: &[f64], right: &[f64]) -> Vec<f64> {
    let count = diagonal.len();
    if count < 3 {
        // Both couplings join the same unknowns.
        let own = if count == 1 { diagonal[0] + 2.0 * beside[0] } else { diagonal[0] };
        let other = if count == 1 { 0.0 } else { beside[0] + beside[1] };
        let determinant = own * own - other * other;
        return (0..count).map(|i| (own * right[i] - other * right[count - 1 - i]) / determinant).collect();
    }
    let corner = beside[count - 1];
    let (gamma, last) = (-diagonal[0], count - 1);
    let mut inner = diagonal.to_vec();
    inner[0] -= gamma;
    inner[last] -= corner * corner / gamma;
    let mut u = vec![0.0; count];
    (u[0], u[last]) = (gamma, corner);
    let [x, z] = [right, &u].map(|right| tridiagonal(&inner, &beside[..last], right));
    let along = |v: &[f64]| v[0] + v[last] * corner / gamma;
    let factor = along(&x) / (1.0 + along(&z));
    x.iter().zip(&z).map(|(x, z)| x - factor * z).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(spline: &Spline, x: &[f64], piece: usize, at: f64) -> [f64; 3] {
        let [a, b, c, d] = spline.pieces[piece];
        let s = at - x[piece];
        [a + s * (b + s * (c + s * d)), b + s * (2.0 * c + 3.0 * s * d), 2.0 * c + 6.0 * s * d]
    }

    #[test]
    fn pieces_meet_with_two_derivatives() {
        let x = [0.0, 0.7, 1.1, 2.0, 2.3, 3.5];
        let y = [1.0, -2.0, 0.5, 3.0, 2.0, 1.0];
        for end in [End::Natural, End::Periodic] {
            let spline = Spline::new(&x, &y, end);
            for i in 1..5 {
                let (left, right) = (at(&spline, &x, i - 1, x[i]), at(&spline, &x, i, x[i]));
                for (left, right) in left.iter().zip(right) {
                    assert!((left - right).abs() < 1e-12, "{end:?} {i}: {left} {right}");
                }
                assert!((right[0] - y[i]).abs() < 1e-15);
            }
            let (first, last) = (at(&spline, &x, 0, 0.0), at(&spline, &x, 4, 3.5));
            match end {
                End::Natural => assert!(first[2].abs() < 1e-13 && last[2].abs() < 1e-13),
                End::Periodic => {
                    assert!(first.iter().zip(last).all(|(a, b)| (a - b).abs() < 1e-12), "{first:?} {last:?}");
                }
            }
        }
    }

    #[test]
    fn a_periodic_spline_follows_a_sine() {
        for (count, error) in [(2, 1.0), (3, 0.2), (24, 2e-5)] {
            let x: Vec<f64> = (0..=count).map(|i| std::f64::consts::TAU * f64::from(i) / f64::from(count)).collect();
            let mut y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
            y[count as usize] = y[0];
            let spline = Spline::new(&x, &y, End::Periodic);
            for i in 0..count as usize {
                let middle = 0.5 * (x[i] + x[i + 1]);
                let off = (at(&spline, &x, i, middle)[0] - middle.sin()).abs();
                assert!(off <= error, "{count}: {off}");
            }
        }
    }
}
