//! The saddle-point system of accelerations and multipliers at any position, including singular ones.

use super::buffers::Dynamics;
use super::ldl::{Ldl, PivotedLdl, SUSPICIOUS};
use super::matrix::{Matrix, dot, subtract_combination};
use super::stats::SolverStats;

/// The smallest pivot of the Schur complement for which derivatives are usable.
const SINGULAR: f64 = 1e-9;
/// Products of larger masses overflow.
const LARGEST_MASS: f64 = 1e150;

/// The reason why the accelerations are not determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Undetermined {
    /// A motion of this coordinate that the constraints allow has no inertia.
    Massless(usize),
    /// The equations of motion have terms that are not finite.
    NotFinite,
    /// The forces are not finite.
    ForcesNotFinite,
}

/// Solves `Mbar qdd + C_q' lambda = fbar`, `C_q qdd + bias = 0` by the Schur complement `C_q Mbar^-1 C_q'`.
///
/// A singular `Mbar` is completed by `C_q' C_q`, which does not change the solution. With dependent constraints the
/// accelerations stay correct, while the distribution of the force among the constraints is arbitrary.
#[derive(Clone, Debug)]
pub(crate) struct SaddlePoint {
    /// The equations to solve.
    pub(crate) dynamics: Dynamics,
    /// The factors of `Mbar`.
    pub(super) mass: Ldl,
    pub(super) minv_ct: Matrix,
    pub(super) schur: Matrix,
    pub(super) schur_factors: Ldl,
    /// The number of constraints that are independent at regular positions.
    pub(super) rank: usize,
}

impl SaddlePoint {
    /// Creates buffers for a mechanism of `n` coordinates and `m` constraints.
    pub(crate) fn zero(n: usize, m: usize) -> Self {
        Self {
            dynamics: Dynamics::zero(n, m),
            mass: Ldl::with_size(n),
            minv_ct: Matrix::zero(m, n),
            schur: Matrix::zero(m, m),
            schur_factors: Ldl::with_size(m),
            rank: m,
        }
    }

    /// Whether constraints are redundant along the whole motion.
    pub(super) fn is_redundant(&self) -> bool {
        self.rank < self.schur.columns()
    }

    /// The factors of the Schur complement without redundant constraints, whose remainders would be amplified near a
    /// singular position.
    pub(super) fn robust_factors(&self) -> PivotedLdl {
        if self.is_redundant() {
            PivotedLdl::without_suspicious_pivots(&self.schur, self.rank)
        } else {
            PivotedLdl::new(&self.schur)
        }
    }

    /// Solves the equations; returns true if the factors of `Mbar` are known afterwards.
    ///
    /// # Errors
    /// `Mbar` is singular for motions that the constraints allow, or terms are not finite.
    pub(crate) fn solve(
        &mut self,
        qdd: &mut [f64],
        multipliers: &mut [f64],
        stats: &mut SolverStats,
    ) -> Result<bool, Undetermined> {
        if !self.is_redundant() && self.factor() {
            self.solve_factored(qdd, multipliers);
            self.check_terms()?;
            return Ok(true);
        }
        self.solve_robustly(qdd, multipliers, stats)
    }

    /// Factors `Mbar` and the Schur complement; false if one of them is singular, or nearly so.
    fn factor(&mut self) -> bool {
        self.factor_above(SUSPICIOUS)
    }

    /// Factors `Mbar` and the Schur complement; false if `Mbar` is singular, or pivots of the Schur complement are below
    /// this fraction of their diagonal entries.
    pub(crate) fn factor_above(&mut self, smallest: f64) -> bool {
        let Self { dynamics, mass, minv_ct: pull, schur, schur_factors, .. } = self;
        if !mass.factor(&dynamics.mass_matrix) {
            return false;
        }
        minv_ct(mass, &dynamics.constraint_jacobian, pull);
        schur_complement(&dynamics.constraint_jacobian, pull, schur);
        schur_factors.factor_products_above(schur, smallest)
    }

