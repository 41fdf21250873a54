//! A whole step by a mechanism's kernel: the classical formula, correction of coordinates and rates in the metric of the mass
//! matrix, accelerations and multipliers at the end. Written for any kind of number, so that lanes make several steps at once.

use crate::angles::Angles;
use crate::kernel::{Kernel, MOST_STRAIN};
use crate::scalar::Scalar;

/// A state with what a step needs at its beginning.
#[derive(Clone, Copy, Debug)]
pub struct State<R, const N: usize, const M: usize> {
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

impl<R: Scalar, const N: usize, const M: usize> State<R, N, M> {
    /// The state at time `t` with these coordinates and rates, which fulfil the constraints.
    #[inline]
    pub fn new<K: Kernel<R, N, M>>(kernel: &K, t: R, q: [R; N], qd: [R; N]) -> Self {
        let angles = Angles::new(&q, K::IS_ANGLE);
        let position = kernel.position(t, &q, &angles);
        let (qdd, multipliers) = kernel.accelerations(&position, t, &q, &qd, &angles);
        Self { q, qd, qdd, multipliers, angles }
    }

    /// Zero, but not a number (in some lane) where one of the state's is not finite.
    #[inline(always)]
    pub fn checksum(&self) -> R {
        // Accelerations and multipliers depend on all the others. Zero times a number that is not finite is not a number.
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

/// The end of a step, and how it was reached.
#[derive(Clone, Copy, Debug)]
pub struct Stride<R, P, const N: usize, const M: usize> {
    /// The state there.
    pub end: State<R, N, M>,
    /// What follows from the position there.
    pub position: P,
    /// Largest growth of rounding errors: see [`Kernel::strain`].
    pub strain: R,
    /// Largest residual of a constraint at the end, in its unit.
    pub residual: R,
    /// How often the coordinates were corrected, 4 times at most.
    pub corrections: u32,
}

impl<R: Scalar, P, const N: usize, const M: usize> Stride<R, P, N, M> {
    /// Whether the step can be relied on: all numbers are finite, no residual is larger than `tolerance`, and the kernel suits
    /// the position.
    #[inline(always)]
    pub fn is_good(&self, tolerance: f64) -> bool {
        self.strain.is_within(MOST_STRAIN) && self.residual.is_within(tolerance) && self.end.checksum().is_within(0.0)
    }
}

/// Residuals up to this size, in the unit of a constraint, are rounding errors.
const CLOSED: f64 = 4e-16;
/// Corrections up to this size, in rad or m, are rounding errors.
const ROUNDING: f64 = 1e-15;
/// Most corrections; what takes more is left to the careful way.
const MOST: u32 = 4;

/// Steps hold kernels of more operations once only, and are compiled for fewer processors.
pub const LARGE: usize = 600;

/// One step of length `h` that begins at `t`. The work it takes is bounded: at most five times accelerations, and four
/// corrections.
#[inline(always)]
pub fn stride<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    h: R,
    from: &State<R, N, M>,
) -> Stride<R, K::Position, N, M> {
    if K::OPERATIONS > LARGE { looped(kernel, t, h, from) } else { unrolled(kernel, t, h, from) }
}

/// The step as one stretch of code, in which the processor finds most to do at once.
#[inline(always)]
fn unrolled<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    h: R,
    from: &State<R, N, M>,
) -> Stride<R, K::Position, N, M> {
    let half = R::from_f64(0.5) * h;
    let (v2, a2, _, first) = stage(kernel, t, from, half, (&from.qd, &from.qdd));
    let (v3, a3, _, second) = stage(kernel, t, from, half, (&v2, &a2));
    let (v4, a4, near, last) = stage(kernel, t, from, h, (&v3, &a3));
    let strain = kernel.strain(&last).max(kernel.strain(&second).max(kernel.strain(&first)));
    let mut end = End::new::<K, M>(from, h, [&v2, &v3, &v4], [&a2, &a3, &a4], &near);
    if M > 0 {
        let open = kernel.residuals(&kernel.position(t + h, &end.q, &end.angles));
        end.correct_first::<K, M>(from, &kernel.correction(&last, &open));
    }
    let position = loop {
        let position = kernel.position(t + h, &end.q, &end.angles);
        if !end.correct::<K, M>(kernel, &position) {
            break position;
        }
    };
    end.close_rates(kernel, &position);
    let (qdd, multipliers) = kernel.accelerations(&position, t + h, &end.q, &end.qd, &end.angles);
    let strain = kernel.strain(&position).max(strain);
    finish(kernel, end, (qdd, multipliers), position, strain)
}

/// What is known of a step when it is made.
#[inline(always)]
fn finish<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    end: End<R, N>,
    (qdd, multipliers): ([R; N], [R; M]),
    position: K::Position,
    strain: R,
) -> Stride<R, K::Position, N, M> {
    let residual = largest(&kernel.residuals(&position));
    // Nothing waits for these before the next step: turns made one after another would add up their rounding errors.
    let angles = Angles::new(&end.q, K::IS_ANGLE);
    let state = State { q: end.q, qd: end.qd, qdd, multipliers, angles };
    Stride { end: state, position, strain, residual, corrections: end.corrections }
}

