//! The equations of motion as one system, solved by elimination with pivoting.

use qrm_scene::function::Differentiable;

/// The smallest pivot of solvable equations.
const SMALLEST_PIVOT: f64 = 1e-20;

/// `| Mbar C_q' | C_q 0 |`
pub(super) struct System<B> {
    rows: Vec<Vec<B>>,
    coordinates: usize,
}

impl<B: Differentiable> System<B> {
    pub(super) fn new(mass: &[B], jacobian: &[B], n: usize) -> Self {
        let m = jacobian.len() / n.max(1);
        let mut rows = vec![vec![B::from(0.0); n + m]; n + m];
        for i in 0..n {
            rows[i][..n].copy_from_slice(&mass[i * n..(i + 1) * n]);
            for k in 0..m {
                rows[i][n + k] = jacobian[k * n + i];
                rows[n + k][i] = jacobian[k * n + i];
            }
        }
        Self { rows, coordinates: n }
    }

    /// `C_q qd`
    pub(super) fn velocity_residual(&self, qd: &[B]) -> Vec<B> {
        let row = |row: &Vec<B>| row.iter().zip(qd).map(|(entry, v)| *entry * v).sum();
        self.rows[self.coordinates..].iter().map(row).collect()
    }

    /// An upper bound of the error of the solution for relative errors of one in all terms: `|A^-1| (S |x| + s)`, with
    /// the sizes `S` and `s` of the terms of entries and right-hand sides.
    pub(super) fn error_bound(&self, sizes: &Self, x: &[B], right: &[B]) -> Option<Vec<f64>> {
        let (zero, one) = (B::from(0.0), B::from(1.0));
        let size = |row: &[B]| row.iter().zip(x).map(|(entry, x)| (entry.re() * x.re()).abs()).sum::<f64>();
        let errors: Vec<f64> = sizes.rows.iter().zip(right).map(|(row, right)| size(row) + right.re().abs()).collect();
        let mut bound = vec![0.0; self.rows.len()];
        for (j, error) in errors.iter().enumerate() {
            let unit: Vec<B> = (0..self.rows.len()).map(|i| if i == j { one } else { zero }).collect();
            let (forces, closures) = unit.split_at(self.coordinates);
            let (column, _) = self.solve(forces, closures)?;
            bound.iter_mut().zip(column).for_each(|(bound, entry)| *bound += entry.re().abs() * error);
        }
        Some(bound)
    }

    /// The solution, and the largest reduction of a pivot; `None` if the equations are singular.
    pub(super) fn solve(&self, forces: &[B], closures: &[B]) -> Option<(Vec<B>, f64)> {
        let mut a = self.rows.clone();
        let count = a.len();
        let size = |numbers: &mut dyn Iterator<Item = &B>| -> f64 {
            numbers.fold(0.0, |most: f64, number| most.max(number.re().abs()))
        };
        // Units differ between rows and between columns.
        let columns: Vec<f64> = (0..count).map(|j| size(&mut a.iter().map(|row| &row[j]))).collect();
        for (row, right) in a.iter_mut().zip(forces.iter().chain(closures)) {
            row.iter_mut().zip(&columns).for_each(|(entry, size)| *entry /= *size);
            let size = size(&mut row.iter());
            row.push(*right);
            row.iter_mut().for_each(|entry| *entry /= size);
        }
        let mut smallest = 1.0_f64;
        for k in 0..count {
            let pivot = |i: usize| a[i][k].re().abs();
            let best = (k..count).max_by(|&x, &y| pivot(x).total_cmp(&pivot(y)))?;
            smallest = smallest.min(pivot(best));
            a.swap(k, best);
            let pivots = a[k].clone();
            for (i, row) in a.iter_mut().enumerate() {
                if i == k || row[k].re() == 0.0 {
                    continue;
                }
                let ratio = row[k] / pivots[k];
                for j in k..=count {
                    row[j] -= ratio * pivots[j];
                }
            }
        }
        let x: Vec<B> = (0..count).map(|k| a[k][count] / a[k][k] / columns[k]).collect();
        (smallest > SMALLEST_PIVOT && x.iter().all(|x| x.re().is_finite())).then(|| (x, 1.0 / smallest))
    }
}
