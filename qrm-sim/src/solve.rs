//! Accelerations, multipliers and corrections of one state.

use qrm_core::Dynamics;

use crate::linear::{Ldl, Matrix, PivotedLdl, Vector, dot, multiply};

/// How often the fast way did not do, and what stood in its way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Care {
    /// Solves with a mass matrix that is singular by itself.
    pub singular_mass: u64,
    /// Solves with constraints that all but depend on each other, or one of which all but vanishes.
    pub suspicious_constraints: u64,
    /// Those where they do depend on each other.
    pub dependent_constraints: u64,
    /// The constraint that last depended on the others.
    pub constraint: Option<usize>,
    /// Corrections that rounding errors kept from the tolerance.
    pub settled: u64,
    /// The constraint that stayed farthest open then, and how far.
    pub farthest: (usize, f64),
    /// Largest residual before coordinates were corrected.
    pub open: f64,
    /// By how much a coordinate was corrected at most.
    pub moved: f64,
}

impl Care {
    /// Notes a correction that rounding errors kept from the tolerance.
    #[cold]
    pub fn note_settled(&mut self, constraint: usize, residual: f64) {
        self.settled += 1;
        if residual > self.farthest.1 {
            self.farthest = (constraint, residual);
        }
    }

    /// Notes whether constraints depend on each other.
    fn note_rank<const M: usize>(&mut self, factors: &PivotedLdl<M>) {
        if factors.rank < M {
            self.dependent_constraints += 1;
            self.constraint = factors.dependent().first().copied();
        }
    }

    /// Notes how far the loops were open before the coordinates were corrected, and by how much.
    #[inline(always)]
    pub fn note_correction<const N: usize>(&mut self, open: f64, from: &Vector<N>, to: &Vector<N>) {
        self.open = self.open.max(open);
        for i in 0..N {
            self.moved = self.moved.max((to[i] - from[i]).abs());
        }
    }
}

/// Products of larger masses overflow.
const LARGEST_MASS: f64 = 1e150;

/// Why the accelerations are not determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Undetermined {
    /// No inertia resists a motion of this coordinate that the constraints allow.
    Massless(usize),
    /// The equations of motion have terms that are not finite.
    NotFinite,
}

/// What the equations of motion give at one state.
#[derive(Clone, Copy, Debug)]
pub struct Solution<const N: usize, const M: usize> {
    /// Accelerations.
    pub qdd: Vector<N>,
    /// Multipliers.
    pub multipliers: Vector<M>,
    /// The factors of `Mbar`, unless it is singular by itself.
    pub mass: Option<Ldl<N>>,
}

/// Solves `Mbar qdd + C_q' lambda = fbar`, `C_q qdd + bias = 0` by the Schur complement `C_q Mbar^-1 C_q'`.
///
/// A singular `Mbar` is first completed by `C_q' C_q`, which changes no solution; dependent constraints keep the
/// accelerations right and leave the share of each of them in the force open.
///
/// # Errors
/// `Mbar` is singular on the motions that the constraints allow.
#[inline(always)]
pub fn accelerations<const N: usize, const M: usize>(
    dynamics: &Dynamics<f64, N, M>,
    care: &mut Care,
) -> Result<Solution<N, M>, Undetermined> {
    if let Some(mass) = Ldl::new(&dynamics.mass_matrix) {
        let free = mass.solve(&dynamics.generalized_forces);
        let pull = pull(&mass, &dynamics.constraint_jacobian);
        if let Some(schur) = Ldl::of_products(&schur(&dynamics.constraint_jacobian, &pull)) {
            let multipliers = schur.solve(&excess(dynamics, &free));
            return Ok(Solution { qdd: corrected(&free, &pull, &multipliers), multipliers, mass: Some(mass) });
        }
    }
    careful_accelerations(dynamics, care)
}

#[cold]
fn careful_accelerations<const N: usize, const M: usize>(
    dynamics: &Dynamics<f64, N, M>,
    care: &mut Care,
) -> Result<Solution<N, M>, Undetermined> {
    let jacobian = &dynamics.constraint_jacobian;
    let terms = dynamics.mass_matrix.iter().chain(jacobian).flatten();
    if !terms.chain(&dynamics.generalized_forces).chain(&dynamics.constraint_bias).all(|term| term.is_finite()) {
        return Err(Undetermined::NotFinite);
    }
    let mut mass = dynamics.mass_matrix;
    let mut forces = dynamics.generalized_forces;
    let own = Ldl::new(&mass);
    if own.is_none() {
        care.singular_mass += 1;
        let scale = (0..N).fold(0.0, |most: f64, i| most.max(mass[i][i]));
        let scale = if scale > 0.0 { scale } else { 1.0 };
        for (row, bias) in jacobian.iter().zip(dynamics.constraint_bias) {
            let size = dot(row, row);
            let weight = if size > 0.0 { scale / size } else { 0.0 };
            for i in 0..N {
                forces[i] -= weight * row[i] * bias;
                for j in 0..N {
                    mass[i][j] += weight * row[i] * row[j];
                }
            }
        }
    }
    let Some(mass_factors) = Ldl::new(&mass) else {
        if (0..N).any(|i| mass[i][i] > LARGEST_MASS) {
            return Err(Undetermined::NotFinite);
        }
        let coordinate = PivotedLdl::new(&mass).dependent().first().copied().unwrap_or(0);
        return Err(Undetermined::Massless(coordinate));
    };
    let completed = Dynamics { mass_matrix: mass, generalized_forces: forces, ..*dynamics };
    let free = mass_factors.solve(&forces);
    let pull = pull(&mass_factors, jacobian);
    let schur = schur(jacobian, &pull);
    if Ldl::of_products(&schur).is_none() {
        care.suspicious_constraints += 1;
    }
    let factors = PivotedLdl::new(&schur);
    care.note_rank(&factors);
    let multipliers = factors.solve(&excess(&completed, &free));
    Ok(Solution { qdd: corrected(&free, &pull, &multipliers), multipliers, mass: own })
}

