//! Statistics of the linear solves of a run.

use super::ldl::PivotedLdl;

/// The numbers of solves for which the fast method did not suffice, and the size of the corrections.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolverStats {
    /// Solves with a singular mass matrix.
    pub singular_mass: u64,
    /// Solves with constraints that are nearly dependent, or one of which nearly vanishes.
    pub suspicious_constraints: u64,
    /// Solves with constraints so nearly dependent that derivatives are lost.
    pub singular_constraints: u64,
    /// Solves with dependent constraints.
    pub dependent_constraints: u64,
    /// The last dependent constraint.
    pub constraint: Option<usize>,
    /// The time at which multipliers grow without bound, if they do.
    pub unbounded_at: Option<f64>,
    /// Projections whose residual stayed above the tolerance because of rounding errors.
    pub stalled_projections: u64,
    /// The constraint with the largest such residual, and that residual.
    pub largest_stalled_residual: (usize, f64),
    /// Largest residual before a correction of the coordinates.
    pub residual_before_correction: f64,
}

impl SolverStats {
    /// Counts a projection whose residual stayed above the tolerance because of rounding errors.
    #[cold]
    pub(super) fn count_stalled(&mut self, constraint: usize, residual: f64) {
        self.stalled_projections += 1;
        if residual > self.largest_stalled_residual.1 {
            self.largest_stalled_residual = (constraint, residual);
        }
    }

    /// Records the residual before a correction.
    pub(crate) fn take_residual(&mut self, residual: f64) {
        self.residual_before_correction = self.residual_before_correction.max(residual);
    }

    /// Counts a solve with fewer independent constraints than elsewhere.
    pub(super) fn count_rank(&mut self, factors: &PivotedLdl, rank: usize) {
        if factors.rank < rank
            && let Some(constraint) = factors.dependent().first()
        {
            self.dependent_constraints += 1;
            self.constraint = Some(*constraint);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_residual_is_kept() {
        let mut stats = SolverStats::default();
        [(0, 1e-9), (2, 3e-9), (1, 2e-9)]
            .into_iter()
            .for_each(|(constraint, size)| stats.count_stalled(constraint, size));
        assert_eq!((stats.stalled_projections, stats.largest_stalled_residual), (3, (2, 3e-9)));
    }
}