    /// Solves the equations with the factors; forces and bias may have changed since.
    pub(crate) fn solve_factored(&self, qdd: &mut [f64], multipliers: &mut [f64]) {
        let Self { dynamics, mass, minv_ct: pull, schur_factors, .. } = self;
        qdd.copy_from_slice(&dynamics.generalized_forces);
        mass.solve(qdd);
        excess(dynamics, qdd, multipliers);
        schur_factors.solve(multipliers);
        subtract_combination(qdd, pull, multipliers);
    }

    /// Whether all terms of the equations are finite.
    fn check_terms(&self) -> Result<(), Undetermined> {
        let Dynamics { mass_matrix, generalized_forces, constraint_jacobian, constraint_bias } = &self.dynamics;
        let are_finite = |terms: &[f64]| terms.iter().all(|term| term.is_finite());
        if ![mass_matrix.entries(), constraint_jacobian.entries(), constraint_bias].into_iter().all(are_finite) {
            return Err(Undetermined::NotFinite);
        }
        if are_finite(generalized_forces) { Ok(()) } else { Err(Undetermined::ForcesNotFinite) }
    }

    /// Solves the equations if they cannot be factored; returns true if the factors of `Mbar` are known afterwards.
    ///
    /// # Errors
    /// `Mbar` is singular for motions that the constraints allow.
    #[cold]
    pub(crate) fn solve_robustly(
        &mut self,
        qdd: &mut [f64],
        multipliers: &mut [f64],
        stats: &mut SolverStats,
    ) -> Result<bool, Undetermined> {
        self.check_terms()?;
        let is_redundant = self.is_redundant();
        let Self { dynamics, mass, minv_ct: pull, schur, schur_factors, rank } = self;
        let n = qdd.len();
        let jacobian = &dynamics.constraint_jacobian;
        let mut completed = dynamics.mass_matrix.clone();
        let mut forces = dynamics.generalized_forces.clone();
        let has_own = mass.factor(&completed);
        if !has_own {
            stats.singular_mass += 1;
            let scale = (0..n).fold(0.0, |most: f64, i| most.max(completed[i][i]));
            let scale = if scale > 0.0 { scale } else { 1.0 };
            for (row, bias) in jacobian.iter().zip(&dynamics.constraint_bias) {
                let size = dot(row, row);
                let weight = if size > 0.0 { scale / size } else { 0.0 };
                for i in 0..n {
                    forces[i] -= weight * row[i] * bias;
                    for j in 0..n {
                        completed[i][j] += weight * row[i] * row[j];
                    }
                }
            }
        }
        if !mass.factor(&completed) {
            if (0..n).any(|i| completed[i][i] > LARGEST_MASS) {
                return Err(Undetermined::NotFinite);
            }
            let coordinate = PivotedLdl::new(&completed).dependent().first().copied().unwrap_or(0);
            return Err(Undetermined::Massless(coordinate));
        }
        qdd.copy_from_slice(&forces);
        mass.solve(qdd);
        minv_ct(mass, jacobian, pull);
        schur_complement(jacobian, pull, schur);
        let factors = PivotedLdl::with_rank(schur, *rank);
        let is_regular = if is_redundant {
            PivotedLdl::without_suspicious_pivots(schur, *rank).rank == *rank
        } else {
            schur_factors.factor_products(schur)
        };
        stats.suspicious_constraints += u64::from(!is_regular);
        let is_singular = !is_regular && !schur_factors.factor_products_above(schur, SINGULAR);
        stats.singular_constraints += u64::from(is_singular);
        stats.count_rank(&factors, *rank);
        excess(dynamics, qdd, multipliers);
        factors.solve(multipliers);
        subtract_combination(qdd, pull, multipliers);
        Ok(has_own)
    }
}

/// `Mbar^-1 C_q'`, a row for each constraint.
pub(crate) fn minv_ct(mass: &Ldl, jacobian: &Matrix, result: &mut Matrix) {
    result.copy_from(jacobian);
    mass.solve_rows(result);
}

