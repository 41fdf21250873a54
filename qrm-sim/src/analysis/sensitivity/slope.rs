//! The derivatives of coordinates and rates by time, and their sums.

use qrm_core::Scalar;

use super::number::{Inner, Number};

/// Coordinates and rates, or what a step adds to them.
#[derive(Clone, Debug)]
pub(super) struct Slope<T: Inner> {
    pub(super) q: Vec<Number<T>>,
    pub(super) qd: Vec<Number<T>>,
}

impl<T: Inner> Slope<T> {
    /// The sum with other slopes, by their places and weights, times `scale`.
    pub(super) fn plus(
        mut self,
        scale: Number<T>,
        row: impl IntoIterator<Item = (usize, f64)>,
        slopes: &[Self],
    ) -> Self {
        let Self { q, qd } = &mut self;
        for (place, weight) in row {
            let weight = Number::from_f64(weight) * scale;
            let add = |(sum, x): (&mut Number<T>, &Number<T>)| *sum = *sum + weight * *x;
            q.iter_mut().zip(&slopes[place].q).for_each(add);
            qd.iter_mut().zip(&slopes[place].qd).for_each(add);
        }
        self
    }
}
