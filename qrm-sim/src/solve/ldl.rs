//! Symmetric systems: a fast factorization that reports a vanishing pivot, and a robust one that continues past it.

use super::matrix::{Matrix, dot};

/// The threshold of suspicious numbers in matrices of products: pivots relative to their diagonal entry, and diagonal
/// entries relative to the largest one.
pub(super) const SUSPICIOUS: f64 = 1e-7;

/// The factors of a positive definite matrix, `A = L D L'`.
///
/// Leading zeros of a row of `A` are leading zeros of that row of `L` too (the envelope of the matrix): they are
/// skipped.
#[derive(Clone, Debug)]
pub struct Ldl {
    l: Matrix,
    /// The index of the first nonzero entry in each row.
    first: Vec<usize>,
    inverse_d: Vec<f64>,
    /// The current row, times the pivots.
    scaled: Vec<f64>,
}

impl Ldl {
    /// Creates buffers for the factors of a matrix of this size.
    pub fn with_size(size: usize) -> Self {
        Self { l: Matrix::zero(size, size), first: vec![0; size], inverse_d: vec![0.0; size], scaled: vec![0.0; size] }
    }

    /// The factors of `a`; `None` if a pivot is a rounding error of its diagonal entry.
    pub fn new(a: &Matrix) -> Option<Self> {
        let mut factors = Self::with_size(a.columns());
        factors.factor(a).then_some(factors)
    }

    /// Factors `a`, whose lower triangle is read; false if a pivot is a rounding error of its diagonal entry.
    pub fn factor(&mut self, a: &Matrix) -> bool {
        self.factor_above(a, 8.0 * a.columns() as f64 * f64::EPSILON)
    }

    /// Factors a matrix of products, `C_q Mbar^-1 C_q'`; false as soon as a pivot or a diagonal entry becomes
    /// suspicious. Such a number is the square of a singular value below three ten-thousandths of the usual size.
    pub fn factor_products(&mut self, a: &Matrix) -> bool {
        self.factor_products_above(a, SUSPICIOUS)
    }

    /// Factors a matrix of products; false as soon as a pivot is below the fraction `smallest` of its diagonal entry,
    /// or a diagonal entry below that fraction of the largest one.
    pub(super) fn factor_products_above(&mut self, a: &Matrix, smallest: f64) -> bool {
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for i in 0..a.columns() {
            (least, most) = (least.min(a[i][i]), most.max(a[i][i]));
        }
        least > smallest * most && self.factor_above(a, smallest)
    }

    /// Factors with pivots above the fraction `smallest` of their diagonal entries.
    fn factor_above(&mut self, a: &Matrix, smallest: f64) -> bool {
        let n = a.columns();
        let Self { l, first, inverse_d, scaled } = self;
        l.copy_from(a);
        for (i, first) in first.iter_mut().enumerate() {
            *first = leading_zeros(&l[i][..i]);
        }
        let l = l.entries_mut();
        let mut is_definite = true;
        for j in 0..n {
            let (above, below) = l.split_at_mut((j + 1) * n);
            let (row, begin) = (&mut above[j * n..], first[j]);
            let diagonal = row[j];
            let mut pivot = diagonal;
            for ((entry, scaled), inverse) in
                row[begin..j].iter_mut().zip(&mut scaled[begin..]).zip(&inverse_d[begin..])
            {
                *scaled = *entry;
                *entry *= inverse;
                pivot -= *scaled * *entry;
            }
            // Written so that a pivot that is not a number fails too.
            is_definite &= pivot > smallest * diagonal;
            inverse_d[j] = 1.0 / pivot;
            for (other, own) in below.chunks_exact_mut(n).zip(&first[j + 1..]) {
                let begin = begin.max(*own).min(j);
                let (before, rest) = other.split_at_mut(j);
                let products = before[begin..].iter().zip(&row[begin..]);
                rest[0] = products.fold(rest[0], |sum, (entry, of_row)| sum - entry * of_row);
            }
        }
        is_definite
    }

    /// Solves `A x = b` in place.
    pub fn solve(&self, x: &mut [f64]) {
        let (n, start) = (x.len().max(1), leading_zeros(x));
        let rows = || self.l.entries().chunks_exact(n).zip(&self.first).enumerate();
        for (i, (row, first)) in rows().skip(start) {
            let (before, rest) = x.split_at_mut(i);
            let begin = start.max(*first).min(i);
            let products = row[begin..].iter().zip(&before[begin..]);
            rest[0] = products.fold(rest[0], |sum, (entry, x)| sum - entry * *x);
        }
        for (x, inverse) in x.iter_mut().zip(&self.inverse_d) {
            *x *= inverse;
        }
        for (i, (row, first)) in rows().rev() {
            let (before, rest) = x.split_at_mut(i);
            for (x, entry) in before[*first..].iter_mut().zip(&row[*first..]) {
                *x -= entry * rest[0];
            }
        }
    }

