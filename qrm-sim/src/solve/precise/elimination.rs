//! Square systems in double-double precision.

use qrm_core::Scalar;

use super::Number;

/// The factors of a square matrix by Gaussian elimination with row exchanges.
#[derive(Clone, Debug)]
pub(crate) struct Elimination {
    size: usize,
    /// The factors row by row; below the diagonal, the multiples of the rows above.
    factors: Vec<Number>,
    /// The rows in the order of their pivots.
    order: Vec<usize>,
    /// The largest entry of each row.
    scales: Vec<f64>,
}

/// The ratio of a pivot to its row below which it is a rounding error.
const SINGULAR: f64 = 1e-26;

impl Elimination {
    /// Creates the factors of a zero matrix of this size.
    pub(crate) fn zero(size: usize) -> Self {
        Self { size, factors: vec![Number::zero(); size * size], order: Vec::new(), scales: Vec::new() }
    }

    /// The entries, to be set before [`factor`](Self::factor).
    pub(crate) fn entries_mut(&mut self) -> &mut [Number] {
        &mut self.factors
    }

    /// Factors the matrix in place; false if it is singular or not finite.
    #[must_use]
    pub(crate) fn factor(&mut self) -> bool {
        let size = self.size;
        if size == 0 {
            return true;
        }
        self.order.clear();
        self.order.extend(0..size);
        let largest = |row: &[Number]| row.iter().map(|entry| entry.to_f64().abs()).fold(0.0, f64::max);
        self.scales.clear();
        self.scales.extend(self.factors.chunks_exact(size).map(largest));
        for k in 0..size {
            let share = |i: usize| self.factors[i * size + k].to_f64().abs() / self.scales[i];
            let pivot = (k..size).max_by(|&a, &b| share(a).total_cmp(&share(b))).unwrap_or(k);
            if !(share(pivot) > SINGULAR && share(pivot).is_finite()) {
                return false;
            }
            if pivot != k {
                (0..size).for_each(|j| self.factors.swap(pivot * size + j, k * size + j));
                self.order.swap(pivot, k);
                self.scales.swap(pivot, k);
            }
            let (above, below) = self.factors.split_at_mut((k + 1) * size);
            let pivot_row = &above[k * size..];
            let inverse = pivot_row[k].recip();
            for row in below.chunks_exact_mut(size) {
                row[k] = row[k] * inverse;
                let multiple = row[k];
                if multiple != Number::zero() {
                    for (entry, other) in row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]) {
                        *entry = *entry - multiple * *other;
                    }
                }
            }
        }
        true
    }

    /// Solves for a right-hand side.
    pub(crate) fn solve(&self, right: &[Number], x: &mut [Number]) {
        for (i, &place) in self.order.iter().enumerate() {
            let row = &self.factors[i * self.size..][..i];
            x[i] = row.iter().zip(&*x).fold(right[place], |rest, (entry, x)| rest - *entry * *x);
        }
        for i in (0..self.order.len()).rev() {
            let row = &self.factors[i * self.size..][..self.size];
            let rest = row[i + 1..].iter().zip(&x[i + 1..]).fold(x[i], |rest, (entry, x)| rest - *entry * *x);
            x[i] = rest / row[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(entries: [f64; 9]) -> Elimination {
        let mut system = Elimination::zero(3);
        system.entries_mut().iter_mut().zip(entries).for_each(|(entry, value)| *entry = value.into());
        system
    }

    /// A Hilbert matrix times (1, 2, 3): thirds need all digits.
    #[test]
    fn solutions_have_thirty_digits() {
        let mut system = system([0.0; 9]);
        let hilbert = |i: usize, j: usize| Number::from_f64((i + j + 1) as f64).recip();
        (0..9).for_each(|k| system.entries_mut()[k] = hilbert(k / 3, k % 3));
        assert!(system.factor());
        let product = |i| (0..3).fold(Number::zero(), |sum, j| sum + hilbert(i, j) * Number::from_f64((j + 1) as f64));
        let mut x = [Number::zero(); 3];
        system.solve(&[product(0), product(1), product(2)], &mut x);
        for (i, x) in x.into_iter().enumerate() {
            assert!((x - Number::from_f64((i + 1) as f64)).to_f64().abs() < 1e-28, "{x:?}");
        }
    }

    #[test]
    fn singular_systems_are_told() {
        assert!(!system([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]).factor());
        assert!(!system([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 7.0, 8.0, 0.0]).factor());
        assert!(!system([1.0, 2.0, 3.0, f64::NAN, 5.0, 6.0, 7.0, 8.0, 0.0]).factor());
        assert!(system([0.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 0.0]).factor());
    }
}
