//! The integral of a column over time.

use crate::polynomial::{Number, Polynomial};
use crate::quadrature::GAUSS_3;

/// The number of rows for a polynomial.
const ROWS: usize = 6;

/// Integrates a column row by row, by polynomials of degree 5 through six rows around each step; the steps may differ.
#[derive(Clone, Debug)]
pub(crate) struct Integral<D> {
    /// The last rows: time, value.
    window: Vec<(D, D)>,
    sum: D,
}

impl<D: Number> Default for Integral<D> {
    fn default() -> Self {
        Self { window: Vec::new(), sum: D::from(0.0) }
    }
}

impl<D: Number> Integral<D> {
    /// Adds the next row.
    pub(crate) fn row(&mut self, t: D, value: D) {
        let is_first = self.window.len() < ROWS;
        if !is_first {
            self.window.remove(0);
        }
        self.window.push((t, value));
        if self.window.len() == ROWS {
            // The first steps do not have six rows around them.
            let from = if is_first { 0 } else { ROWS / 2 - 1 };
            self.sum += self.over(from, ROWS / 2);
        }
    }

    /// The integral over the rows so far.
    pub(crate) fn finish(&self) -> D {
        let last = self.window.len().saturating_sub(1);
        self.sum + self.over(if last + 1 == ROWS { ROWS / 2 } else { 0 }, last)
    }

    /// The integral from one row of the window to another.
    fn over(&self, from: usize, to: usize) -> D {
        let polynomial = Polynomial::through(&self.window);
        let mut sum = D::from(0.0);
        for step in self.window.get(from..=to).unwrap_or_default().windows(2) {
            let (half, middle) = ((step[1].0 - step[0].0) * 0.5, (step[1].0 + step[0].0) * 0.5);
            for (place, weight) in GAUSS_3 {
                sum += polynomial.value(middle + half * place) * half * weight;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral(rows: usize, end: f64, column: impl Fn(f64) -> f64) -> f64 {
        let mut integral = Integral::default();
        // The last step is shorter than the others, for example when a stop condition becomes true.
        let last = (rows - 1) as f64;
        let t = |i: usize| if i + 1 == rows { end } else { end * i as f64 / (last - 0.6) };
        (0..rows).for_each(|i| integral.row(t(i), column(t(i))));
        integral.finish()
    }

    #[test]
    fn polynomials_of_degree_five_are_exact() {
        for rows in [6, 7, 20] {
            let sum = integral(rows, 2.0, |t| t.powi(5) - t);
            assert!((sum - (64.0 / 6.0 - 2.0)).abs() < 1e-13, "{rows} rows: {sum}");
        }
        assert!((integral(3, 2.0, |t| t * t) - 8.0 / 3.0).abs() < 1e-14);
        assert!((integral(2, 2.0, |t| t) - 2.0).abs() < 1e-15);
    }

    #[test]
    fn errors_fall_with_order_six() {
        let error = |rows| (integral(rows, 3.0, f64::exp) - (3f64.exp() - 1.0)).abs();
        let ratio = error(41) / error(81);
        assert!(ratio > 40.0, "{ratio}");
    }
}