/// The same with the equations of motion in one place, for mechanisms that would take too long to compile otherwise.
#[inline(always)]
fn looped<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    h: R,
    from: &State<R, N, M>,
) -> Stride<R, K::Position, N, M> {
    let half = R::from_f64(0.5) * h;
    let mut slopes = [(from.qd, from.qdd); 4];
    let mut strain = R::zero();
    let mut end = End { q: from.q, qd: from.qd, way: from.q, angles: from.angles, corrections: 0 };
    let mut last: Option<K::Position> = None;
    let mut pass = 1;
    loop {
        if pass < 4 {
            let part = if pass == 3 { h } else { half };
            let (v, a) = slopes[pass - 1];
            let dq = scaled(part, &v);
            end.q = sum(&from.q, &dq);
            end.qd = along(&from.qd, part, &a);
            end.angles = from.angles.turned(&end.q, &dq, K::IS_ANGLE);
        }
        let at = if pass < 3 { t + half } else { t + h };
        let position = kernel.position(at, &end.q, &end.angles);
        if pass == 4 {
            pass = 5;
            if M > 0
                && let Some(last) = &last
            {
                end.correct_first::<K, M>(from, &kernel.correction(last, &kernel.residuals(&position)));
                continue;
            }
        }
        if pass == 5 {
            if end.correct::<K, M>(kernel, &position) {
                continue;
            }
            end.close_rates(kernel, &position);
        }
        strain = kernel.strain(&position).max(strain);
        let (qdd, multipliers) = kernel.accelerations(&position, at, &end.q, &end.qd, &end.angles);
        if pass == 5 {
            return finish(kernel, end, (qdd, multipliers), position, strain);
        }
        slopes[pass] = (end.qd, qdd);
        last = Some(position);
        pass += 1;
        if pass == 4 {
            let [_, (v2, a2), (v3, a3), (v4, a4)] = slopes;
            end = End::new::<K, M>(from, h, [&v2, &v3, &v4], [&a2, &a3, &a4], &end.angles);
        }
    }
}

/// The end of a step on its way to the constraints.
struct End<R, const N: usize> {
    q: [R; N],
    qd: [R; N],
    /// From the beginning to the end, before it was corrected.
    way: [R; N],
    angles: Angles<R, N>,
    corrections: u32,
}

impl<R: Scalar, const N: usize> End<R, N> {
    /// Where the formula leads; `near` are the angles at its last stage.
    #[inline(always)]
    fn new<K: Kernel<R, N, M>, const M: usize>(
        from: &State<R, N, M>,
        h: R,
        v: [&[R; N]; 3],
        a: [&[R; N]; 3],
        near: &Angles<R, N>,
    ) -> Self {
        let sixth = h / R::from_f64(6.0);
        let way = mean(sixth, [&from.qd, v[0], v[1], v[2]]);
        let qd = sum(&from.qd, &mean(sixth, [&from.qdd, a[0], a[1], a[2]]));
        let q = sum(&from.q, &way);
        let angles = near.nudged(&q, &along(&way, -h, v[1]), K::IS_ANGLE);
        Self { q, qd, way, angles, corrections: 0 }
    }

