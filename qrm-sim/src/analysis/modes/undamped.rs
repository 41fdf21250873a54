//! Natural frequencies without damping, and their derivatives by parameters.

use nalgebra::{Cholesky, Complex, DMatrix, DVector, SymmetricEigen};

use super::error::NoModes;
use super::rest::{ByParameters, Gradient, PencilVector, RestEquations, RestState};
use super::{ROUNDING, Rounding};
use crate::analysis::spectrum::eigenvalues;

/// A mode without damping.
#[derive(Clone, Debug)]
pub struct Mode {
    /// The square of the frequency, in 1/s^2; below zero, minus that of a rate of growth.
    pub square: f64,
    /// Its estimated error.
    pub square_error: f64,
    /// The mode shape in all coordinates. The largest entry is one, with lengths in units of the largest length of the
    /// mechanism where it has angles too.
    pub shape: Vec<f64>,
    /// The derivatives of the frequency, or of the rate of growth, by all parameters, the move of the equilibrium
    /// included. `None` for a free motion and for one of several modes with the same frequency.
    pub by_parameters: Option<Vec<f64>>,
    /// The shape in scaled coordinates, and that of the left solution.
    pub(super) scaled: [DVector<f64>; 2],
}

/// The kind of motion of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeKind {
    /// It oscillates.
    Oscillation,
    /// It moves freely: the square of its frequency is zero within its error.
    Free,
    /// It grows without oscillation.
    Growth,
}

impl Mode {
    /// The kind of motion of the mode.
    #[must_use]
    pub fn kind(&self) -> ModeKind {
        if self.square > self.square_error {
            ModeKind::Oscillation
        } else if self.square < -self.square_error {
            ModeKind::Growth
        } else {
            ModeKind::Free
        }
    }

    /// The frequency in rad/s, or the rate of growth in 1/s, and its error; zero for a free motion.
    #[must_use]
    pub fn rate(&self) -> (f64, f64) {
        let rate = self.square.abs().sqrt();
        match self.kind() {
            ModeKind::Free => (0.0, (self.square.abs() + self.square_error).sqrt()),
            _ => (rate, 0.5 * self.square_error / rate),
        }
    }
}

/// Stiffness and damping in independent coordinates whose mass matrix is the identity.
pub(super) struct ReducedEquations {
    pub(super) stiffness: DMatrix<f64>,
    pub(super) stiffness_terms: DMatrix<f64>,
    pub(super) damping: DMatrix<f64>,
    pub(super) damping_terms: DMatrix<f64>,
    /// The change of the independent coordinates for forces on them; zero along free motions.
    pub(super) compliance: DMatrix<f64>,
    /// The matrix that makes independent coordinates of scaled ones.
    pub(super) scale: DMatrix<f64>,
    /// Whether the loads have a potential, up to rounding errors.
    pub(super) is_symmetric: bool,
    /// Whether the damping takes no energy from outside.
    pub(super) dissipates: bool,
}

/// The square of a frequency, with its right and left solutions.
type Solution = (f64, [DVector<f64>; 2]);

/// Differences of entries that are rounding errors, in parts of their terms.
const SYMMETRIC: f64 = 1e-11;
/// Stiffnesses that are rounding errors, likewise.
const NO_STIFFNESS: f64 = 1e-14;
/// Squares of frequencies that count as the same, in parts of them.
const REPEATED: f64 = 1e-9;
const MOST_ITERATIONS: usize = 10_000;

