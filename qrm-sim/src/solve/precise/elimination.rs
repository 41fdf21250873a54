//! Square systems in double-double precision.

use qrm_core::Scalar;

use super::Number;
use crate::solve::Lu;
use crate::solve::nonzeros::Nonzeros;

/// The factors of a square matrix by Gaussian elimination with row exchanges.
///
/// Large systems are factored in doubles, and their solutions are improved by residuals in double-double precision
/// (iterative refinement; Wilkinson 1963), unless their condition is too large for that.
#[derive(Clone, Debug)]
pub(crate) struct Elimination {
    size: usize,
    /// The factors row by row; below the diagonal, the multiples of the rows above. The matrix itself where `doubles`
    /// are its factors.
    factors: Vec<Number>,
    /// The factors of the matrix in doubles, with rows divided by their scales.
    doubles: Option<Lu>,
    /// The nonzero entries of the matrix where `doubles` are its factors.
    nonzeros: Nonzeros,
    /// The rows in the order of their pivots.
    order: Vec<usize>,
    /// The largest entry of each row.
    scales: Vec<f64>,
}

/// The ratio of a pivot to its row below which it is a rounding error.
const SINGULAR: f64 = 1e-26;
/// Whether large systems are refined: pages hold no scenes so large.
const REFINES: bool = cfg!(feature = "extremes");
/// The size from which systems are large.
const LARGE: usize = 32;
/// The largest relative error of a solution in doubles that is refined. Each correction reduces the error by as much.
const CONTRACTION: f64 = 1e-3;
/// The largest ratio of a correction to its number that ends the refinement, and the largest number of corrections.
const CONVERGED: f64 = 1e-31;
const MOST_CORRECTIONS: usize = 12;

impl Elimination {
    /// Creates the factors of a zero matrix of this size.
    pub(crate) fn zero(size: usize) -> Self {
        let factors = vec![Number::zero(); size * size];
        Self { size, factors, doubles: None, nonzeros: Nonzeros::default(), order: Vec::new(), scales: Vec::new() }
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
        if REFINES && size >= LARGE && self.factor_in_doubles() {
            return true;
        }
        self.doubles = None;
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

    /// Factors the matrix in doubles; false if solutions could not be improved with these factors.
    fn factor_in_doubles(&mut self) -> bool {
        if self.scales.iter().any(|scale| !(*scale > 0.0 && scale.is_finite())) {
            return false;
        }
        self.nonzeros.find(self.factors.chunks_exact(self.size));
        let mut doubles = self.doubles.take().unwrap_or_else(|| Lu::with_size(self.size));
        doubles.factor_of(|i, j| match self.factors[i * self.size + j].to_f64() {
            // A division of zero would take as long as any other.
            0.0 => 0.0,
            entry => entry / self.scales[i],
        });
        // The solution for the sums of rows is known.
        let ones = vec![Number::from_f64(1.0); self.size];
        let sums: Vec<Number> = (0..self.size).map(|i| -self.residual(i, Number::zero(), &ones)).collect();
        let first: Vec<f64> = sums.iter().zip(&self.scales).map(|(sum, scale)| sum.to_f64() / scale).collect();
        let is_precise = doubles.solve(&first).iter().all(|x| (x - 1.0).abs() <= CONTRACTION);
        self.doubles = is_precise.then_some(doubles);
        is_precise
    }

    /// The residual `right - A x` in a row of the matrix.
    fn residual(&self, i: usize, right: Number, x: &[Number]) -> Number {
        let row = &self.factors[i * self.size..][..self.size];
        self.nonzeros.row(i).iter().fold(right, |rest, &j| rest - row[j] * x[j])
    }

    /// Solves for a right-hand side with the factors in doubles.
    fn refine(&self, doubles: &Lu, right: &[Number], x: &mut [Number]) {
        x.fill(Number::zero());
        let (mut rest, mut correction) = (vec![0.0; self.size], vec![0.0; self.size]);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            for (i, (rest, right)) in rest.iter_mut().zip(right).enumerate() {
                *rest = self.residual(i, *right, x).to_f64() / self.scales[i];
            }
            doubles.solve_into(&rest, &mut correction);
            let (mut change, mut is_converged) = (0.0_f64, true);
            for (x, correction) in x.iter_mut().zip(&correction) {
                change = change.max(correction.abs());
                is_converged &= correction.abs() <= CONVERGED * x.to_f64().abs();
                *x = *x + Number::from(*correction);
            }
            // Corrections of numbers that are zero end at their rounding errors.
            if is_converged || !(change < 0.5 * last) {
                break;
            }
            last = change;
        }
    }

    /// Solves for a right-hand side.
    pub(crate) fn solve(&self, right: &[Number], x: &mut [Number]) {
        if REFINES && let Some(doubles) = &self.doubles {
            return self.refine(doubles, right, x);
        }
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

    /// A Hilbert matrix plus the unit matrix, times (1, 2, ...); with two rows that are equal in doubles it is
    /// eliminated in all digits.
    #[test]
    fn solutions_of_large_systems_have_as_many_digits() {
        const SIZE: usize = LARGE + 8;
        for (difference, digits) in [(None, 1e-27), (Some(1e-20), 1e-8)] {
            let entry = |i: usize, j: usize| match difference {
                Some(difference) if i == 1 => {
                    let first = Number::from_f64((j + 1) as f64).recip() + Number::from_f64(f64::from(j == 0));
                    first + Number::from_f64(if j == 1 { difference } else { 0.0 })
                }
                _ => Number::from_f64((i + j + 1) as f64).recip() + Number::from_f64(f64::from(i == j)),
            };
            let mut system = Elimination::zero(SIZE);
            (0..SIZE * SIZE).for_each(|k| system.entries_mut()[k] = entry(k / SIZE, k % SIZE));
            assert!(system.factor() && system.doubles.is_none() == difference.is_some());
            let exact = |j: usize| Number::from_f64((j + 1) as f64);
            let right = (0..SIZE).map(|i| (0..SIZE).fold(Number::zero(), |sum, j| sum + entry(i, j) * exact(j)));
            let mut x = vec![Number::zero(); SIZE];
            system.solve(&right.collect::<Vec<_>>(), &mut x);
            for (j, x) in x.into_iter().enumerate() {
                assert!((x - exact(j)).to_f64().abs() < digits, "{j}: {x:?}");
            }
        }
    }
}
