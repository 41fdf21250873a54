//! How near a motion comes to positions where its constraints say too little.

use crate::linear::singular::{smallest, tracked};
use crate::linear::{Matrix, dot};

/// The smallest singular value of `C_q` in the rows of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rank {
    nearest: Option<Nearest>,
    /// Of many constraints, the one that said least in the last row.
    combination: Vec<f64>,
    /// Largest length of a row of `C_q`.
    longest: f64,
}

/// A position where a combination of constraints is nearest to saying nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The smallest singular value of `C_q`, in the units of the scene.
    pub value: f64,
    /// The largest that it was in any other row.
    pub most: f64,
    /// The row.
    pub row: u64,
    /// Its time.
    pub t: f64,
    /// The constraint that has the largest part in the combination.
    pub constraint: usize,
    /// Whether that constraint says nothing by itself, rather than what others say.
    pub is_alone: bool,
}

impl Nearest {
    /// Which fraction of its largest value the smallest one is.
    pub fn fraction(&self) -> f64 {
        if self.most > 0.0 { self.value / self.most } else { 1.0 }
    }
}

/// A smallest singular value below this part of the longest row is a rounding error.
const ROUNDING: f64 = 1e-13;
/// Parts of other constraints in a combination to which one belongs alone.
const ALONE: f64 = 0.05;

/// More constraints than this are followed from row to row: their singular values take too long to find anew.
const MANY: usize = 16;

impl Rank {
    pub(crate) fn note<const N: usize, const M: usize>(&mut self, row: u64, t: f64, jacobian: &Matrix<M, N>) {
        let tracked = if M > MANY { tracked(jacobian, &mut self.combination) } else { None };
        let Some(found) = tracked.or_else(|| smallest(jacobian)) else { return };
        self.longest = jacobian.iter().fold(self.longest, |longest, row| longest.max(dot(row, row).sqrt()));
        let most = self.nearest.map_or(found.value, |before| before.most.max(found.value));
        match &mut self.nearest {
            Some(before) if before.value <= found.value => before.most = most,
            nearest => {
                let part = |k: usize| found.rows[k].abs();
                let constraint = (0..M).max_by(|&a, &b| part(a).total_cmp(&part(b))).unwrap_or(0);
                let is_alone = (0..M).all(|k| k == constraint || part(k) < ALONE);
                *nearest = Some(Nearest { value: found.value, most, row, t, constraint, is_alone });
            }
        }
    }

    /// Where they came nearest; `None` without constraints. Where they depend on each other everywhere, no position is worse
    /// than others.
    pub(crate) fn nearest(&self) -> Option<Nearest> {
        let nearest = self.nearest?;
        let is_redundant = nearest.most <= ROUNDING * self.longest;
        Some(if is_redundant { Nearest { most: nearest.value, ..nearest } } else { nearest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_vanishes_and_rows_that_agree_are_told_apart() {
        let mut rank = Rank::default();
        rank.note(0, 0.0, &[[1.0, 0.0], [0.0, 1.0]]);
        rank.note(1, 0.1, &[[1.0, 0.0], [0.0, 1e-3]]);
        let nearest = rank.nearest().expect("two constraints");
        assert_eq!((nearest.row, nearest.constraint, nearest.is_alone, nearest.fraction()), (1, 1, true, 1e-3));
        rank.note(2, 0.2, &[[1.0, 0.0], [1.0, 1e-6]]);
        let nearest = rank.nearest().expect("two constraints");
        assert!(nearest.row == 2 && !nearest.is_alone && nearest.fraction() < 1e-6);
    }

    #[test]
    fn many_constraints_are_looked_at_where_it_matters() {
        // The angle between the last two rows closes and opens again.
        let mut rank = Rank::default();
        for row in 0..=200_u32 {
            let angle = 1e-4 + 0.01 * (f64::from(row) - 100.0).abs();
            let mut jacobian = [[0.0; 24]; 20];
            (0..20).for_each(|k| jacobian[k][k] = 1.0);
            (jacobian[19][18], jacobian[19][19]) = (angle.cos(), angle.sin());
            rank.note(u64::from(row), f64::from(row), &jacobian);
        }
        let nearest = rank.nearest().expect("twenty constraints");
        assert!(nearest.row == 100 && nearest.most > 0.5 && !nearest.is_alone, "{nearest:?}");
        assert!((nearest.value - 1e-4 / 2.0_f64.sqrt()).abs() < 1e-10, "{nearest:?}");
    }

    #[test]
    fn a_constraint_said_twice_makes_no_position_singular() {
        let mut rank = Rank::default();
        for (row, angle) in [0.1_f64, 0.5, 0.9].into_iter().enumerate() {
            rank.note(row as u64, angle, &[[angle.cos(), angle.sin()], [2.0 * angle.cos(), 2.0 * angle.sin()]]);
        }
        assert_eq!(rank.nearest().expect("two constraints").fraction(), 1.0);
    }
}
