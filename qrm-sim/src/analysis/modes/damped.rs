//! Eigenvalues with damping.

use nalgebra::{Complex, DMatrix, DVector};

use super::ROUNDING;
use super::error::NoModes;
use super::rest::RestState;
use super::undamped::{Mode, ReducedEquations};
use crate::analysis::spectrum::eigenvalues;

/// An eigenvalue of the linear equations with damping.
#[derive(Clone, Copy, Debug)]
pub struct DampedMode {
    /// The eigenvalue `s`, in 1/s; its imaginary part is not negative.
    pub value: Complex<f64>,
    /// The estimated error of its size.
    pub error: f64,
}

impl DampedMode {
    /// The damping ratio `-Re(s)/|s|`; `None` for `s = 0`.
    #[must_use]
    pub fn damping_ratio(&self) -> Option<f64> {
        let size = self.value.norm();
        (size > self.error).then(|| -self.value.re / size + 0.0)
    }
}

const MOST_ITERATIONS: usize = 10_000;
/// The largest change by Newton's method, in parts of the error near a repeated eigenvalue.
const NEAR: f64 = 1.0;

/// The eigenvalues with damping, the slowest decay first.
pub(super) fn modes(
    at: &RestState,
    reduced: &ReducedEquations,
    undamped: &[Mode],
    complex_squares: &[Complex<f64>],
    q_errors: &[f64],
) -> Result<Vec<DampedMode>, NoModes> {
    let mut found = if reduced.damping.iter().all(|entry| *entry == 0.0) {
        without_damping(reduced, undamped, complex_squares)
    } else {
        let moved = q_errors.iter().zip(&at.null_space.sizes).map(|(error, size)| error / size).fold(0.0, f64::max);
        with_damping(reduced, undamped, moved)?
    };
    let order = |mode: &DampedMode| (-mode.value.re, mode.value.im);
    found.sort_by(|a, b| order(a).0.total_cmp(&order(b).0).then(order(a).1.total_cmp(&order(b).1)));
    Ok(found)
}

/// Square roots of minus the squares of frequencies.
fn without_damping(reduced: &ReducedEquations, undamped: &[Mode], complex_squares: &[Complex<f64>]) -> Vec<DampedMode> {
    let mut found = Vec::new();
    for mode in undamped {
        let (rate, error) = mode.rate();
        if mode.square > mode.square_error {
            found.push(DampedMode { value: Complex::new(0.0, rate), error });
        } else {
            found.extend([-rate, rate].map(|rate| DampedMode { value: Complex::new(rate + 0.0, 0.0), error }));
        }
    }
    let rounding = ROUNDING * reduced.stiffness_terms.amax();
    let largest = undamped.iter().map(|mode| mode.square_error).fold(rounding, f64::max);
    for square in complex_squares {
        let root = (-square).sqrt();
        let root = if root.im < 0.0 { -root } else { root };
        let error = largest / root.norm();
        found.extend([root, -root.conj()].map(|value| DampedMode { value, error }));
    }
    found
}

/// The roots of `det(s^2 + s D + K)` in scaled coordinates, each improved by Newton's method with its own vectors.
fn with_damping(reduced: &ReducedEquations, undamped: &[Mode], moved: f64) -> Result<Vec<DampedMode>, NoModes> {
    let f = reduced.stiffness.nrows();
    let mut matrix = DMatrix::zeros(2 * f, 2 * f);
    for i in 0..f {
        matrix[(i, f + i)] = 1.0;
        for j in 0..f {
            matrix[(f + i, j)] = -reduced.stiffness[(i, j)];
            matrix[(f + i, f + j)] = -reduced.damping[(i, j)];
        }
    }
    let values = eigenvalues(matrix).ok_or(NoModes::NoEigenvalues)?;
    values.into_iter().filter(|value| value.im >= 0.0).map(|value| improved(reduced, undamped, moved, value)).collect()
}