impl ReducedEquations {
    /// # Errors
    /// A motion has no inertia.
    pub(super) fn new(at: &RestState) -> Result<Self, NoModes> {
        let null_space = &at.null_space;
        let massless = || NoModes::Massless { q: at.q.clone() };
        let mass = null_space.reduced(&at.mass);
        let mass = 0.5 * (&mass + mass.transpose());
        let lower = Cholesky::new(mass).ok_or_else(massless)?.l();
        let freedom = null_space.freedom();
        let scale = lower
            .transpose()
            .solve_upper_triangular(&DMatrix::identity(freedom, freedom))
            .filter(|scale| scale.iter().all(|entry| entry.is_finite()))
            .ok_or_else(massless)?;
        let motions = &null_space.basis * &scale;
        let scaled = |matrix: &DMatrix<f64>| motions.transpose() * matrix * &motions;
        let sizes = |matrix: &DMatrix<f64>| motions.transpose().abs() * matrix.abs() * motions.abs();
        let (stiffness, damping) = (scaled(&at.stiffness), scaled(&at.damping));
        let (stiffness_terms, damping_terms) = (sizes(&at.stiffness_terms), sizes(&at.damping));
        let is_symmetric = |matrix: &DMatrix<f64>, terms: &DMatrix<f64>| {
            (matrix - matrix.transpose()).amax() <= SYMMETRIC * terms.amax()
        };
        let svd = stiffness.clone().svd(true, true);
        let cut = NO_STIFFNESS * stiffness_terms.amax();
        let inverse = svd.pseudo_inverse(cut.max(f64::MIN_POSITIVE)).map_err(|_| NoModes::NoEigenvalues)?;
        let dissipates = damping.iter().all(|entry| *entry == 0.0)
            || is_symmetric(&damping, &damping_terms)
                && SymmetricEigen::try_new(0.5 * (&damping + damping.transpose()), f64::EPSILON, MOST_ITERATIONS)
                    .is_some_and(|eigen| eigen.eigenvalues.min() >= -SYMMETRIC * damping_terms.amax());
        Ok(Self {
            is_symmetric: is_symmetric(&stiffness, &stiffness_terms),
            compliance: &scale * inverse * scale.transpose(),
            stiffness,
            stiffness_terms,
            damping,
            damping_terms,
            scale,
            dissipates,
        })
    }

    /// The squares of frequencies with right and left solutions, and those that are not real.
    fn solutions(&self) -> Result<(Vec<Solution>, Vec<Complex<f64>>), NoModes> {
        let mut squares = Vec::new();
        if self.is_symmetric {
            let symmetric = 0.5 * (&self.stiffness + self.stiffness.transpose());
            let eigen =
                SymmetricEigen::try_new(symmetric, f64::EPSILON, MOST_ITERATIONS).ok_or(NoModes::NoEigenvalues)?;
            for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                squares.push((*value, [vector.into_owned(), vector.into_owned()]));
            }
            return Ok((squares, Vec::new()));
        }
        let all = eigenvalues(self.stiffness.clone()).ok_or(NoModes::NoEigenvalues)?;
        for square in all.iter().filter(|square| square.im == 0.0) {
            let shifted =
                &self.stiffness - DMatrix::identity(self.stiffness.nrows(), self.stiffness.nrows()) * square.re;
            let svd = shifted.try_svd(true, true, f64::EPSILON, MOST_ITERATIONS).ok_or(NoModes::NoEigenvalues)?;
            let (u, v_t) = svd.u.zip(svd.v_t).ok_or(NoModes::NoEigenvalues)?;
            let last = svd.singular_values.imin();
            squares.push((square.re, [v_t.row(last).transpose(), u.column(last).into_owned()]));
        }
        Ok((squares, all.into_iter().filter(|square| square.im > 0.0).collect()))
    }
}

