//! Steps by a linearly implicit method, for stiff springs and dampers.

use qrm_core::{Dynamics, Linearization, Mechanism};

use super::rodas::{ARGUMENTS, BY_TIME, GAMMA, INCREMENTS, NODES};
use super::{Formula, Task, Work, corrected, end, scales};
use crate::acceleration;
use crate::linear::lu::Lu;
use crate::linear::{Ldl, Matrix, Vector, dot, multiply};
use crate::motion::{Breakdown, Moment};

/// RODAS on coordinates and rates, with the exact Jacobian of the accelerations: of the equations
/// `Mbar a + C_q' lambda = fbar`, `C_q a = -bias` it needs the derivatives alone, never those of their solution.
#[derive(Clone, Copy, Debug)]
pub struct Implicit;

impl<const N: usize, const M: usize> Formula<N, M> for Implicit {
    fn new() -> Self {
        Self
    }

    fn order(&self) -> i32 {
        4
    }

    fn memory(&self) -> f64 {
        0.0
    }

    fn attempt<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        from: &Moment<N, M>,
        h: f64,
        task: &Task,
        work: &mut Work,
    ) -> Result<(Moment<N, M>, f64), Breakdown> {
        let Some(linearization) = mechanism.linearization(from.t, &from.q, &from.qd, &from.qdd, &from.multipliers)
        else {
            return Err(Breakdown::NoLinearization);
        };
        let dynamics = mechanism.dynamics(from.t, &from.q, &from.qd);
        let system = System::new(&dynamics, &linearization, h * GAMMA).ok_or(Breakdown::NotFinite)?;
        let mut increments = [([0.0; N], [0.0; N]); 6];
        let (mut q, mut qd) = (from.q, from.qd);
        for stage in 0..6 {
            (q, qd) = (from.q, from.qd);
            let (mut along, mut change) = ([0.0; N], [0.0; N]);
            for (j, (u, w)) in increments.iter().enumerate().take(stage) {
                let (of_argument, of_increment) = (ARGUMENTS[stage][j], INCREMENTS[stage][j] / h);
                for i in 0..N {
                    q[i] += of_argument * u[i];
                    qd[i] += of_argument * w[i];
                    along[i] += of_increment * u[i];
                    change[i] += of_increment * w[i];
                }
            }
            let t = from.t + NODES[stage] * h;
            let qdd = if stage == 0 { from.qdd } else { evaluate(mechanism, t, &q, &qd, work)? };
            let along = std::array::from_fn(|i| along[i] + qd[i]);
            let change = std::array::from_fn(|i| change[i] + qdd[i]);
            increments[stage] = system.increment(&along, &change, BY_TIME[stage] * h);
        }
        // The last increment ends the step, and is the estimate of its error.
        let (u, w) = &increments[5];
        let (q, qd) = (std::array::from_fn(|i| q[i] + u[i]), std::array::from_fn(|i| qd[i] + w[i]));
        let mut sum = 0.0;
        for i in 0..N {
            let [of_q, of_qd] = scales::<X, N, M>(task.tolerance, i, from, &q, &qd);
            sum += (u[i] / of_q).powi(2) + (w[i] / of_qd).powi(2);
        }
        let error = (sum / (2.0 * N as f64)).sqrt();
        if !(error <= 1.0) {
            return Ok((*from, error));
        }
        let mass = Ldl::new(&mechanism.mass_matrix(&q));
        *work.evaluations += 1;
        Ok((corrected(mechanism, end(from.t, h, task), (q, qd), mass, task.projection, work.care)?, error))
    }
}

#[inline(never)]
fn evaluate<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    t: f64,
    q: &Vector<N>,
    qd: &Vector<N>,
    work: &mut Work,
) -> Result<Vector<N>, Breakdown> {
    *work.evaluations += 1;
    Ok(acceleration::evaluate(mechanism, t, q, qd, work.care)?.0)
}

