//! The frequency response of a linear model.

use nalgebra::{Complex, DMatrix};

use super::LinearModel;

impl LinearModel {
    /// The responses `C (i w - A)^-1 B + D` at rates `w` in rad/s: for each of them one number for each output and, in
    /// it, input. They are not finite at the frequency of an oscillation without damping.
    ///
    /// `A` is brought to Hessenberg form once, so that each rate costs the square of the number of states.
    #[must_use]
    pub fn frequency_response(&self, rates: &[f64]) -> Vec<Vec<Vec<Complex<f64>>>> {
        let [a, b, c, d] = self.matrices.each_ref().map(|rows| matrix(rows));
        let size = a.nrows();
        let scale = scales(&a);
        let scaled = DMatrix::from_fn(size, size, |i, j| a[(i, j)] * scale[j] / scale[i]);
        let (turn, hessenberg) =
            if size > 2 { scaled.hessenberg().unpack() } else { (DMatrix::identity(size, size), scaled) };
        let inputs = turn.transpose() * DMatrix::from_fn(size, b.ncols(), |i, j| b[(i, j)] / scale[i]);
        let outputs = DMatrix::from_fn(c.nrows(), size, |i, j| c[(i, j)] * scale[j]) * turn;
        let response = |rate: &f64| {
            let states = solved(&hessenberg, *rate, &inputs);
            let entry = |row: usize, column: usize| {
                let own = (0..size).map(|k| states[(k, column)] * outputs[(row, k)]).sum::<Complex<f64>>();
                own + d[(row, column)]
            };
            (0..c.nrows()).map(|row| (0..b.ncols()).map(|column| entry(row, column)).collect()).collect()
        };
        rates.iter().map(response).collect()
    }
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |i, j| rows[i][j])
}

/// Powers of two that make rates as large as coordinates.
fn scales(a: &DMatrix<f64>) -> Vec<f64> {
    let size = a.nrows();
    let fastest = a.amax().sqrt();
    let power = if fastest.is_normal() { fastest.log2().round().exp2() } else { 1.0 };
    (0..size).map(|i| if i < size / 2 { 1.0 } else { power }).collect()
}

/// The solution of `(i w - H) x = b` by elimination below the diagonal.
fn solved(hessenberg: &DMatrix<f64>, rate: f64, b: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    let size = hessenberg.nrows();
    let complex = |value: f64| Complex::new(value, 0.0);
    let mut matrix = hessenberg.map(|entry| complex(-entry));
    for i in 0..size {
        matrix[(i, i)] += Complex::new(0.0, rate);
    }
    let mut x = b.map(complex);
    for k in 0..size.saturating_sub(1) {
        if matrix[(k + 1, k)].norm_sqr() > matrix[(k, k)].norm_sqr() {
            matrix.swap_rows(k, k + 1);
            x.swap_rows(k, k + 1);
        }
        let factor = matrix[(k + 1, k)] / matrix[(k, k)];
        for j in k..size {
            let entry = matrix[(k, j)];
            matrix[(k + 1, j)] -= factor * entry;
        }
        for j in 0..x.ncols() {
            let entry = x[(k, j)];
            x[(k + 1, j)] -= factor * entry;
        }
    }
    for j in 0..x.ncols() {
        for k in (0..size).rev() {
            let sum = (k + 1..size).map(|i| matrix[(k, i)] * x[(i, j)]).sum::<Complex<f64>>();
            x[(k, j)] = (x[(k, j)] - sum) / matrix[(k, k)];
        }
    }
    x
}