/// The modes, and the squares of frequencies that are not real.
pub(super) fn modes(
    equations: &mut RestEquations,
    at: &RestState,
    reduced: &ReducedEquations,
    by: &ByParameters,
    rounding: &Rounding,
) -> Result<(Vec<Mode>, Vec<Complex<f64>>), NoModes> {
    let (solutions, complex_squares) = reduced.solutions()?;
    let parameters = DVector::from_column_slice(equations.parameters());
    let motion = |scaled: &DVector<f64>| &at.null_space.basis * (&reduced.scale * scaled);
    let mut modes: Vec<Mode> = Vec::new();
    for (approximate, scaled) in solutions {
        let [right, left] = [motion(&scaled[0]), motion(&scaled[1])];
        let inertia = left.dot(&(&at.mass * &right));
        // Rayleigh's quotient has the square of the error of the vectors.
        let square = left.dot(&(&at.stiffness * &right)) / inertia;
        let square = if square.is_finite() { square } else { approximate };
        let multipliers =
            |matrix: &DMatrix<f64>, v: &DVector<f64>| at.null_space.multipliers(&(&at.mass * v * square - matrix * v));
        let vectors = [
            PencilVector { mu: multipliers(&at.stiffness, &right), v: right },
            PencilVector { mu: multipliers(&at.stiffness.transpose(), &left), v: left },
        ];
        let gradient = equations.gradient(at, [&vectors[0], &vectors[1]], square);
        let (total, of_equilibrium) = with_equilibrium(at, reduced, by, rounding, &gradient);
        let [right, left] = &vectors;
        let sizes = |matrix: &DMatrix<f64>| left.v.abs().dot(&(matrix.abs() * right.v.abs()));
        let links = |one: &PencilVector, other: &PencilVector| one.mu.abs().dot(&(at.jacobian.abs() * other.v.abs()));
        let terms =
            sizes(&at.stiffness_terms) + square.abs() * sizes(&at.mass) + links(right, left) + links(left, right);
        let terms = terms + total.abs().dot(&parameters.abs());
        let square_error = (ROUNDING * terms + of_equilibrium) / inertia.abs();
        modes.push(Mode {
            square,
            square_error,
            shape: shape(&right.v, &at.null_space.sizes),
            by_parameters: Some((total / inertia).iter().copied().collect()),
            scaled,
        });
    }
    modes.sort_by(|a, b| a.square.total_cmp(&b.square));
    let squares: Vec<(f64, f64)> = modes.iter().map(|mode| (mode.square, mode.square_error)).collect();
    for (place, mode) in modes.iter_mut().enumerate() {
        let is_same = |(other, (square, error)): (usize, &(f64, f64))| {
            let nearby = (error + mode.square_error).max(REPEATED * mode.square.abs());
            other != place && (square - mode.square).abs() <= nearby
        };
        let is_repeated = squares.iter().enumerate().any(is_same);
        // From the derivatives of the square.
        let slope = match mode.kind() {
            ModeKind::Oscillation if !is_repeated => 0.5 / mode.rate().0,
            ModeKind::Growth if !is_repeated => -0.5 / mode.rate().0,
            _ => {
                mode.by_parameters = None;
                continue;
            }
        };
        mode.by_parameters.iter_mut().flatten().for_each(|derivative| *derivative = *derivative * slope + 0.0);
    }
    Ok((modes, complex_squares))
}

/// The derivatives by parameters with the move of the equilibrium, and the error by the equations at rest: both by the
/// adjoint solution `y` of `[K, C_q'; C_q, 0]' y = gradient`.
fn with_equilibrium(
    at: &RestState,
    reduced: &ReducedEquations,
    by: &ByParameters,
    rounding: &Rounding,
    gradient: &Gradient,
) -> (DVector<f64>, f64) {
    let null_space = &at.null_space;
    let transposed = at.stiffness.transpose();
    let particular = null_space.particular(&gradient.multipliers);
    let right = null_space.basis.transpose() * (&gradient.q - &transposed * &particular);
    let of_forces = particular + &null_space.basis * (reduced.compliance.transpose() * right);
    let of_constraints = null_space.multipliers(&(&gradient.q - &transposed * &of_forces));
    let moved = by.forces.transpose() * &of_forces + by.constraints.transpose() * &of_constraints;
    let error = of_forces.abs().dot(&rounding.forces) + of_constraints.abs().dot(&rounding.constraints);
    (&gradient.parameters - moved, error)
}

/// A mode shape whose largest entry is one.
fn shape(motion: &DVector<f64>, sizes: &[f64]) -> Vec<f64> {
    let entry = |i: usize| motion[i] / sizes[i];
    let largest = (0..sizes.len())
        .map(entry)
        .fold(0.0, |most: f64, entry| if entry.abs() > most.abs() * (1.0 + 1e-9) { entry } else { most });
    let largest = if largest == 0.0 { 1.0 } else { largest };
    // A mechanism of lengths alone has its largest length in place of a radian.
    let unit = if sizes.iter().all(|size| *size == sizes[0]) { sizes[0] } else { 1.0 };
    motion.iter().map(|value| value / (largest * unit) + 0.0).collect()
}