/// `C_q Mbar^-1 C_q'`
pub(crate) fn schur_complement(jacobian: &Matrix, minv_ct: &Matrix, result: &mut Matrix) {
    for (i, row) in jacobian.iter().enumerate() {
        result[i].fill(0.0);
        // Most constraints contain few coordinates.
        for (k, entry) in row.iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
            for (j, other) in minv_ct.iter().enumerate() {
                result[i][j] += other[k] * entry;
            }
        }
    }
}

/// The violation of the constraints by free accelerations, `C_q qdd + bias`.
fn excess(dynamics: &Dynamics, free: &[f64], result: &mut [f64]) {
    let rows = dynamics.constraint_jacobian.iter().zip(&dynamics.constraint_bias);
    for (excess, (row, bias)) in result.iter_mut().zip(rows) {
        *excess = dot(row, free) + bias;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two masses in line at a fixed distance; one of them may be massless.
    fn rod(first: f64, second: f64) -> SaddlePoint {
        let mut saddle = SaddlePoint::zero(2, 1);
        saddle.dynamics.mass_matrix.entries_mut().copy_from_slice(&[first, 0.0, 0.0, second]);
        saddle.dynamics.generalized_forces.copy_from_slice(&[3.0, 1.0]);
        saddle.dynamics.constraint_jacobian.entries_mut().copy_from_slice(&[1.0, -1.0]);
        saddle.dynamics.constraint_bias[0] = 0.5;
        saddle
    }

    fn solve(mut saddle: SaddlePoint, stats: &mut SolverStats) -> Result<(Vec<f64>, Vec<f64>), Undetermined> {
        let dynamics = &saddle.dynamics;
        let (mut qdd, mut multipliers) =
            (vec![0.0; dynamics.generalized_forces.len()], vec![0.0; dynamics.constraint_bias.len()]);
        saddle.solve(&mut qdd, &mut multipliers, stats)?;
        Ok((qdd, multipliers))
    }

    #[test]
    fn a_massless_coordinate_is_carried_by_its_constraint() {
        let mut stats = SolverStats::default();
        let (qdd, multipliers) = solve(rod(0.0, 2.0), &mut stats).expect("determined");
        // a1 - a2 = -0.5, lambda = 3, 2 a2 - lambda = 1
        assert!((qdd[1] - 2.0).abs() < 1e-14 && (qdd[0] - 1.5).abs() < 1e-14, "{qdd:?}");
        assert!((multipliers[0] - 3.0).abs() < 1e-14);
        assert_eq!(stats.singular_mass, 1);
    }

    #[test]
    fn no_mass_at_all_is_an_error() {
        let result = solve(rod(0.0, 0.0), &mut SolverStats::default());
        assert!(result.is_err_and(|e| matches!(e, Undetermined::Massless(_))));
    }

    #[test]
    fn a_repeated_constraint_changes_no_acceleration() {
        let once = rod(1.0, 2.0);
        let mut twice = SaddlePoint::zero(2, 2);
        twice.dynamics.mass_matrix = once.dynamics.mass_matrix.clone();
        twice.dynamics.generalized_forces = once.dynamics.generalized_forces.clone();
        twice.dynamics.constraint_jacobian.entries_mut().copy_from_slice(&[1.0, -1.0, 2.0, -2.0]);
        twice.dynamics.constraint_bias.copy_from_slice(&[0.5, 1.0]);
        let mut stats = SolverStats::default();
        let (expected, _) = solve(once, &mut stats).expect("determined");
        assert_eq!(stats, SolverStats::default());
        let (qdd, _) = solve(twice, &mut stats).expect("determined");
        assert!((qdd[0] - expected[0]).abs() < 1e-14 && (qdd[1] - expected[1]).abs() < 1e-14);
        assert_eq!(stats.dependent_constraints, 1);
    }
}
