//! The classical Runge-Kutta step of order 4 by a kernel, with the projection of coordinates and rates onto the
//! constraints.

use crate::angles::Angles;
use crate::kernel::Kernel;
use crate::kernel_state::{KernelState, StepResult};
use crate::scalar::Scalar;
use crate::step_end::{StepEnd, finish, has_constraints};
use crate::vectors::{along, scaled, sum};

/// One step of length `h` from time `t`, projected onto the constraints in the mass metric.
///
/// The work is bounded: at most five evaluations of the accelerations and four corrections of the coordinates.
#[inline(always)]
pub fn rk4_step<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    h: R,
    from: &KernelState<R, N, M>,
) -> StepResult<R, K::Position, N, M> {
    if const { K::OPERATIONS > R::INLINE_LIMIT } { looped(kernel, t, h, from) } else { unrolled(kernel, t, h, from) }
}

/// The step as straight-line code.
#[inline(always)]
fn unrolled<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    h: R,
    from: &KernelState<R, N, M>,
) -> StepResult<R, K::Position, N, M> {
    let half = R::from_f64(0.5) * h;
    let (v2, a2, _, first) = stage(kernel, t, from, half, (&from.qd, &from.qdd));
    let (v3, a3, _, second) = stage(kernel, t, from, half, (&v2, &a2));
    let (v4, a4, near, last) = stage(kernel, t, from, h, (&v3, &a3));
    let growth = kernel.growth_factor(&last).max(kernel.growth_factor(&second).max(kernel.growth_factor(&first)));
    let mut end = StepEnd::new(kernel, from, h, [&v2, &v3, &v4], [&a2, &a3, &a4], &near);
    if has_constraints(kernel) {
        let open = kernel.residuals(&kernel.position(t + h, &end.q, &end.angles));
        end.project_coordinates_first(kernel, from, &kernel.correction(&last, &open));
    }
    let position = loop {
        let position = kernel.position(t + h, &end.q, &end.angles);
        if !end.project_coordinates::<K, M>(kernel, &position) {
            break position;
        }
    };
    end.project_rates(kernel, &position);
    let (qdd, multipliers) = kernel.accelerations(&position, t + h, &end.q, &end.qd, &end.angles);
    let growth = kernel.growth_factor(&position).max(growth);
    finish(kernel, end, (qdd, multipliers), position, growth)
}

/// The step as a loop over its stages with a single copy of the equations of motion: large kernels compile in a
/// fraction of the time.
#[inline(always)]
fn looped<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    h: R,
    from: &KernelState<R, N, M>,
) -> StepResult<R, K::Position, N, M> {
    let half = R::from_f64(0.5) * h;
    let mut slopes = [(from.qd, from.qdd); 4];
    let mut growth = R::zero();
    let mut end = StepEnd { q: from.q, qd: from.qd, increment: from.q, angles: from.angles, corrections: 0 };
    let mut last: Option<K::Position> = None;
    let mut pass = 1;
    loop {
        if pass < 4 {
            let part = if pass == 3 { h } else { half };
            // Every index is in range. `get` keeps panics out of the code where the loop is not unrolled.
            let (v, a) = slopes.get(pass - 1).copied().unwrap_or(slopes[0]);
            let dq = scaled(part, &v);
            end.q = sum(&from.q, &dq);
            end.qd = along(&from.qd, part, &a);
            end.angles = from.angles.rotated_small(&end.q, &dq, kernel.has_angle());
        }
        let at = if pass < 3 { t + half } else { t + h };
        let position = kernel.position(at, &end.q, &end.angles);
        if pass == 4 {
            pass = 5;
            if has_constraints(kernel)
                && let Some(last) = &last
            {
                let correction = kernel.correction(last, &kernel.residuals(&position));
                end.project_coordinates_first(kernel, from, &correction);
                continue;
            }
        }
        if pass == 5 {
            if end.project_coordinates::<K, M>(kernel, &position) {
                continue;
            }
            end.project_rates(kernel, &position);
        }
        growth = kernel.growth_factor(&position).max(growth);
        let (qdd, multipliers) = kernel.accelerations(&position, at, &end.q, &end.qd, &end.angles);
        if pass == 5 {
            return finish(kernel, end, (qdd, multipliers), position, growth);
        }
        if let Some(slope) = slopes.get_mut(pass) {
            *slope = (end.qd, qdd);
        }
        last = Some(position);
        pass += 1;
        if pass == 4 {
            let [_, (v2, a2), (v3, a3), (v4, a4)] = slopes;
            end = StepEnd::new(kernel, from, h, [&v2, &v3, &v4], [&a2, &a3, &a4], &end.angles);
        }
    }
}

impl<R: Scalar, const N: usize> StepEnd<R, N> {
    /// Computes the end by the Runge-Kutta formula; `near` are the angles at its last stage.
    #[inline(always)]
    fn new<K: Kernel<R, N, M>, const M: usize>(
        kernel: &K,
        from: &KernelState<R, N, M>,
        h: R,
        v: [&[R; N]; 3],
        a: [&[R; N]; 3],
        near: &Angles<R, N>,
    ) -> Self {
        let sixth = h / R::from_f64(6.0);
        let increment = mean(sixth, [&from.qd, v[0], v[1], v[2]]);
        let qd = sum(&from.qd, &mean(sixth, [&from.qdd, a[0], a[1], a[2]]));
        let q = sum(&from.q, &increment);
        let angles = near.rotated_tiny(&q, &along(&increment, -h, v[1]), kernel.has_angle());
        Self { q, qd, increment, angles, corrections: 0 }
    }
}

/// Computes rates, accelerations, angles and position at a stage, the fraction `part` of the step away from its
/// beginning along `v` and `a`.
#[inline(always)]
fn stage<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    from: &KernelState<R, N, M>,
    part: R,
    (v, a): (&[R; N], &[R; N]),
) -> ([R; N], [R; N], Angles<R, N>, K::Position) {
    let (dq, qd) = (scaled(part, v), along(&from.qd, part, a));
    let q = sum(&from.q, &dq);
    let angles = from.angles.rotated_small(&q, &dq, kernel.has_angle());
    let position = kernel.position(t + part, &q, &angles);
    let qdd = kernel.stage_accelerations(&position, t + part, &q, &qd, &angles);
    (qd, qdd, angles, position)
}

/// `h/6 (k1 + 2 k2 + 2 k3 + k4)`
#[inline(always)]
fn mean<R: Scalar, const N: usize>(sixth: R, k: [&[R; N]; 4]) -> [R; N] {
    let mut mean = *k[0];
    for i in 0..N {
        mean[i] = sixth * (R::from_f64(2.0).mul_add(k[1][i] + k[2][i], k[0][i]) + k[3][i]);
    }
    mean
}
