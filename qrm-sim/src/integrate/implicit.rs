//! Steps by a linearly implicit method, for stiff springs and dampers.

use qrm_core::Mechanism;

use super::rodas::{ARGUMENTS, BY_TIME, GAMMA, INCREMENTS, NODES};
use super::step_error::StepError;
use super::step_formula::{Accepted, Evaluator, StepFormula, Task};
use crate::solve::{Dynamics, Linearization, Lu, Matrix, PivotedLdl, dot, row_products};
use crate::state::State;

/// RODAS on coordinates and rates, with the exact Jacobian of the accelerations. It needs the derivatives of the
/// equations `Mbar a + C_q' lambda = fbar`, `C_q a = -bias`, but not those of their solution.
#[derive(Clone, Debug)]
pub(super) struct Implicit;

impl StepFormula for Implicit {
    fn order(&self) -> i32 {
        4
    }

    fn beta(&self) -> f64 {
        0.0
    }

    fn attempt(
        &mut self,
        mechanism: &dyn Mechanism,
        from: &State,
        h: f64,
        task: &Task,
        evaluator: &mut Evaluator,
        to: &mut State,
    ) -> Result<f64, StepError> {
        let (n, m) = (from.q.len(), from.multipliers.len());
        let mut linearization = Linearization::zero(n, m);
        if !linearization.evaluate(mechanism, from) {
            return Err(StepError::NoLinearization);
        }
        let dynamics = Dynamics::at(mechanism, from.t, &from.q, &from.qd);
        let system =
            System::new(&dynamics, &linearization, h * GAMMA, evaluator.solver.rank()).ok_or(StepError::NotFinite)?;
        let mut increments: Vec<(Vec<f64>, Vec<f64>)> = Vec::with_capacity(6);
        let (mut q, mut qd) = (from.q.clone(), from.qd.clone());
        let (mut qdd, mut multipliers) = (from.qdd.clone(), from.multipliers.clone());
        for stage in 0..6 {
            q.copy_from_slice(&from.q);
            qd.copy_from_slice(&from.qd);
            let (mut along, mut change) = (vec![0.0; n], vec![0.0; n]);
            for (j, (u, w)) in increments.iter().enumerate() {
                let (of_argument, of_increment) = (ARGUMENTS[stage][j], INCREMENTS[stage][j] / h);
                for i in 0..n {
                    q[i] += of_argument * u[i];
                    qd[i] += of_argument * w[i];
                    along[i] += of_increment * u[i];
                    change[i] += of_increment * w[i];
                }
            }
            if stage > 0 {
                let t = from.t + NODES[stage] * h;
                *evaluator.evaluations += 1;
                evaluator.solver.accelerations(mechanism, t, (&q, &qd), (&mut qdd, &mut multipliers))?;
            }
            for i in 0..n {
                along[i] += qd[i];
                change[i] += qdd[i];
            }
            increments.push(system.increment(&along, &change, BY_TIME[stage] * h));
        }
        // The last increment completes the step, and is its error estimate.
        let (u, w) = &increments[5];
        for i in 0..n {
            q[i] += u[i];
            qd[i] += w[i];
        }
        let mut sum = 0.0;
        for i in 0..n {
            let [of_q, of_qd] = task.error_scales(mechanism, i, from, (&q, &qd));
            sum += (u[i] / of_q).powi(2) + (w[i] / of_qd).powi(2);
        }
        let error = (sum / (2.0 * n.max(1) as f64)).sqrt();
        if !(error <= 1.0) {
            return Ok(error);
        }
        to.t = task.end_of_step(from.t, h);
        (to.q, to.qd) = (q, qd);
        *evaluator.evaluations += 1;
        evaluator.solver.projected(mechanism, task.projection, to)?;
        Ok(error)
    }

    fn accepted(&mut self, _: &dyn Mechanism, _: &State, _: &State) -> Accepted {
        Accepted { is_implicit: true, ..Accepted::default() }
    }

    fn boxed_clone(&self) -> Box<dyn StepFormula> {
        Box::new(self.clone())
    }
}

