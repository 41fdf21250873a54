//! The eigenvalues of the linearized, constrained equations of motion at one state, and the stable steps.

use nalgebra::linalg::{Schur, balancing};
use nalgebra::{Complex, DMatrix};
use qrm_core::Mechanism;

use crate::solve::Response;
use crate::solve::{Ldl, Matrix, SmallestSingularValue, Solver, minv_ct, schur_complement};
use crate::state::State;

/// The properties of the linearized equations at one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// The fastest decay, in 1/s: the largest `-Re(s)` of an eigenvalue `s`.
    pub rate: f64,
    /// The fastest oscillation, in rad/s: the largest `|Im(s)|`.
    pub frequency: f64,
    /// The fastest growth, in 1/s: the largest `Re(s)`.
    pub growth: f64,
    /// The longest step, in s, for which RK4 amplifies no decaying or oscillating mode; infinite if there is none.
    pub longest_step: f64,
    /// Condition number of `Mbar`, scaled to a unit diagonal; infinite if it is singular.
    pub condition_mass: f64,
    /// Condition number of `C_q Mbar^-1 C_q'`, scaled likewise; infinite if it is singular, one without constraints.
    pub condition_loops: f64,
    /// Smallest singular value of `C_q`; infinite without constraints.
    pub smallest_singular_value: f64,
}

/// Computes the spectrum at a state; `None` if the accelerations or the eigenvalues cannot be found.
pub fn spectrum(mechanism: &dyn Mechanism, t: f64, q: &[f64], qd: &[f64]) -> Option<Spectrum> {
    let (n, m) = (q.len(), mechanism.description().constraints.len());
    let mut at = State::zero(n, m);
    (at.t, at.q, at.qd) = (t, q.to_vec(), qd.to_vec());
    let mut solver = Solver::at(mechanism, t, q);
    solver.complete(mechanism, &mut at).ok()?;
    let response = Response::new(mechanism, &at);
    let mut matrix = DMatrix::zeros(2 * n, 2 * n);
    let zero = vec![0.0; n];
    for j in 0..n {
        let mut unit = zero.clone();
        unit[j] = 1.0;
        let (by_q, by_qd) = (response.accelerations(&unit, &zero)?, response.accelerations(&zero, &unit)?);
        matrix[(j, n + j)] = 1.0;
        for i in 0..n {
            (matrix[(n + i, j)], matrix[(n + i, n + j)]) = (by_q[i], by_qd[i]);
        }
    }
    let eigenvalues = eigenvalues(matrix)?;
    let most = |part: fn(&Complex<f64>) -> f64| eigenvalues.iter().map(part).fold(0.0, f64::max);
    let dynamics = &response.dynamics;
    let jacobian = &dynamics.constraint_jacobian;
    let (condition_mass, condition_loops) = match Ldl::new(&dynamics.mass_matrix) {
        Some(mass) => {
            let (mut pull, mut loops) = (Matrix::zero(m, n), Matrix::zero(m, m));
            minv_ct(&mass, jacobian, &mut pull);
            schur_complement(jacobian, &pull, &mut loops);
            (condition(&dynamics.mass_matrix, n)?, condition(&loops, solver.rank())?)
        }
        None => (f64::INFINITY, f64::INFINITY),
    };
    Some(Spectrum {
        rate: most(|s| -s.re),
        frequency: most(|s| s.im.abs()),
        growth: most(|s| s.re),
        longest_step: eigenvalues.iter().map(|s| longest_step(*s)).fold(f64::INFINITY, f64::min),
        condition_mass,
        condition_loops,
        smallest_singular_value: SmallestSingularValue::with_rank(m, n, solver.rank())
            .find(jacobian)
            .unwrap_or(f64::INFINITY),
    })
}

/// Squares of larger numbers, and products of these, overflow.
const LARGEST: f64 = 1e60;
/// Far more iterations than eigenvalues of such matrices need.
const MOST_ITERATIONS: usize = 10_000;