    /// Solves `A x = b` in place for each row `b` of a matrix, with the same rounding as [`solve`](Self::solve).
    pub(super) fn solve_rows(&self, matrix: &mut Matrix) {
        let (count, n) = (matrix.rows(), matrix.columns());
        if count < SOLVES_PER_BLOCK {
            (0..count).for_each(|row| self.solve(&mut matrix[row]));
            return;
        }
        let mut block = vec![[0.0; SOLVES_PER_BLOCK]; n];
        for from in (0..count).step_by(SOLVES_PER_BLOCK) {
            let rows = from..count.min(from + SOLVES_PER_BLOCK);
            for (i, values) in block.iter_mut().enumerate() {
                *values = [0.0; SOLVES_PER_BLOCK];
                rows.clone().zip(&mut *values).for_each(|(row, value)| *value = matrix[row][i]);
            }
            self.solve_block(&mut block);
            for (i, values) in block.iter().enumerate() {
                rows.clone().zip(values).for_each(|(row, value)| matrix[row][i] = *value);
            }
        }
    }

    fn solve_block(&self, x: &mut [[f64; SOLVES_PER_BLOCK]]) {
        let n = x.len().max(1);
        let start = x.iter().position(|values| values.iter().any(|value| *value != 0.0)).unwrap_or(x.len());
        let rows = || self.l.entries().chunks_exact(n).zip(&self.first).enumerate();
        for (i, (row, first)) in rows().skip(start) {
            let (before, rest) = x.split_at_mut(i);
            let begin = start.max(*first).min(i);
            for (entry, values) in row[begin..].iter().zip(&before[begin..]) {
                (0..SOLVES_PER_BLOCK).for_each(|k| rest[0][k] -= entry * values[k]);
            }
        }
        for (values, inverse) in x.iter_mut().zip(&self.inverse_d) {
            values.iter_mut().for_each(|value| *value *= inverse);
        }
        for (i, (row, first)) in rows().rev() {
            let (before, rest) = x.split_at_mut(i);
            for (values, entry) in before[*first..].iter_mut().zip(&row[*first..]) {
                (0..SOLVES_PER_BLOCK).for_each(|k| values[k] -= entry * rest[0][k]);
            }
        }
    }
}

/// The number of right-hand sides solved simultaneously, which hides the latency of the sums.
const SOLVES_PER_BLOCK: usize = 8;

/// The number of leading zeros of a row.
fn leading_zeros(row: &[f64]) -> usize {
    row.iter().position(|entry| *entry != 0.0).unwrap_or(row.len())
}

/// The factors of a positive semidefinite matrix, scaled to a unit diagonal, largest pivots first:
/// `P S A S P' = L D L'`, truncated where the remaining pivots vanish.
#[derive(Clone, Debug)]
pub struct PivotedLdl {
    order: Vec<usize>,
    scale: Vec<f64>,
    l: Matrix,
    d: Vec<f64>,
    /// The number of pivots above rounding errors.
    pub rank: usize,
}

impl PivotedLdl {
    /// The fraction of their diagonal entry up to which pivots count as zero: squares of singular values that are a
    /// millionth of the usual size.
    const CUTOFF: f64 = 1e-12;
    /// The fraction of the largest diagonal entry up to which others consist of rounding errors: squares of nearly
    /// vanishing rows.
    const ROUNDING_FLOOR: f64 = 1e-20;

    /// Factors `a`.
    pub fn new(a: &Matrix) -> Self {
        Self::with_rank(a, a.columns())
    }

    /// Factors `a` with at most `rank` pivots; further pivots count as zero.
    pub fn with_rank(a: &Matrix, rank: usize) -> Self {
        Self::above(a, rank, [Self::CUTOFF, Self::ROUNDING_FLOOR])
    }

    /// Factors `a` with at most `rank` pivots, none of them suspicious.
    pub(super) fn without_suspicious_pivots(a: &Matrix, rank: usize) -> Self {
        Self::above(a, rank, [SUSPICIOUS; 2])
    }

    /// Factors `a` with pivots above the fraction `cutoff` of their diagonal entry; diagonal entries must exceed the
    /// fraction `floor` of the largest.
    fn above(a: &Matrix, rank: usize, [cutoff, floor]: [f64; 2]) -> Self {
        let n = a.columns();
        let largest = (0..n).fold(0.0, |largest: f64, i| largest.max(a[i][i]));
        let scale: Vec<f64> = (0..n)
            .map(|i| {
                let is_rounding = !(a[i][i] > floor * largest);
                if is_rounding { 0.0 } else { a[i][i].sqrt().recip() }
            })
            .collect();
        let mut a = Matrix::from_fn(n, n, |i, j| scale[i] * a[i][j] * scale[j]);
        let mut factors = Self { order: (0..n).collect(), scale, l: Matrix::zero(n, n), d: vec![0.0; n], rank: 0 };
        for j in 0..rank {
            let Some(best) = (j..n).max_by(|&x, &y| a[x][x].total_cmp(&a[y][y])) else { break };
            a.swap_rows(j, best);
            a.swap_columns(j, best);
            factors.order.swap(j, best);
            factors.l.swap_rows(j, best);
            let pivot = a[j][j];
            if !(pivot > cutoff) {
                break;
            }
            factors.d[j] = pivot;
            factors.l[j][j] = 1.0;
            factors.rank += 1;
            for i in j + 1..n {
                factors.l[i][j] = a[i][j] / pivot;
            }
            let touched: Vec<usize> = (j + 1..n).filter(|&i| factors.l[i][j] != 0.0).collect();
            for &i in &touched {
                for &k in &touched {
                    a[i][k] -= factors.l[i][j] * pivot * factors.l[k][j];
                }
            }
        }
        factors
    }