/// The linear equations of all stages of a step, with `g = h gamma`:
///
/// ```text
/// | Mbar + g D + g^2 K     C_q' | | w  |     | Mbar r - g K v + d f_t  |
/// | C_q + g D_c + g^2 K_c  0    | | mu | = g | C_q r - g K_c v + d c_t |
/// ```
struct System<'a> {
    dynamics: &'a Dynamics,
    linearization: &'a Linearization,
    g: f64,
    /// The lower left part.
    loops: Matrix,
    /// The independent constraints; the redundant ones are satisfied with them.
    rows: Vec<usize>,
    /// The multiple of each constraint that is added to the equations above it. It does not change the solution, and
    /// makes the matrix regular for massless coordinates.
    weights: Vec<f64>,
    inertia: Lu,
    /// `inertia^-1 C_q'`, a row for each constraint.
    inv_ct: Vec<Vec<f64>>,
    schur: Lu,
}

impl<'a> System<'a> {
    /// Creates the system; `None` if the equations are singular.
    fn new(dynamics: &'a Dynamics, linearization: &'a Linearization, g: f64, rank: usize) -> Option<Self> {
        let Linearization { stiffness, damping, constraint_stiffness, constraint_damping, .. } = linearization;
        let rows = if rank < dynamics.constraint_bias.len() {
            PivotedLdl::with_rank(&row_products(&dynamics.constraint_jacobian), rank).independent().to_vec()
        } else {
            (0..rank).collect()
        };
        let (n, m) = (stiffness.columns(), rows.len());
        let jacobian = &chosen(&dynamics.constraint_jacobian, &rows);
        let mut inertia = dynamics.mass_matrix.clone();
        for i in 0..n {
            for j in 0..n {
                inertia[i][j] += g * (damping[i][j] + g * stiffness[i][j]);
            }
        }
        let mut loops = jacobian.clone();
        for (k, &row) in rows.iter().enumerate() {
            for j in 0..n {
                loops[k][j] += g * (constraint_damping[row][j] + g * constraint_stiffness[row][j]);
            }
        }
        let scale = (0..n).fold(0.0, |most: f64, i| most.max(inertia[i][i].abs()));
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let weight = |k: usize| {
            let size = dot(&jacobian[k], &jacobian[k]);
            if size > 0.0 { scale / size } else { 0.0 }
        };
        let weights: Vec<f64> = (0..m).map(weight).collect();
        for k in 0..m {
            for i in 0..n {
                for j in 0..n {
                    inertia[i][j] += weights[k] * jacobian[k][i] * loops[k][j];
                }
            }
        }
        let inertia = Lu::new(inertia);
        let inv_ct: Vec<Vec<f64>> = (0..m).map(|k| inertia.solve(&jacobian[k])).collect();
        let schur = Lu::new(Matrix::from_fn(m, m, |k, l| dot(&inv_ct[l], &loops[k])));
        let is_solvable = inertia.is_regular && schur.is_regular;
        is_solvable.then_some(Self { dynamics, linearization, g, loops, rows, weights, inertia, inv_ct, schur })
    }

    /// The increment `(u, w)` of coordinates and rates for `v`, `r` and a multiple of the derivative with respect to
    /// time.
    fn increment(&self, v: &[f64], r: &[f64], by_time: f64) -> (Vec<f64>, Vec<f64>) {
        let (g, jacobian) = (self.g, &self.dynamics.constraint_jacobian);
        let (n, m) = (v.len(), self.weights.len());
        let closing: Vec<f64> = self
            .rows
            .iter()
            .map(|&k| {
                let forcing = by_time * self.linearization.constraint_forcing[k];
                g * (dot(&jacobian[k], r) - g * dot(&self.linearization.constraint_stiffness[k], v) + forcing)
            })
            .collect();
        let mut right: Vec<f64> = (0..n)
            .map(|i| {
                let forcing = by_time * self.linearization.forcing[i];
                g * (dot(&self.dynamics.mass_matrix[i], r) - g * dot(&self.linearization.stiffness[i], v) + forcing)
            })
            .collect();
        for k in 0..m {
            for i in 0..n {
                right[i] += self.weights[k] * jacobian[self.rows[k]][i] * closing[k];
            }
        }
        let mut w = self.inertia.solve(&right);
        let open: Vec<f64> = (0..m).map(|k| dot(&self.loops[k], &w) - closing[k]).collect();
        let multipliers = self.schur.solve(&open);
        for k in 0..m {
            for i in 0..n {
                w[i] -= self.inv_ct[k][i] * multipliers[k];
            }
        }
        ((0..n).map(|i| g * (w[i] + v[i])).collect(), w)
    }
}

/// Selects rows of a matrix.
fn chosen(matrix: &Matrix, rows: &[usize]) -> Matrix {
    Matrix::from_fn(rows.len(), matrix.columns(), |k, j| matrix[rows[k]][j])
}
