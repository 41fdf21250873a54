//! The classical Runge-Kutta step of order 4 by a kernel, with the projection of coordinates and rates onto the
//! constraints.
//!
//! The states at both ends of a step, and the projection between them, serve the step of DOP853 too.

use crate::angles::Angles;
use crate::kernel::{Kernel, MAX_GROWTH};
use crate::scalar::Scalar;

/// A state, with what a step needs at its beginning.
#[derive(Clone, Copy, Debug)]
pub struct KernelState<R, const N: usize, const M: usize> {
    /// Coordinates, in rad or m.
    pub q: [R; N],
    /// Rates.
    pub qd: [R; N],
    /// Accelerations.
    pub qdd: [R; N],
    /// Multipliers.
    pub multipliers: [R; M],
    /// Sines and cosines of `q`.
    pub angles: Angles<R, N>,
}

impl<R: Scalar, const N: usize, const M: usize> KernelState<R, N, M> {
    /// The state at time `t` with these coordinates and rates, which fulfil the constraints.
    #[inline]
    pub fn new<K: Kernel<R, N, M>>(kernel: &K, t: R, q: [R; N], qd: [R; N]) -> Self {
        let angles = Angles::new(&q, kernel.has_angle());
        let position = kernel.position(t, &q, &angles);
        let (qdd, multipliers) = kernel.accelerations(&position, t, &q, &qd, &angles);
        Self { q, qd, qdd, multipliers, angles }
    }

    /// This state, or another one number by number, as a function chooses from the other's number and this one's.
    #[cfg(feature = "simd")]
    #[inline(always)]
    pub(crate) fn replaced(&self, other: &Self, choose: impl Fn(R, R) -> R) -> Self {
        let mut state = *self;
        for i in 0..N {
            state.q[i] = choose(other.q[i], self.q[i]);
            state.qd[i] = choose(other.qd[i], self.qd[i]);
            state.qdd[i] = choose(other.qdd[i], self.qdd[i]);
            state.angles.sin[i] = choose(other.angles.sin[i], self.angles.sin[i]);
            state.angles.cos[i] = choose(other.angles.cos[i], self.angles.cos[i]);
        }
        for k in 0..M {
            state.multipliers[k] = choose(other.multipliers[k], self.multipliers[k]);
        }
        state
    }

    /// Zero, but not a number (in some lane) where one of the state's is not finite.
    #[inline(always)]
    pub fn finite_check(&self) -> R {
        // Accelerations and multipliers depend on all the others. Zero times a number that is not finite is not a
        // number.
        let mut sum = R::zero();
        for i in 0..N {
            sum = sum + self.qdd[i];
        }
        for k in 0..M {
            sum = sum + self.multipliers[k];
        }
        sum * R::zero()
    }
}

/// The end of a step, with what is known of the way there.
#[derive(Clone, Copy, Debug)]
pub struct StepResult<R, P, const N: usize, const M: usize> {
    /// The state there.
    pub end: KernelState<R, N, M>,
    /// The quantities that follow from the position at the end.
    pub position: P,
    /// Largest growth of rounding errors at any stage: see [`Kernel::growth_factor`].
    pub growth_factor: R,
    /// Largest residual of a constraint at the end, in its unit.
    pub residual: R,
    /// How often the coordinates were corrected, 4 times at most.
    pub corrections: u32,
}

impl<R: Scalar, P, const N: usize, const M: usize> StepResult<R, P, N, M> {
    /// Whether the step can be relied on: all numbers are finite, no residual is larger than `tolerance`, and the
    /// kernel suits the position.
    #[inline(always)]
    pub fn is_good(&self, tolerance: f64) -> bool {
        self.growth_factor.is_within(MAX_GROWTH)
            && self.residual.is_within(tolerance)
            && self.end.finite_check().is_within(0.0)
    }
}

/// Residuals up to this size, in the unit of a constraint, are rounding errors.
pub const RESIDUAL_ROUNDING: f64 = 4e-16;
/// Corrections up to this size, in rad or m, are rounding errors.
pub const CORRECTION_ROUNDING: f64 = 1e-15;
/// Most corrections; a step that needs more is left to the robust method.
pub const MAX_CORRECTIONS: u32 = 4;

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

/// The result of a step.
#[inline(always)]
pub(crate) fn finish<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    end: StepEnd<R, N>,
    (qdd, multipliers): ([R; N], [R; M]),
    position: K::Position,
    growth: R,
) -> StepResult<R, K::Position, N, M> {
    let residual = largest(&kernel.residuals(&position));
    // Fresh sines and cosines: rounding errors of rotations made one after another would add up.
    let angles = Angles::new(&end.q, kernel.has_angle());
    let state = KernelState { q: end.q, qd: end.qd, qdd, multipliers, angles };
    StepResult { end: state, position, growth_factor: growth, residual, corrections: end.corrections }
}