pub(super) fn eigenvalues(mut matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if matrix.iter().any(|entry| !(entry.abs() < LARGEST)) {
        return None;
    }
    // Coordinates and rates differ in size by the fastest rate.
    balancing::balance_parlett_reinsch(&mut matrix);
    let schur = Schur::try_new(matrix, f64::EPSILON, MOST_ITERATIONS)?;
    Some(schur.complex_eigenvalues().iter().copied().collect())
}

/// The ratio of the largest to the smallest nonzero eigenvalue of a symmetric matrix with a unit diagonal; `rank` of
/// them are nonzero.
fn condition(matrix: &Matrix, rank: usize) -> Option<f64> {
    let size = matrix.columns();
    if rank == 0 {
        return Some(1.0);
    }
    let scaled = DMatrix::from_fn(size, size, |i, j| matrix[i][j] / (matrix[i][i] * matrix[j][j]).sqrt());
    if scaled.iter().any(|entry| !entry.is_finite()) {
        return Some(f64::INFINITY);
    }
    let values = nalgebra::SymmetricEigen::try_new(scaled, f64::EPSILON, MOST_ITERATIONS)?.eigenvalues;
    let mut values: Vec<f64> = values.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    let (low, high) = (values[rank - 1], values[0]);
    Some(if low > 0.0 { high / low } else { f64::INFINITY })
}

/// Growth rates below this fraction of an eigenvalue belong to the motion, not to an oscillation.
const SLOW: f64 = 0.2;

/// The longest step for which RK4 does not amplify `x' = s x`: 2.785/rate for a decay, 2.828/omega for an oscillation,
/// in between for both.
pub fn longest_step(s: Complex<f64>) -> f64 {
    let size = s.norm();
    if size == 0.0 || s.re > SLOW * size {
        return f64::INFINITY;
    }
    let direction = Complex::new(s.re.min(0.0), s.im);
    let direction = direction / direction.norm();
    let is_stable = |length: f64| amplification(direction * length) <= 1.0 + 1e-9;
    // A ray from 0 to the edge of the stability region stays inside, in this half plane.
    let (mut low, mut high) = (0.0, 4.0);
    let mut outward = 0.0;
    while outward < high {
        outward += 0.05;
        if !is_stable(outward) {
            high = outward;
            break;
        }
        low = outward;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if is_stable(middle) { low = middle } else { high = middle }
    }
    low / size
}

/// The amplification factor of a step of RK4 for `x' = s x`: `|1 + z + z^2/2 + z^3/6 + z^4/24|`, `z = h s`.
fn amplification(z: Complex<f64>) -> f64 {
    let one = Complex::new(1.0, 0.0);
    (one + z * (one + z / 2.0 * (one + z / 3.0 * (one + z / 4.0)))).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_textbook() {
        // Hairer and Wanner IV.2: the real interval ends at 2.785, the imaginary one at sqrt(8).
        assert!((longest_step(Complex::new(-1.0, 0.0)) - 2.785_293_563).abs() < 1e-6);
        assert!((longest_step(Complex::new(0.0, -10.0)) - 0.1 * 8.0_f64.sqrt()).abs() < 1e-6);
        assert!(longest_step(Complex::new(3.0, 1.0)).is_infinite());
        // A slowly growing fast oscillation is bound like an oscillation.
        assert!((longest_step(Complex::new(0.05, 10.0)) - 0.1 * 8.0_f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn scaled_condition_numbers_do_not_depend_on_units() {
        let condition = |rows: [[f64; 2]; 2]| condition(&Matrix::from_fn(2, 2, |i, j| rows[i][j]), 2);
        assert!((condition([[1e12, 0.0], [0.0, 1e-12]]).expect("found") - 1.0).abs() < 1e-12);
        assert!((condition([[4.0, 1e-3], [1e-3, 1e-6]]).expect("found") - 3.0).abs() < 1e-9);
        assert!(condition([[1.0, 1.0], [1.0, 1.0]]).expect("found") > 1e15);
    }
}
