//! The distance of a motion from singular positions.

use crate::solve::{Matrix, NEAR, SingularityDistance};

/// The smallest singular value of `C_q` in the rows of a run.
#[derive(Clone, Debug)]
pub(crate) struct SingularityMonitor {
    nearest: Option<NearestSingularity>,
    distance: SingularityDistance,
}

/// The position at which the constraints are closest to being dependent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestSingularity {
    /// The smallest singular value of `C_q`, in the units of the scene.
    pub value: f64,
    /// The largest such value that is known.
    pub most: f64,
    /// The row.
    pub row: u64,
    /// The time of the row.
    pub t: f64,
    /// The constraint with the largest part in the combination.
    pub constraint: usize,
    /// Whether that constraint itself vanishes, instead of being a combination of others.
    pub is_alone: bool,
}

impl NearestSingularity {
    /// The smallest value as a fraction of the largest one.
    pub fn fraction(&self) -> f64 {
        if self.most > 0.0 { self.value / self.most } else { 1.0 }
    }
}

/// The largest part of other constraints in a combination that belongs to one constraint alone.
const ALONE: f64 = 0.05;

impl SingularityMonitor {
    /// Begins with a distance from singular positions.
    pub(crate) fn new(distance: SingularityDistance) -> Self {
        Self { nearest: None, distance }
    }

    /// Takes the `C_q` of a row; returns its smallest singular value, as a fraction of the largest one, near a singular
    /// position.
    pub(crate) fn note(&mut self, row: u64, t: f64, jacobian: &Matrix) -> Option<f64> {
        let value = self.distance.find(jacobian)?;
        if self.nearest.is_none_or(|nearest| value < nearest.value) {
            let combination = self.distance.combination();
            let part = |k: usize| combination[k].abs();
            let constraint = (0..combination.len()).max_by(|&a, &b| part(a).total_cmp(&part(b))).unwrap_or(0);
            let is_alone = (0..combination.len()).all(|k| k == constraint || part(k) < ALONE);
            self.nearest = Some(NearestSingularity { value, most: value, row, t, constraint, is_alone });
        }
        self.distance.fraction(value, NEAR)
    }

    /// The smallest singular value of the `C_q` of another state, as a fraction of the largest one, near a singular
    /// position.
    pub(crate) fn fraction(&mut self, jacobian: &Matrix) -> Option<f64> {
        let value = self.distance.find(jacobian)?;
        self.distance.fraction(value, NEAR)
    }

    /// The position nearest to a singular one; `None` without independent constraints.
    pub(crate) fn nearest(&self) -> Option<NearestSingularity> {
        self.nearest.map(|nearest| NearestSingularity { most: self.distance.largest(), ..nearest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> Matrix {
        Matrix::from_fn(R, C, |i, j| rows[i][j])
    }

    #[test]
    fn a_row_that_vanishes_and_rows_that_agree_are_told_apart() {
        let mut monitor = SingularityMonitor::new(SingularityDistance::new(2, 2, 2));
        monitor.note(0, 0.0, &matrix([[1.0, 0.0], [0.0, 1.0]]));
        monitor.note(1, 0.1, &matrix([[1.0, 0.0], [0.0, 1e-3]]));
        let nearest = monitor.nearest().expect("two constraints");
        assert_eq!((nearest.row, nearest.constraint, nearest.is_alone, nearest.fraction()), (1, 1, true, 1e-3));
        monitor.note(2, 0.2, &matrix([[1.0, 0.0], [1.0, 1e-6]]));
        let nearest = monitor.nearest().expect("two constraints");
        assert!(nearest.row == 2 && !nearest.is_alone && nearest.fraction() < 1e-6);
    }

    #[test]
    fn many_constraints_are_looked_at_where_it_matters() {
        // The angle between the last two rows closes and opens again.
        let mut monitor = SingularityMonitor::new(SingularityDistance::new(20, 24, 20));
        for row in 0..=200_u32 {
            let angle = 1e-4 + 0.01 * (f64::from(row) - 100.0).abs();
            let mut jacobian = [[0.0; 24]; 20];
            (0..20).for_each(|k| jacobian[k][k] = 1.0);
            (jacobian[19][18], jacobian[19][19]) = (angle.cos(), angle.sin());
            monitor.note(u64::from(row), f64::from(row), &matrix(jacobian));
        }
        let nearest = monitor.nearest().expect("twenty constraints");
        assert!(nearest.row == 100 && nearest.most > 0.5 && !nearest.is_alone, "{nearest:?}");
        assert!((nearest.value - 1e-4 / 2.0_f64.sqrt()).abs() < 1e-10, "{nearest:?}");
    }

    #[test]
    fn a_constraint_said_twice_makes_no_position_singular() {
        let mut monitor = SingularityMonitor::new(SingularityDistance::new(2, 2, 1));
        for (row, angle) in [0.1_f64, 0.5, 0.9].into_iter().enumerate() {
            monitor.note(
                row as u64,
                angle,
                &matrix([[angle.cos(), angle.sin()], [2.0 * angle.cos(), 2.0 * angle.sin()]]),
            );
        }
        assert_eq!(monitor.nearest().expect("two constraints").fraction(), 1.0);
    }
}