    /// Solves `A x = b` for a `b` in the range of `A`, in place: the solution of least norm.
    pub fn solve(&self, b: &mut [f64]) {
        // D L' P' S^-1 x
        let mut y: Vec<f64> = self.order[..self.rank].iter().map(|&i| self.scale[i] * b[i]).collect();
        for i in 0..self.rank {
            for k in 0..i {
                y[i] -= self.l[i][k] * y[k];
            }
        }
        if 0 < self.rank && self.rank < self.order.len() && self.solve_least_norm(&y, b) {
            return;
        }
        for i in (0..self.rank).rev() {
            y[i] /= self.d[i];
            for k in i + 1..self.rank {
                y[i] -= self.l[k][i] * y[k];
            }
        }
        b.fill(0.0);
        for (&i, y) in self.order.iter().zip(y) {
            b[i] = self.scale[i] * y;
        }
    }

    /// Computes the solution of least norm, `x = G (G'G)^-1 c` with `A = G G'` and `b = G c`. If rounding errors make
    /// `G'G` singular, returns false and writes nothing.
    fn solve_least_norm(&self, y: &[f64], x: &mut [f64]) -> bool {
        let mut g = Matrix::zero(x.len(), self.rank);
        for (row, &place) in self.order.iter().enumerate() {
            if self.scale[place] > 0.0 {
                (0..self.rank).for_each(|k| g[place][k] = self.l[row][k] * self.d[k].sqrt() / self.scale[place]);
            }
        }
        let products = Matrix::from_fn(self.rank, self.rank, |i, j| g.iter().map(|row| row[i] * row[j]).sum());
        let Some(products) = Ldl::new(&products) else { return false };
        let mut c: Vec<f64> = y.iter().zip(&self.d).map(|(y, d)| y / d.sqrt()).collect();
        products.solve(&mut c);
        for (x, row) in x.iter_mut().zip(g.iter()) {
            *x = dot(row, &c);
        }
        true
    }

    /// The unknowns that have a pivot.
    pub fn independent(&self) -> &[usize] {
        &self.order[..self.rank]
    }

    /// The unknowns without a pivot: they depend on others, or on nothing.
    pub fn dependent(&self) -> &[usize] {
        &self.order[self.rank..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn a() -> Matrix {
        let rows = [[4.0, 1.0, -2.0], [1.0, 3.0, 0.5], [-2.0, 0.5, 5.0]];
        Matrix::from_fn(3, 3, |i, j| rows[i][j])
    }

    fn multiply(a: &Matrix, x: &[f64]) -> Vec<f64> {
        a.iter().map(|row| dot(row, x)).collect()
    }

    #[test]
    fn factors_solve() {
        let x = [1.0, -2.0, 3.0];
        let b = multiply(&a(), &x);
        let (mut fast, mut robust) = (b.clone(), b);
        Ldl::new(&a()).expect("definite").solve(&mut fast);
        PivotedLdl::new(&a()).solve(&mut robust);
        for solved in [fast, robust] {
            assert!(solved.iter().zip(x).all(|(s, x)| (s - x).abs() < 1e-14), "{solved:?}");
        }
    }

    #[test]
    fn a_dependent_row_is_reported_and_passed() {
        let rows = [[1.0, 2.0], [3.0, -1.0], [4.0, 1.0]];
        let a = Matrix::from_fn(3, 3, |i, j| dot(&rows[i], &rows[j]));
        assert!(Ldl::new(&a).is_none());
        let factors = PivotedLdl::new(&a);
        assert_eq!((factors.rank, factors.dependent().len()), (2, 1));
        let b = multiply(&a, &[0.5, 1.0, -2.0]);
        let mut x = b.clone();
        factors.solve(&mut x);
        let residual = multiply(&a, &x);
        assert!(residual.iter().zip(b).all(|(r, b)| (r - b).abs() < 1e-13));
        // The first two rows add up to the third: the solution of least norm has no part along [1, 1, -1].
        assert!((x[0] + x[1] - x[2]).abs() < 1e-14, "{x:?}");
        assert_eq!(PivotedLdl::with_rank(&a, 1).rank, 1);
    }

    #[test]
    fn zero_and_nan_are_not_definite() {
        assert!(Ldl::new(&Matrix::zero(1, 1)).is_none());
        assert!(Ldl::new(&Matrix::from_fn(1, 1, |_, _| f64::NAN)).is_none());
        assert_eq!(PivotedLdl::new(&Matrix::zero(2, 2)).rank, 0);
    }
}