/// The smallest corrections that remove residuals, in the metric of a mass matrix or in the plain one.
#[derive(Clone, Copy, Debug)]
pub struct Corrector<const N: usize, const M: usize> {
    pull: Matrix<M, N>,
    schur: Matrix<M, M>,
    factors: Option<Ldl<M>>,
}

impl<const N: usize, const M: usize> Corrector<N, M> {
    /// Prepares corrections at one position.
    #[inline(always)]
    pub fn new(jacobian: &Matrix<M, N>, mass: Option<&Ldl<N>>) -> Self {
        let pull = match mass {
            Some(mass) => pull(mass, jacobian),
            None => *jacobian,
        };
        let schur = schur(jacobian, &pull);
        Self { pull, schur, factors: Ldl::of_products(&schur) }
    }

    /// Moves `x` by the smallest `dx` with `C_q dx = -residual`.
    #[inline(always)]
    pub fn correct(&self, x: &mut Vector<N>, residual: &Vector<M>, care: &mut Care) {
        let weights = match &self.factors {
            Some(factors) => factors.solve(residual),
            None => self.careful_weights(residual, care),
        };
        *x = corrected(x, &self.pull, &weights);
    }

    #[cold]
    fn careful_weights(&self, residual: &Vector<M>, care: &mut Care) -> Vector<M> {
        let factors = PivotedLdl::new(&self.schur);
        care.note_rank(&factors);
        factors.solve(residual)
    }
}

/// `Mbar^-1 C_q'`, a row for each constraint.
#[inline(always)]
pub(crate) fn pull<const N: usize, const M: usize>(mass: &Ldl<N>, jacobian: &Matrix<M, N>) -> Matrix<M, N> {
    std::array::from_fn(|i| mass.solve(&jacobian[i]))
}

/// `C_q Mbar^-1 C_q'`
#[inline(always)]
pub(crate) fn schur<const N: usize, const M: usize>(jacobian: &Matrix<M, N>, pull: &Matrix<M, N>) -> Matrix<M, M> {
    std::array::from_fn(|i| multiply(pull, &jacobian[i]))
}

/// By how much free accelerations violate the constraints.
#[inline(always)]
fn excess<const N: usize, const M: usize>(dynamics: &Dynamics<f64, N, M>, free: &Vector<N>) -> Vector<M> {
    std::array::from_fn(|i| dot(&dynamics.constraint_jacobian[i], free) + dynamics.constraint_bias[i])
}

#[inline(always)]
fn corrected<const N: usize, const M: usize>(free: &Vector<N>, pull: &Matrix<M, N>, weights: &Vector<M>) -> Vector<N> {
    let mut result = *free;
    for (row, weight) in pull.iter().zip(weights) {
        for i in 0..N {
            result[i] -= weight * row[i];
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two masses in line, held at a distance: one of them may be massless.
    fn rod(first: f64, second: f64) -> Dynamics<f64, 2, 1> {
        Dynamics {
            mass_matrix: [[first, 0.0], [0.0, second]],
            generalized_forces: [3.0, 1.0],
            constraint_jacobian: [[1.0, -1.0]],
            constraint_bias: [0.5],
        }
    }

    #[test]
    fn a_massless_coordinate_is_carried_by_its_constraint() {
        let mut care = Care::default();
        let Solution { qdd, multipliers, .. } = accelerations(&rod(0.0, 2.0), &mut care).expect("determined");
        // a1 - a2 = -0.5, lambda = 3, 2 a2 - lambda = 1
        assert!((qdd[1] - 2.0).abs() < 1e-14 && (qdd[0] - 1.5).abs() < 1e-14, "{qdd:?}");
        assert!((multipliers[0] - 3.0).abs() < 1e-14);
        assert_eq!(care.singular_mass, 1);
    }

    #[test]
    fn no_mass_at_all_is_an_error() {
        assert!(
            accelerations(&rod(0.0, 0.0), &mut Care::default()).is_err_and(|e| matches!(e, Undetermined::Massless(_)))
        );
    }

    #[test]
    fn a_constraint_said_twice_changes_no_acceleration() {
        let once = rod(1.0, 2.0);
        let twice = Dynamics {
            mass_matrix: once.mass_matrix,
            generalized_forces: once.generalized_forces,
            constraint_jacobian: [[1.0, -1.0], [2.0, -2.0]],
            constraint_bias: [0.5, 1.0],
        };
        let mut care = Care::default();
        let expected = accelerations(&once, &mut care).expect("determined").qdd;
        assert_eq!(care, Care::default());
        let qdd = accelerations(&twice, &mut care).expect("determined").qdd;
        assert!((qdd[0] - expected[0]).abs() < 1e-14 && (qdd[1] - expected[1]).abs() < 1e-14);
        assert_eq!(care.dependent_constraints, 1);
    }
}
