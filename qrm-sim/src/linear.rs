//! Small symmetric systems: a fast factorisation that notices when it would fail, and a slower one that does not fail.
//!
//! Sizes are known when the mechanism is compiled, so the loops unroll and nothing is allocated.

pub mod lu;
pub mod singular;

/// A vector.
pub type Vector<const N: usize> = [f64; N];
/// A matrix, as rows.
pub type Matrix<const R: usize, const C: usize> = [[f64; C]; R];

/// Pivots of products below this part of their diagonal entry, and entries below this part of the largest one, are suspicious.
const SUSPICIOUS: f64 = 1e-9;

/// The factors of a positive definite matrix, `A = L D L'`.
#[derive(Clone, Copy, Debug)]
pub struct Ldl<const N: usize> {
    l: Matrix<N, N>,
    inverse_d: Vector<N>,
}

impl<const N: usize> Ldl<N> {
    /// Factors `a`, of which the lower triangle is read; `None` if a pivot is a rounding error of its diagonal entry.
    #[inline(always)]
    pub fn new(a: &Matrix<N, N>) -> Option<Self> {
        Self::with_pivots(a, 8.0 * N as f64 * f64::EPSILON)
    }

    /// The same for a matrix made of products, `C_q Mbar^-1 C_q'`; `None` as soon as a pivot or a diagonal entry becomes
    /// suspicious: the square of a singular value that is a hundred-thousandth of what others are.
    #[inline(always)]
    pub fn of_products(a: &Matrix<N, N>) -> Option<Self> {
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for i in 0..N {
            (least, most) = (least.min(a[i][i]), most.max(a[i][i]));
        }
        if least > SUSPICIOUS * most { Self::with_pivots(a, SUSPICIOUS) } else { None }
    }

    /// Factors with pivots above this part of their diagonal entries.
    #[inline(always)]
    fn with_pivots(a: &Matrix<N, N>, smallest: f64) -> Option<Self> {
        let mut l = *a;
        let mut inverse_d = [0.0; N];
        let mut is_definite = true;
        for j in 0..N {
            let mut pivot = a[j][j];
            let mut scaled = [0.0; N];
            for k in 0..j {
                scaled[k] = l[j][k];
                l[j][k] *= inverse_d[k];
                pivot -= scaled[k] * l[j][k];
            }
            // Written so that a pivot that is not a number fails too.
            is_definite &= pivot > smallest * a[j][j];
            inverse_d[j] = 1.0 / pivot;
            for i in j + 1..N {
                for k in 0..j {
                    l[i][j] -= l[i][k] * l[j][k];
                }
            }
        }
        is_definite.then_some(Self { l, inverse_d })
    }

    /// Solves `A x = b`.
    #[inline(always)]
    pub fn solve(&self, b: &Vector<N>) -> Vector<N> {
        let mut x = *b;
        for i in 0..N {
            for k in 0..i {
                x[i] -= self.l[i][k] * x[k];
            }
        }
        for i in 0..N {
            x[i] *= self.inverse_d[i];
        }
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] -= self.l[k][i] * x[k];
            }
        }
        x
    }
}

/// The factors of a positive semidefinite matrix, scaled to ones in its diagonal, with its largest pivots first:
/// `P S A S P' = L D L'`, cut off where the remaining pivots are next to nothing.
#[derive(Clone, Copy, Debug)]
pub struct PivotedLdl<const N: usize> {
    order: [usize; N],
    scale: Vector<N>,
    l: Matrix<N, N>,
    d: Vector<N>,
    /// How many pivots are larger than rounding errors.
    pub rank: usize,
}

impl<const N: usize> PivotedLdl<N> {
    /// Pivots up to this part of their diagonal entry count as zero: squares of singular values that are a millionth of what
    /// they usually are.
    const CUTOFF: f64 = 1e-12;
    /// Diagonal entries up to this part of the largest one are made of rounding errors: squares of rows that all but vanish.
    const NOTHING: f64 = 1e-20;

