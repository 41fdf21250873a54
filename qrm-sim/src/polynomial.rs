//! Interpolation polynomials, on numbers with or without derivatives.

use num_dual::DualNum;

/// A number with or without derivatives.
pub trait Number: DualNum<Primitive = f64> + Copy {}

impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

/// A polynomial in Newton's form.
#[derive(Clone, Debug)]
pub(crate) struct Polynomial<D> {
    times: Vec<D>,
    coefficients: Vec<D>,
}

impl<D: Number> Polynomial<D> {
    /// Creates the polynomial through points with different times.
    pub(crate) fn through(points: &[(D, D)]) -> Self {
        let times: Vec<D> = points.iter().map(|point| point.0).collect();
        let mut coefficients: Vec<D> = points.iter().map(|point| point.1).collect();
        for order in 1..points.len() {
            for i in (order..points.len()).rev() {
                coefficients[i] = (coefficients[i] - coefficients[i - 1]) / (times[i] - times[i - order]);
            }
        }
        Self { times, coefficients }
    }

    /// The value of the polynomial at time `t`.
    pub(crate) fn value(&self, t: D) -> D {
        let terms = self.coefficients.iter().zip(&self.times).rev();
        terms.fold(D::from(0.0), |value, (coefficient, time)| value * (t - *time) + *coefficient)
    }

    /// The value and the first two derivatives of the polynomial at time `t`.
    pub(crate) fn at(&self, t: D) -> [D; 3] {
        let zero = D::from(0.0);
        let [mut value, mut slope, mut curve] = [zero; 3];
        for (coefficient, time) in self.coefficients.iter().zip(&self.times).rev() {
            curve = curve * (t - *time) + slope * 2.0;
            slope = slope * (t - *time) + value;
            value = value * (t - *time) + *coefficient;
        }
        [value, slope, curve]
    }
}