/// The linear equations of all stages of a step, with `g = h gamma`:
///
/// ```text
/// | Mbar + g D + g^2 K     C_q' | | w  |     | Mbar r - g K v + d f_t  |
/// | C_q + g D_c + g^2 K_c  0    | | mu | = g | C_q r - g K_c v + d c_t |
/// ```
struct System<'a, const N: usize, const M: usize> {
    dynamics: &'a Dynamics<f64, N, M>,
    linearization: &'a Linearization<f64, N, M>,
    g: f64,
    /// The lower left part.
    loops: Matrix<M, N>,
    /// By how much each loop is added to the equations above it, which changes no solution and carries massless coordinates.
    weights: Vector<M>,
    inertia: Lu<N>,
    /// `inertia^-1 C_q'`, a row for each constraint.
    pull: Matrix<M, N>,
    schur: Lu<M>,
}

impl<'a, const N: usize, const M: usize> System<'a, N, M> {
    /// `None` if the equations are singular.
    fn new(dynamics: &'a Dynamics<f64, N, M>, linearization: &'a Linearization<f64, N, M>, g: f64) -> Option<Self> {
        let Linearization { stiffness, damping, constraint_stiffness, constraint_damping, .. } = linearization;
        let jacobian = &dynamics.constraint_jacobian;
        let mut inertia = dynamics.mass_matrix;
        for i in 0..N {
            for j in 0..N {
                inertia[i][j] += g * (damping[i][j] + g * stiffness[i][j]);
            }
        }
        let mut loops = *jacobian;
        for k in 0..M {
            for j in 0..N {
                loops[k][j] += g * (constraint_damping[k][j] + g * constraint_stiffness[k][j]);
            }
        }
        let scale = (0..N).fold(0.0, |most: f64, i| most.max(inertia[i][i].abs()));
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let weights = std::array::from_fn(|k| {
            let size = dot(&jacobian[k], &jacobian[k]);
            if size > 0.0 { scale / size } else { 0.0 }
        });
        for k in 0..M {
            for i in 0..N {
                for j in 0..N {
                    inertia[i][j] += weights[k] * jacobian[k][i] * loops[k][j];
                }
            }
        }
        let inertia = Lu::new(&inertia);
        let pull: Matrix<M, N> = std::array::from_fn(|k| inertia.solve(&jacobian[k]));
        let schur = Lu::new(&std::array::from_fn(|k| multiply(&pull, &loops[k])));
        let is_regular = |determinant: f64| determinant.is_finite() && determinant != 0.0;
        let is_solvable = is_regular(inertia.determinant) && (M == 0 || is_regular(schur.determinant));
        is_solvable.then_some(Self { dynamics, linearization, g, loops, weights, inertia, pull, schur })
    }

    /// The increment `(u, w)` of coordinates and rates for `v`, `r` and a part of the derivative by time.
    fn increment(&self, v: &Vector<N>, r: &Vector<N>, by_time: f64) -> (Vector<N>, Vector<N>) {
        let (g, jacobian) = (self.g, &self.dynamics.constraint_jacobian);
        let closing: Vector<M> = std::array::from_fn(|k| {
            let forcing = by_time * self.linearization.constraint_forcing[k];
            g * (dot(&jacobian[k], r) - g * dot(&self.linearization.constraint_stiffness[k], v) + forcing)
        });
        let mut right: Vector<N> = std::array::from_fn(|i| {
            let forcing = by_time * self.linearization.forcing[i];
            g * (dot(&self.dynamics.mass_matrix[i], r) - g * dot(&self.linearization.stiffness[i], v) + forcing)
        });
        for k in 0..M {
            for i in 0..N {
                right[i] += self.weights[k] * jacobian[k][i] * closing[k];
            }
        }
        let mut w = self.inertia.solve(&right);
        let open: Vector<M> = std::array::from_fn(|k| dot(&self.loops[k], &w) - closing[k]);
        let multipliers = self.schur.solve(&open);
        for k in 0..M {
            for i in 0..N {
                w[i] -= self.pull[k][i] * multipliers[k];
            }
        }
        (std::array::from_fn(|i| g * (w[i] + v[i])), w)
    }
}