/// The step as a loop over its stages, with the equations of motion in one place: large kernels compile in a fraction
/// of the time.
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
            // Every index is within; where the loop is not unrolled, only this way no panic can be reached.
            let (v, a) = slopes.get(pass - 1).copied().unwrap_or(slopes[0]);
            let dq = scaled(part, &v);
            end.q = sum(&from.q, &dq);
            end.qd = along(&from.qd, part, &a);
            end.angles = from.angles.turned(&end.q, &dq, kernel.has_angle());
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

/// The end of a step while it is projected onto the constraints.
pub(crate) struct StepEnd<R, const N: usize> {
    pub(crate) q: [R; N],
    pub(crate) qd: [R; N],
    /// The change of the coordinates in the step, before the projection.
    pub(crate) increment: [R; N],
    pub(crate) angles: Angles<R, N>,
    pub(crate) corrections: u32,
}

impl<R: Scalar, const N: usize> StepEnd<R, N> {
    /// The end by the Runge-Kutta formula; `near` are the angles at its last stage.
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
        let angles = near.nudged(&q, &along(&increment, -h, v[1]), kernel.has_angle());
        Self { q, qd, increment, angles, corrections: 0 }
    }

    /// The first correction, by Jacobian and mass matrix of the last stage, which lies near enough.
    #[inline(always)]
    pub(crate) fn project_coordinates_first<K: Kernel<R, N, M>, const M: usize>(
        &mut self,
        kernel: &K,
        from: &KernelState<R, N, M>,
        correction: &[R; N],
    ) {
        self.q = sum(&from.q, &sum(&self.increment, correction));
        // The correction as the coordinates took it up, rounding included.
        let moved = difference(&difference(&self.q, &from.q), &self.increment);
        self.angles = self.angles.corrected(&self.q, &moved, kernel.has_angle());
        self.corrections = 1;
    }

    /// Makes another correction of the coordinates and returns true, unless none is needed.
    #[inline(always)]
    pub(crate) fn project_coordinates<K: Kernel<R, N, M>, const M: usize>(
        &mut self,
        kernel: &K,
        position: &K::Position,
    ) -> bool {
        if !has_constraints(kernel) || self.corrections == MAX_CORRECTIONS {
            return false;
        }
        let open = kernel.residuals(position);
        let residual = largest(&open);
        if residual.is_within(RESIDUAL_ROUNDING) {
            return false;
        }
        let correction = kernel.correction(position, &open);
        // Lanes without a residual stay as they are, whatever others need.
        let size = residual.choose(RESIDUAL_ROUNDING, R::zero(), largest(&correction));
        if size.is_within(CORRECTION_ROUNDING) {
            return false;
        }
        for i in 0..N {
            self.q[i] = self.q[i] + size.choose(CORRECTION_ROUNDING, R::zero(), correction[i]);
        }
        self.angles = self.angles.refreshed(&self.q, size, CORRECTION_ROUNDING, kernel.has_angle());
        self.corrections += 1;
        true
    }

    /// Projects the rates onto the tangent space of the constraints.
    #[inline(always)]
    pub(crate) fn project_rates<K: Kernel<R, N, M>, const M: usize>(&mut self, kernel: &K, position: &K::Position) {
        if has_constraints(kernel) {
            self.qd = sum(&self.qd, &kernel.correction(position, &kernel.velocity_residual(position, &self.qd)));
        }
    }
}

/// Whether there is anything to project onto.
#[inline(always)]
pub(crate) fn has_constraints<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(kernel: &K) -> bool {
    let [_, m] = kernel.sizes();
    m > 0
}

/// Rates, accelerations, angles and position at a stage: `part` of the step away from its beginning, along `v` and `a`.
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
    let angles = from.angles.turned(&q, &dq, kernel.has_angle());
    let position = kernel.position(t + part, &q, &angles);
    let (qdd, _) = kernel.accelerations(&position, t + part, &q, &qd, &angles);
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

/// `x + h v`
#[inline(always)]
pub(crate) fn along<R: Scalar, const N: usize>(x: &[R; N], h: R, v: &[R; N]) -> [R; N] {
    let mut end = *x;
    for i in 0..N {
        end[i] = h.mul_add(v[i], x[i]);
    }
    end
}

#[inline(always)]
pub(crate) fn scaled<R: Scalar, const N: usize>(h: R, v: &[R; N]) -> [R; N] {
    let mut scaled = *v;
    for i in 0..N {
        scaled[i] = h * v[i];
    }
    scaled
}

#[inline(always)]
pub(crate) fn sum<R: Scalar, const N: usize>(x: &[R; N], y: &[R; N]) -> [R; N] {
    let mut sum = *x;
    for i in 0..N {
        sum[i] = x[i] + y[i];
    }
    sum
}

#[inline(always)]
pub(crate) fn difference<R: Scalar, const N: usize>(x: &[R; N], y: &[R; N]) -> [R; N] {
    let mut difference = *x;
    for i in 0..N {
        difference[i] = x[i] - y[i];
    }
    difference
}

#[inline(always)]
pub(crate) fn largest<R: Scalar, const N: usize>(x: &[R; N]) -> R {
    let mut largest = R::zero();
    for i in 0..N {
        largest = x[i].abs().max(largest);
    }
    largest
}