    /// Factors `a`.
    pub fn new(a: &Matrix<N, N>) -> Self {
        let largest = (0..N).fold(0.0, |largest: f64, i| largest.max(a[i][i]));
        let scale: Vector<N> = std::array::from_fn(|i| {
            let is_nothing = !(a[i][i] > Self::NOTHING * largest);
            if is_nothing { 0.0 } else { a[i][i].sqrt().recip() }
        });
        let mut a: Matrix<N, N> = std::array::from_fn(|i| std::array::from_fn(|j| scale[i] * a[i][j] * scale[j]));
        let mut factors = Self { order: std::array::from_fn(|i| i), scale, l: [[0.0; N]; N], d: [0.0; N], rank: 0 };
        for j in 0..N {
            let Some(best) = (j..N).max_by(|&x, &y| a[x][x].total_cmp(&a[y][y])) else { break };
            a.swap(j, best);
            a.iter_mut().for_each(|row| row.swap(j, best));
            factors.order.swap(j, best);
            factors.l.swap(j, best);
            let pivot = a[j][j];
            if !(pivot > Self::CUTOFF) {
                break;
            }
            factors.d[j] = pivot;
            factors.l[j][j] = 1.0;
            factors.rank += 1;
            for i in j + 1..N {
                factors.l[i][j] = a[i][j] / pivot;
            }
            for i in j + 1..N {
                for k in j + 1..N {
                    a[i][k] -= factors.l[i][j] * pivot * factors.l[k][j];
                }
            }
        }
        factors
    }

    /// Solves `A x = b` for a `b` in the range of `A`; unknowns without a pivot are zero.
    pub fn solve(&self, b: &Vector<N>) -> Vector<N> {
        let scaled = |i: usize| self.scale[self.order[i]] * b[self.order[i]];
        let mut y: Vector<N> = std::array::from_fn(|i| if i < self.rank { scaled(i) } else { 0.0 });
        for i in 0..self.rank {
            for k in 0..i {
                y[i] -= self.l[i][k] * y[k];
            }
        }
        for i in (0..self.rank).rev() {
            y[i] /= self.d[i];
            for k in i + 1..self.rank {
                y[i] -= self.l[k][i] * y[k];
            }
        }
        let mut x = [0.0; N];
        for i in 0..self.rank {
            x[self.order[i]] = self.scale[self.order[i]] * y[i];
        }
        x
    }

    /// The unknowns that have no pivot: they depend on others, or on nothing.
    pub fn dependent(&self) -> &[usize] {
        &self.order[self.rank..]
    }
}

/// `A x`
#[inline(always)]
pub fn multiply<const R: usize, const C: usize>(a: &Matrix<R, C>, x: &Vector<C>) -> Vector<R> {
    std::array::from_fn(|i| dot(&a[i], x))
}

/// `x . y`
#[inline(always)]
pub fn dot<const N: usize>(x: &Vector<N>, y: &Vector<N>) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += x[i] * y[i];
    }
    sum
}

/// `x + h v`
#[inline(always)]
pub(crate) fn along<const N: usize>(x: &Vector<N>, h: f64, v: &Vector<N>) -> Vector<N> {
    std::array::from_fn(|i| x[i] + h * v[i])
}

/// The largest absolute value, and where it is; not a number if any entry is not.
pub fn largest<const N: usize>(x: &Vector<N>) -> (usize, f64) {
    let mut found = (0, 0.0);
    for (i, value) in x.iter().enumerate() {
        if !(value.abs() <= found.1) {
            found = (i, value.abs());
        }
        if found.1.is_nan() {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Matrix<3, 3> = [[4.0, 1.0, -2.0], [1.0, 3.0, 0.5], [-2.0, 0.5, 5.0]];

    #[test]
    fn factors_solve() {
        let x = [1.0, -2.0, 3.0];
        let b = multiply(&A, &x);
        for solved in [Ldl::new(&A).expect("definite").solve(&b), PivotedLdl::new(&A).solve(&b)] {
            for (s, x) in solved.iter().zip(x) {
                assert!((s - x).abs() < 1e-14, "{solved:?}");
            }
        }
    }

    #[test]
    fn a_dependent_row_is_noticed_and_survived() {
        let rows: Matrix<3, 2> = [[1.0, 2.0], [3.0, -1.0], [4.0, 1.0]];
        let a: Matrix<3, 3> = std::array::from_fn(|i| std::array::from_fn(|j| dot(&rows[i], &rows[j])));
        assert!(Ldl::new(&a).is_none());
        let factors = PivotedLdl::new(&a);
        assert_eq!(factors.rank, 2);
        assert_eq!(factors.dependent().len(), 1);
        let b = multiply(&a, &[0.5, 1.0, -2.0]);
        let residual = multiply(&a, &factors.solve(&b));
        for (r, b) in residual.iter().zip(b) {
            assert!((r - b).abs() < 1e-13);
        }
    }

    #[test]
    fn nothing_and_nan_are_not_definite() {
        assert!(Ldl::new(&[[0.0]]).is_none());
        assert!(Ldl::new(&[[f64::NAN]]).is_none());
        assert_eq!(PivotedLdl::new(&[[0.0, 0.0], [0.0, 0.0]]).rank, 0);
        assert!(largest(&[1.0, f64::NAN, 2.0]).1.is_nan());
    }
}
