//! Independent coordinates at a position, and the motions that the constraints allow.

use nalgebra::linalg::LU;
use nalgebra::{DMatrix, DVector, Dyn};
use qrm_core::Description;

/// The motions that the constraints allow at a position, one for each independent coordinate.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct NullSpace {
    /// The independent coordinates, in their order.
    pub(in crate::analysis) independent: Vec<usize>,
    /// The other coordinates, as many as constraints.
    pub(in crate::analysis) dependent: Vec<usize>,
    /// `N`, `n` by `f`: its rows of independent coordinates are those of the identity.
    pub(in crate::analysis) basis: DMatrix<f64>,
    /// The size of each coordinate: one for an angle, for a length the largest one of the mechanism.
    pub(in crate::analysis) sizes: Vec<f64>,
    /// The factors of the columns of `C_q` of the dependent coordinates, and those of their transpose; `None` without
    /// constraints.
    factors: Option<[LU<f64, Dyn, Dyn>; 2]>,
}

/// The smallest pivot of constraints that are independent, with rows and columns of size one: next to a singular
/// position coordinates have half of their digits.
const INDEPENDENT: f64 = 1e-6;
/// The smallest pivot for which the preferred coordinates are a good choice.
const GOOD: f64 = 1e-2;

impl NullSpace {
    /// Chooses the preferred coordinates as the independent ones where they determine the others well, else those that
    /// do best. `None` at a singular position. `curvature` has the derivatives of the Jacobian by each coordinate, and
    /// no length is smaller than the least one.
    pub(in crate::analysis) fn new(
        description: &Description,
        q: &[f64],
        (jacobian, curvature): (&DMatrix<f64>, &[DMatrix<f64>]),
        (preferred, least_length): (&[bool], f64),
    ) -> Option<Self> {
        let (m, n) = jacobian.shape();
        let length = length(description, q, |k, i| jacobian[(k, i)]).max(least_length);
        let sizes: Vec<f64> = (0..n).map(|i| if description.is_angle(i) { 1.0 } else { length }).collect();
        let mut scaled = DMatrix::from_fn(m, n, |k, i| jacobian[(k, i)] * sizes[i]);
        for (k, mut row) in scaled.row_iter_mut().enumerate() {
            // A gradient is small if it is so against its change in a radian.
            let changes = curvature.iter().zip(&sizes).flat_map(|(curvature, size)| {
                curvature
                    .row(k)
                    .iter()
                    .zip(&sizes)
                    .map(move |(entry, own)| (entry * size * own).abs())
                    .collect::<Vec<_>>()
            });
            let largest = changes.fold(row.amax(), f64::max);
            if !(largest > 0.0 && largest.is_finite()) {
                return None;
            }
            row /= largest;
        }
        let count = preferred.iter().filter(|is| **is).count();
        let own = (count + m == n).then(|| pivots(scaled.clone(), preferred)).flatten();
        let dependent = match own.filter(|(_, smallest)| *smallest > GOOD) {
            Some((dependent, _)) => dependent,
            None => pivots(scaled, &vec![false; n]).filter(|(_, smallest)| *smallest > INDEPENDENT)?.0,
        };
        let independent: Vec<usize> = (0..n).filter(|i| !dependent.contains(i)).collect();
        let factors = (m > 0).then(|| {
            let block = jacobian.select_columns(&dependent);
            [block.clone().lu(), block.transpose().lu()]
        });
        let mut basis = DMatrix::zeros(n, independent.len());
        for (column, &i) in independent.iter().enumerate() {
            basis[(i, column)] = 1.0;
            if let Some([factors, _]) = &factors {
                let own = factors.solve(&jacobian.column(i).into_owned())?;
                dependent.iter().zip(own.iter()).for_each(|(&row, value)| basis[(row, column)] = -value);
            }
        }
        Some(Self { independent, dependent, basis, sizes, factors })
    }

    /// The number of degrees of freedom.
    pub(in crate::analysis) fn freedom(&self) -> usize {
        self.independent.len()
    }

    /// Whether each coordinate is independent.
    pub(in crate::analysis) fn is_independent(&self) -> Vec<bool> {
        (0..self.sizes.len()).map(|i| self.independent.contains(&i)).collect()
    }

    /// The `x` with `C_q x = right` whose independent part is zero.
    pub(in crate::analysis) fn particular(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut x = DVector::zeros(self.sizes.len());
        if let Some(own) = self.factors.as_ref().and_then(|[factors, _]| factors.solve(right)) {
            self.dependent.iter().zip(own.iter()).for_each(|(&i, value)| x[i] = *value);
        }
        x
    }

    /// The multipliers `lambda` with `C_q' lambda = right` in the dependent coordinates.
    pub(in crate::analysis) fn multipliers(&self, right: &DVector<f64>) -> DVector<f64> {
        let own = DVector::from_fn(self.dependent.len(), |row, _| right[self.dependent[row]]);
        let solved = self.factors.as_ref().and_then(|[_, transposed]| transposed.solve(&own));
        solved.unwrap_or_else(|| DVector::zeros(self.dependent.len()))
    }

    /// `N' x N` of a matrix `n` by `n`.
    pub(in crate::analysis) fn reduced(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        self.basis.transpose() * matrix * &self.basis
    }
}

/// The dependent coordinates by Gaussian elimination with full pivoting, without those left out, and the smallest
/// pivot.
fn pivots(mut matrix: DMatrix<f64>, left_out: &[bool]) -> Option<(Vec<usize>, f64)> {
    let (m, n) = matrix.shape();
    let mut open: Vec<usize> = (0..n).filter(|&i| !left_out[i]).collect();
    let (mut dependent, mut smallest) = (Vec::new(), f64::INFINITY);
    for step in 0..m {
        let places = (step..m).flat_map(|row| open.iter().map(move |&column| (row, column)));
        let size = |&(row, column): &(usize, usize)| matrix[(row, column)].abs();
        let (row, column) = places.max_by(|a, b| size(a).total_cmp(&size(b)))?;
        smallest = smallest.min(matrix[(row, column)].abs());
        if !(smallest > 0.0) {
            return None;
        }
        matrix.swap_rows(step, row);
        for other in step + 1..m {
            let factor = matrix[(other, column)] / matrix[(step, column)];
            for &i in &open {
                matrix[(other, i)] -= factor * matrix[(step, i)];
            }
        }
        open.retain(|&i| i != column);
        dependent.push(column);
    }
    dependent.sort_unstable();
    Some((dependent, smallest))
}

/// The largest length among coordinates and lever arms of angles; zero without one.
pub(super) fn length(description: &Description, q: &[f64], jacobian: impl Fn(usize, usize) -> f64) -> f64 {
    let mut length = 0.0_f64;
    for i in 0..q.len() {
        if !description.is_angle(i) {
            length = length.max(q[i].abs());
            continue;
        }
        for k in (0..description.constraints.len()).filter(|&k| description.constraints[k].unit != "rad") {
            length = length.max(jacobian(k, i).abs());
        }
    }
    length
}