    /// The first correction, by Jacobian and mass matrix of the last stage, which lies near enough.
    #[inline(always)]
    fn correct_first<K: Kernel<R, N, M>, const M: usize>(&mut self, from: &State<R, N, M>, correction: &[R; N]) {
        self.q = sum(&from.q, &sum(&self.way, correction));
        // Not the correction itself: what it and rounding made of the coordinates.
        let moved = difference(&difference(&self.q, &from.q), &self.way);
        self.angles = self.angles.corrected(&self.q, &moved, K::IS_ANGLE);
        self.corrections = 1;
    }

    /// Another correction, if one is needed.
    #[inline(always)]
    fn correct<K: Kernel<R, N, M>, const M: usize>(&mut self, kernel: &K, position: &K::Position) -> bool {
        if M == 0 || self.corrections == MOST {
            return false;
        }
        let open = kernel.residuals(position);
        let residual = largest(&open);
        if residual.is_within(CLOSED) {
            return false;
        }
        let correction = kernel.correction(position, &open);
        // Lanes that are closed already stay as they are, whatever others need.
        let size = residual.choose(CLOSED, R::zero(), largest(&correction));
        if size.is_within(ROUNDING) {
            return false;
        }
        for i in 0..N {
            self.q[i] = self.q[i] + size.choose(ROUNDING, R::zero(), correction[i]);
        }
        self.angles = self.angles.refreshed(&self.q, size, ROUNDING, K::IS_ANGLE);
        self.corrections += 1;
        true
    }

    /// Puts the rates onto the tangent of the constraints.
    #[inline(always)]
    fn close_rates<K: Kernel<R, N, M>, const M: usize>(&mut self, kernel: &K, position: &K::Position) {
        if M > 0 {
            self.qd = sum(&self.qd, &kernel.correction(position, &kernel.drift(position, &self.qd)));
        }
    }
}

/// Rates, accelerations, angles and position a part of the step away from its beginning, along rates and accelerations.
#[inline(always)]
fn stage<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    from: &State<R, N, M>,
    part: R,
    (v, a): (&[R; N], &[R; N]),
) -> ([R; N], [R; N], Angles<R, N>, K::Position) {
    let (dq, qd) = (scaled(part, v), along(&from.qd, part, a));
    let q = sum(&from.q, &dq);
    let angles = from.angles.turned(&q, &dq, K::IS_ANGLE);
    let position = kernel.position(t + part, &q, &angles);
    let (qdd, _) = kernel.accelerations(&position, t + part, &q, &qd, &angles);
    (qd, qdd, angles, position)
}

/// The mean of four slopes that the formula takes, times six.
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
fn along<R: Scalar, const N: usize>(x: &[R; N], h: R, v: &[R; N]) -> [R; N] {
    let mut end = *x;
    for i in 0..N {
        end[i] = h.mul_add(v[i], x[i]);
    }
    end
}

#[inline(always)]
fn scaled<R: Scalar, const N: usize>(h: R, v: &[R; N]) -> [R; N] {
    let mut scaled = *v;
    for i in 0..N {
        scaled[i] = h * v[i];
    }
    scaled
}

#[inline(always)]
fn sum<R: Scalar, const N: usize>(x: &[R; N], y: &[R; N]) -> [R; N] {
    let mut sum = *x;
    for i in 0..N {
        sum[i] = x[i] + y[i];
    }
    sum
}

#[inline(always)]
fn difference<R: Scalar, const N: usize>(x: &[R; N], y: &[R; N]) -> [R; N] {
    let mut difference = *x;
    for i in 0..N {
        difference[i] = x[i] - y[i];
    }
    difference
}

#[inline(always)]
fn largest<R: Scalar, const N: usize>(x: &[R; N]) -> R {
    let mut largest = R::zero();
    for i in 0..N {
        largest = x[i].abs().max(largest);
    }
    largest
}
