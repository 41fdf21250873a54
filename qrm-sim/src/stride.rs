//! A whole step by a mechanism's kernel: the classical formula, correction of coordinates and rates in the metric of the mass
//! matrix, accelerations and multipliers at the end. Written for any kind of number, so that lanes make several steps at once.

use qrm_mechanism::{Angles, Kernel, Lane};

/// A state with what a step needs at its beginning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<R, const N: usize, const M: usize> {
    pub(crate) q: [R; N],
    pub(crate) qd: [R; N],
    pub(crate) qdd: [R; N],
    pub(crate) multipliers: [R; M],
    /// Those of `q`.
    pub(crate) angles: Angles<R, N>,
}

/// The end of a step, and how it was reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stride<R, P, const N: usize, const M: usize> {
    pub(crate) end: State<R, N, M>,
    /// What follows from the position there.
    #[cfg_attr(not(feature = "sweep"), allow(dead_code, reason = "outputs in lanes need it"))]
    pub(crate) position: P,
    /// Largest growth of rounding errors.
    pub(crate) strain: R,
    /// Largest residual at the end.
    pub(crate) residual: R,
    pub(crate) corrections: u32,
}

/// Residuals up to this size, in the unit of a constraint, are rounding errors.
const CLOSED: f64 = 4e-16;
/// Corrections up to this size, in rad or m, are rounding errors.
const ROUNDING: f64 = 1e-15;
/// Most corrections; what takes more is left to the careful way.
const MOST: u32 = 4;

/// One step of length `h` that begins at `t`.
#[inline(always)]
pub(crate) fn stride<K: Kernel<R, N, M>, R: Lane, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    h: R,
    from: &State<R, N, M>,
) -> Stride<R, K::Position, N, M> {
    let half = R::from_f64(0.5) * h;
    let mut strain = R::zero();
    let (v2, a2, ..) = stage(kernel, t, from, half, (&from.qd, &from.qdd), &mut strain);
    let (v3, a3, ..) = stage(kernel, t, from, half, (&v2, &a2), &mut strain);
    let (v4, a4, last, near) = stage(kernel, t, from, h, (&v3, &a3), &mut strain);
    let sixth = h / R::from_f64(6.0);
    let way = mean(sixth, [&from.qd, &v2, &v3, &v4]);
    let mut qd = sum(&from.qd, &mean(sixth, [&from.qdd, &a2, &a3, &a4]));

    // The last stage lies so near that its Jacobian and mass matrix make the first correction.
    let mut q = sum(&from.q, &way);
    let off = along(&way, -h, &v3);
    let mut angles = near.nudged(&q, &off, K::IS_ANGLE);
    if M > 0 {
        let open = kernel.residuals(&kernel.position(&q, &angles));
        let correction = kernel.correction(&last, &open);
        q = sum(&from.q, &sum(&way, &correction));
        // Not the correction itself: what it and rounding made of the coordinates.
        let moved = difference(&difference(&q, &from.q), &way);
        angles = angles.corrected(&q, &moved, K::IS_ANGLE);
    }
    let mut corrections = u32::from(M > 0);
    let position = loop {
        let position = kernel.position(&q, &angles);
        if M == 0 || corrections == MOST {
            break position;
        }
        let open = kernel.residuals(&position);
        let residual = largest(&open);
        if residual.is_within(CLOSED) {
            break position;
        }
        let correction = kernel.correction(&position, &open);
        // Lanes that are closed already stay as they are, whatever others need.
        let size = residual.choose(CLOSED, R::zero(), largest(&correction));
        if size.is_within(ROUNDING) {
            break position;
        }
        for i in 0..N {
            q[i] = q[i] + size.choose(ROUNDING, R::zero(), correction[i]);
        }
        angles = angles.refreshed(&q, size, ROUNDING, K::IS_ANGLE);
        corrections += 1;
    };
    strain = kernel.strain(&position).max(strain);
    if M > 0 {
        qd = sum(&qd, &kernel.correction(&position, &kernel.drift(&position, &qd)));
    }
    let (qdd, multipliers) = kernel.accelerations(&position, t + h, &q, &qd, &angles);
    let residual = largest(&kernel.residuals(&position));
    // Nothing waits for these before the next step: turns made one after another would add up their rounding errors.
    let angles = Angles::new(&q, K::IS_ANGLE);
    Stride { end: State { q, qd, qdd, multipliers, angles }, position, strain, residual, corrections }
}

/// Rates, accelerations and position a part of the step away from its beginning, along rates and accelerations.
#[inline(always)]
fn stage<K: Kernel<R, N, M>, R: Lane, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    from: &State<R, N, M>,
    part: R,
    (v, a): (&[R; N], &[R; N]),
    strain: &mut R,
) -> ([R; N], [R; N], K::Position, Angles<R, N>) {
    let (dq, qd) = (scaled(part, v), along(&from.qd, part, a));
    let q = sum(&from.q, &dq);
    let angles = from.angles.turned(&q, &dq, K::IS_ANGLE);
    let position = kernel.position(&q, &angles);
    *strain = kernel.strain(&position).max(*strain);
    let (qdd, _) = kernel.accelerations(&position, t + part, &q, &qd, &angles);
    (qd, qdd, position, angles)
}

/// The mean of four slopes that the formula takes, times six.
#[inline(always)]
fn mean<R: Lane, const N: usize>(sixth: R, k: [&[R; N]; 4]) -> [R; N] {
    let mut mean = *k[0];
    for i in 0..N {
        mean[i] = sixth * (R::from_f64(2.0).mul_add(k[1][i] + k[2][i], k[0][i]) + k[3][i]);
    }
    mean
}

/// `x + h v`
#[inline(always)]
fn along<R: Lane, const N: usize>(x: &[R; N], h: R, v: &[R; N]) -> [R; N] {
    let mut end = *x;
    for i in 0..N {
        end[i] = h.mul_add(v[i], x[i]);
    }
    end
}

#[inline(always)]
fn scaled<R: Lane, const N: usize>(h: R, v: &[R; N]) -> [R; N] {
    let mut scaled = *v;
    for i in 0..N {
        scaled[i] = h * v[i];
    }
    scaled
}

#[inline(always)]
fn sum<R: Lane, const N: usize>(x: &[R; N], y: &[R; N]) -> [R; N] {
    let mut sum = *x;
    for i in 0..N {
        sum[i] = x[i] + y[i];
    }
    sum
}

#[inline(always)]
fn difference<R: Lane, const N: usize>(x: &[R; N], y: &[R; N]) -> [R; N] {
    let mut difference = *x;
    for i in 0..N {
        difference[i] = x[i] - y[i];
    }
    difference
}

#[inline(always)]
fn largest<R: Lane, const N: usize>(x: &[R; N]) -> R {
    let mut largest = R::zero();
    for i in 0..N {
        largest = x[i].abs().max(largest);
    }
    largest
}