fn improved(
    reduced: &ReducedEquations,
    undamped: &[Mode],
    moved: f64,
    mut value: Complex<f64>,
) -> Result<DampedMode, NoModes> {
    let f = reduced.stiffness.nrows();
    let complex = |matrix: &DMatrix<f64>| matrix.map(|entry| Complex::new(entry, 0.0));
    let (stiffness, damping) = (complex(&reduced.stiffness), complex(&reduced.damping));
    let identity = DMatrix::<Complex<f64>>::identity(f, f);
    let pencil = |s: Complex<f64>| &identity * (s * s) + &damping * s + &stiffness;
    let mut error = f64::INFINITY;
    for _ in 0..2 {
        let svd = pencil(value).try_svd(true, true, f64::EPSILON, MOST_ITERATIONS).ok_or(NoModes::NoEigenvalues)?;
        let (u, v_t) = svd.u.zip(svd.v_t).ok_or(NoModes::NoEigenvalues)?;
        let last = svd.singular_values.imin();
        let (right, left) = (v_t.row(last).adjoint(), u.column(last).into_owned());
        let product = |matrix: &DMatrix<Complex<f64>>| left.dotc(&(matrix * &right));
        let [sizes_left, sizes_right] = [&left, &right].map(|vector| vector.map(|entry| entry.norm()));
        let sizes = |matrix: &DMatrix<f64>| sizes_left.dot(&(matrix.abs() * &sizes_right));
        // The errors of the squares of undamped frequencies contain those of the stiffness, where all of them are
        // known.
        let of_stiffness = if reduced.is_symmetric { 0.0 } else { sizes(&reduced.stiffness_terms) };
        let of_terms = of_stiffness
            + value.norm() * sizes(&reduced.damping_terms)
            + value.norm_sqr() * sizes_left.dot(&sizes_right);
        let residual = ROUNDING * of_terms
            + residual_by_squares(reduced, undamped, [&sizes_left, &sizes_right], [&left, &right])
            + moved * value.norm() * sizes(&reduced.damping_terms);
        let slope = product(&(&identity * (value * 2.0) + &damping));
        let curvature = product(&identity).norm();
        // Near a repeated eigenvalue the error is that of a square root.
        let root = (residual / curvature).sqrt();
        error = residual / slope.norm();
        let change = product(&pencil(value)) / slope;
        // The residual of the equation, also at a repeated eigenvalue, from which Newton's method goes half of the way.
        let left_over = product(&pencil(value)).norm();
        error = error.min(root).max((2.0 * left_over / slope.norm()).min(2.0 * (left_over / curvature).sqrt()));
        if slope.norm() > 4.0 * (residual * curvature).sqrt() && change.norm() <= NEAR * (root + 1e-6 * value.norm()) {
            value -= change;
            if value.im.abs() <= f64::EPSILON * value.re.abs() {
                value.im = 0.0;
            }
        }
    }
    // Real eigenvalues stay real, and one of a pair has a positive imaginary part.
    value.im = value.im.abs();
    if !error.is_finite() {
        return Err(NoModes::NoEigenvalues);
    }
    Ok(DampedMode { value, error })
}

/// The residual by the errors of the squares of the undamped frequencies.
fn residual_by_squares(
    reduced: &ReducedEquations,
    undamped: &[Mode],
    [sizes_left, sizes_right]: [&DVector<f64>; 2],
    [left, right]: [&DVector<Complex<f64>>; 2],
) -> f64 {
    if !reduced.is_symmetric {
        let largest = undamped.iter().map(|mode| mode.square_error).fold(0.0, f64::max);
        return largest * sizes_left.norm() * sizes_right.norm();
    }
    let part = |mode: &Mode, vector: &DVector<Complex<f64>>| {
        mode.scaled[0].iter().zip(vector.iter()).map(|(entry, other)| other * *entry).sum::<Complex<f64>>().norm()
    };
    undamped.iter().map(|mode| mode.square_error * part(mode, left) * part(mode, right)).sum()
}
