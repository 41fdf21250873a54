//! The numbers on which functions are evaluated.

use num_dual::Dual64;
use qrm_core::{DoubleDouble, Dual, Fused, Scalar};

/// A number with its value.
pub(crate) trait Number: Scalar {
    /// An argument of a function.
    fn input(value: f64) -> Self {
        Self::from_f64(value)
    }
    fn value(self) -> DoubleDouble;
}

impl Number for f64 {
    fn value(self) -> DoubleDouble {
        self.into()
    }
}

impl Number for Fused {
    fn value(self) -> DoubleDouble {
        self.0.into()
    }
}

impl Number for DoubleDouble {
    fn value(self) -> DoubleDouble {
        self
    }
}

impl Number for Dual<Dual64> {
    /// The derivative by anything must not change the value.
    fn input(value: f64) -> Self {
        Self(Dual64::new(value, 1.0))
    }
    fn value(self) -> DoubleDouble {
        self.0.re.into()
    }
}

/// A number with a derivative by one variable.
pub(crate) fn dual(value: f64, derivative: f64) -> Dual<Dual64> {
    Dual(Dual64::new(value, derivative))
}

/// The solution of `A x = b` by elimination with pivots, `A` by rows; `None` if it is nearly singular.
pub(crate) fn solve<R: Number>(mut a: Vec<Vec<R>>, b: Vec<R>) -> Option<Vec<R>> {
    let n = b.len();
    let size = |x: R| x.value().hi().abs();
    for (row, right) in a.iter_mut().zip(b) {
        // Units differ from row to row.
        let largest = row.iter().fold(R::zero(), |most, entry| if size(*entry) > size(most) { *entry } else { most });
        row.push(right);
        row.iter_mut().for_each(|entry| *entry = *entry / largest);
    }
    for k in 0..n {
        let best = (k..n).max_by(|&i, &j| size(a[i][k]).total_cmp(&size(a[j][k])))?;
        a.swap(k, best);
        if !(size(a[k][k]) > 1e-6) {
            return None;
        }
        for i in (0..n).filter(|&i| i != k) {
            let ratio = a[i][k] / a[k][k];
            for j in k..=n {
                a[i][j] = a[i][j] - ratio * a[k][j];
            }
        }
    }
    Some((0..n).map(|k| a[k][n] / a[k][k]).collect())
}
