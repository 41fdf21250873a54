//! Linear equations with intervals as coefficients.

use nalgebra::DMatrix;
use qrm_core::Interval;

/// Linear equations that have one solution for every matrix in an interval matrix `A`.
///
/// With an approximate inverse `R` of the midpoints and `G = I - R A`, a solution is `x = R b + G x`. Where `|G| d <= g d`
/// with positive weights `d` and `g < 1`, every matrix has an inverse, and `x` is at most `|R b| / (1 - g)` in the norm
/// with these weights (S. M. Rump, Verification methods, Acta Numerica 19, 2010).
#[derive(Clone, Debug)]
pub(super) struct Linear {
    /// `R`, row by row.
    inverse: Vec<Interval>,
    /// `G`, row by row.
    deviation: Vec<Interval>,
    weights: Vec<f64>,
    /// A lower bound of `1 - g`.
    margin: Interval,
}

/// Passes that make weights fit the matrix.
const PASSES: usize = 8;

impl Linear {
    /// The equations with a matrix, row by row; `None` if it is not proved that all of its matrices have an inverse.
    pub(super) fn new(matrix: &[Interval], size: usize) -> Option<Self> {
        if matrix.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        let midpoints = DMatrix::from_fn(size, size, |i, j| matrix[i * size + j].mid());
        let near = midpoints.try_inverse()?;
        let inverse: Vec<Interval> = (0..size * size).map(|k| Interval::point(near[(k / size, k % size)])).collect();
        let mut deviation = product(&inverse, matrix, size);
        deviation.iter_mut().for_each(|entry| *entry = -*entry);
        for i in 0..size {
            deviation[i * (size + 1)] = deviation[i * (size + 1)] + Interval::ONE;
        }
        let grown = |weights: &[f64]| -> Vec<Interval> {
            let rows = deviation.chunks_exact(size.max(1));
            let sizes = |row: &[Interval]| {
                let terms = row.iter().zip(weights);
                terms.fold(Interval::ZERO, |sum, (entry, weight)| {
                    sum + Interval::point(entry.magnitude()) * Interval::point(*weight)
                })
            };
            rows.map(sizes).collect()
        };
        let mut weights = vec![1.0; size];
        for _ in 0..PASSES {
            weights = grown(&weights).iter().map(|grown| 1.0 + grown.hi()).collect();
        }
        let ratio = |(grown, weight): (&Interval, &f64)| (*grown / Interval::point(*weight)).hi();
        let contraction = grown(&weights).iter().zip(&weights).map(ratio).fold(0.0, f64::max);
        let margin = Interval::ONE - Interval::point(contraction);
        (margin.lo() > 0.0).then_some(Self { inverse, deviation, weights, margin })
    }

    /// An enclosure of the solutions.
    pub(super) fn solve(&self, right: &[Interval]) -> Vec<Interval> {
        let first = applied(&self.inverse, right);
        let ratio =
            |(value, weight): (&Interval, &f64)| (Interval::point(value.magnitude()) / Interval::point(*weight)).hi();
        let norm = first.iter().zip(&self.weights).map(ratio).fold(0.0, f64::max);
        let bound = (Interval::point(norm) / self.margin).hi();
        let solution: Vec<Interval> = (self.weights.iter())
            .map(|weight| {
                let size = (Interval::point(bound) * Interval::point(*weight)).hi();
                Interval::new(-size, size)
            })
            .collect();
        // Each pass keeps the solution, and makes its enclosure smaller.
        (0..2).fold(solution, |solution, _| {
            let change = applied(&self.deviation, &solution);
            first.iter().zip(change).map(|(first, change)| *first + change).collect()
        })
    }
}

/// A matrix, row by row, times a vector.
pub(super) fn applied(matrix: &[Interval], vector: &[Interval]) -> Vec<Interval> {
    matrix.chunks_exact(vector.len().max(1)).map(|row| dot(row, vector)).collect()
}

/// The product of two square matrices.
pub(super) fn product(a: &[Interval], b: &[Interval], size: usize) -> Vec<Interval> {
    let entry = |k: usize| {
        let (row, column) = (&a[k / size * size..][..size], b.iter().skip(k % size).step_by(size));
        row.iter().zip(column).fold(Interval::ZERO, |sum, (a, b)| sum + *a * *b)
    };
    (0..size * size).map(entry).collect()
}

fn dot(a: &[Interval], b: &[Interval]) -> Interval {
    a.iter().zip(b).fold(Interval::ZERO, |sum, (a, b)| sum + *a * *b)
}
