//! A step on dual numbers at positions that a kernel does not suit: values by the plain functions and solves that notice what stands in
//! their way, derivatives by those of the equations that the values fulfil.

use num_dual::Dual64;
use qrm_core::{Angles, Closure, Dual, Dynamics, Kernel, Mechanism, State};

use super::{Number, constant};
use crate::acceleration::by_plain_functions;
use crate::linear::{Matrix, Vector};
use crate::motion::{Breakdown, Method};
use crate::projection::project;
use crate::solve::{Care, accelerations};

/// One step of length `h` from `t`; `None` where values have to be found by means that have no derivatives.
///
/// # Errors
/// The step could not be made.
pub(super) fn step<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    kernel: &X::Kernel<Number>,
    t: Number,
    h: Number,
    from: &State<Number, N, M>,
) -> Result<Option<State<Number, N, M>>, Breakdown> {
    let mut careful = Careful { mechanism, kernel, care: Care::default() };
    let made = careful.step(t, h, from)?;
    // What was bridged or left open by dependent constraints is no solution of the equations.
    let is_sound = careful.care.suspicious_constraints == 0 && careful.care.dependent_constraints == 0;
    Ok(made.filter(|_| is_sound))
}

/// Accelerations and multipliers.
type Accelerations<const N: usize, const M: usize> = ([Number; N], [Number; M]);

struct Careful<'a, X: Mechanism<N, M>, const N: usize, const M: usize> {
    mechanism: &'a X,
    kernel: &'a X::Kernel<Number>,
    care: Care,
}

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Careful<'_, X, N, M> {
    fn step(
        &mut self,
        t: Number,
        h: Number,
        from: &State<Number, N, M>,
    ) -> Result<Option<State<Number, N, M>>, Breakdown> {
        let half = constant(0.5) * h;
        let mut slopes = [(from.qd, from.qdd); 4];
        for (stage, part) in [(1, half), (2, half), (3, h)] {
            let (v, a) = slopes[stage - 1];
            let (q, qd) = (along(&from.q, part, &v), along(&from.qd, part, &a));
            let Some((qdd, _)) = self.accelerations(t + part, &q, &qd)? else { return Ok(None) };
            slopes[stage] = (qd, qdd);
        }
        let [(v1, a1), (v2, a2), (v3, a3), (v4, a4)] = slopes;
        let mean = |k: [[Number; N]; 4]| -> [Number; N] {
            std::array::from_fn(|i| (k[0][i] + constant(2.0) * (k[1][i] + k[2][i]) + k[3][i]) / constant(6.0))
        };
        let mut q = along(&from.q, h, &mean([v1, v2, v3, v4]));
        let mut qd = along(&from.qd, h, &mean([a1, a2, a3, a4]));
        let end = t + h;
        if self.close(end, &mut q, &mut qd)?.is_none() {
            return Ok(None);
        }
        let Some((qdd, multipliers)) = self.accelerations(end, &q, &qd)? else { return Ok(None) };
        let angles = Angles::new(&q, X::Kernel::<Number>::IS_ANGLE);
        Ok(Some(State { q, qd, qdd, multipliers, angles }))
    }

    /// With `qdd` and `lambda` held, what changes in `Mbar qdd + C_q' lambda - fbar` and in `C_q qdd + bias` is what their own changes make up for.
    fn accelerations(
        &mut self,
        t: Number,
        q: &[Number; N],
        qd: &[Number; N],
    ) -> Result<Option<Accelerations<N, M>>, Breakdown> {
        let Some(changing) = self.kernel.plain_dynamics(t, q, qd) else { return Ok(None) };
        let found = by_plain_functions(self.mechanism, t.0.re, &values(q), &values(qd), &mut self.care)?;
        let (qdd, lambda) = (found.qdd.map(constant), found.multipliers.map(constant));
        let mut forces = changing.generalized_forces;
        let mut bias = changing.constraint_bias;
        for i in 0..N {
            for j in 0..N {
                forces[i] = forces[i] - changing.mass_matrix[i][j] * qdd[j];
            }
            for k in 0..M {
                forces[i] = forces[i] - changing.constraint_jacobian[k][i] * lambda[k];
                bias[k] = bias[k] + changing.constraint_jacobian[k][i] * qdd[i];
            }
        }
        let change = Dynamics {
            mass_matrix: matrix(&changing.mass_matrix),
            generalized_forces: derivatives(&forces),
            constraint_jacobian: matrix(&changing.constraint_jacobian),
            constraint_bias: derivatives(&bias),
        };
        let change = accelerations(&change, &mut self.care)?;
        Ok(Some((joined(&found.qdd, &change.qdd), joined(&found.multipliers, &change.multipliers))))
    }

    /// Puts values onto the constraints, and derivatives onto theirs, both by the smallest change in the metric of the mass matrix.
    fn close(&mut self, t: Number, q: &mut [Number; N], qd: &mut [Number; N]) -> Result<Option<()>, Breakdown> {
        let (mut position, mut rates) = (values(q), values(qd));
        let Method { projection, tolerance, .. } = Method::default();
        let mass = self.mechanism.mass_matrix(&position);
        let factors = crate::linear::Ldl::new(&mass);
        project(
            self.mechanism,
            (projection, tolerance),
            factors.as_ref(),
            t.0.re,
            &mut position,
            &mut rates,
            &mut self.care,
        )?;
        *q = joined(&position, &derivatives(q));
        *qd = joined(&rates, &derivatives(qd));
        let Some(open) = self.kernel.plain_closure(t, q) else { return Ok(None) };
        let moved = self.smallest(&mass, &open, &derivatives(&open.constraints))?;
        *q = joined(&position, &std::array::from_fn(|i| q[i].0.eps + moved[i]));
        let Some(open) = self.kernel.plain_closure(t, q) else { return Ok(None) };
        let mut drift = open.constraint_rate;
        for k in 0..M {
            for i in 0..N {
                drift[k] = drift[k] + open.constraint_jacobian[k][i] * qd[i];
            }
        }
        let moved = self.smallest(&mass, &open, &derivatives(&drift))?;
        *qd = joined(&rates, &std::array::from_fn(|i| qd[i].0.eps + moved[i]));
        Ok(Some(()))
    }

    /// The smallest change with `C_q dx = -open`.
    fn smallest(
        &mut self,
        mass: &Matrix<N, N>,
        closure: &Closure<Number, N, M>,
        open: &Vector<M>,
    ) -> Result<Vector<N>, Breakdown> {
        let change = Dynamics {
            mass_matrix: *mass,
            generalized_forces: [0.0; N],
            constraint_jacobian: matrix(&closure.constraint_jacobian),
            constraint_bias: *open,
        };
        Ok(accelerations(&change, &mut self.care)?.qdd)
    }
}

fn along<const N: usize>(x: &[Number; N], h: Number, v: &[Number; N]) -> [Number; N] {
    std::array::from_fn(|i| x[i] + h * v[i])
}

fn values<const K: usize>(numbers: &[Number; K]) -> Vector<K> {
    numbers.map(|number| number.0.re)
}

fn derivatives<const K: usize>(numbers: &[Number; K]) -> Vector<K> {
    numbers.map(|number| number.0.eps)
}

fn matrix<const K: usize, const L: usize>(numbers: &[[Number; L]; K]) -> Matrix<K, L> {
    std::array::from_fn(|i| values(&numbers[i]))
}

fn joined<const K: usize>(values: &Vector<K>, derivatives: &Vector<K>) -> [Number; K] {
    std::array::from_fn(|i| Dual(Dual64::new(values[i], derivatives[i])))
}
