//! Sines and cosines that are updated by rotations.

#[cfg(feature = "simd")]
use core::f64::consts::FRAC_PI_4;

use crate::scalar::Scalar;

/// Sines and cosines of the coordinates that are angles; the entries of other coordinates are meaningless.
#[derive(Clone, Copy, Debug)]
pub struct Angles<R, const N: usize> {
    /// Sines.
    pub sin: [R; N],
    /// Cosines.
    pub cos: [R; N],
}

/// The largest rotation, in rad, for which the series is accurate to 5e-17.
const SHORT: f64 = 1.0 / 40.0;
const SMALL: f64 = 6e-6;
const TINY: f64 = 1e-8;

/// The minimax polynomial (Remez) of d^2 for (sin d - d) / d^3, for rotations up to `SHORT`.
const SINE: [f64; 2] = [-0.166_666_666_626_764_27, 0.008_333_148_724_138_672];

// Loops instead of closures: rustc always inlines the body of a loop, with the target features of the enclosing
// function.
impl<R: Scalar, const N: usize> Angles<R, N> {
    /// Computes the sines and cosines of the coordinates `q` for which `is_angle` is true.
    #[inline(always)]
    pub fn new(q: &[R; N], is_angle: [bool; N]) -> Self {
        let mut angles = Self { sin: *q, cos: *q };
        for i in 0..N {
            if is_angle[i] {
                (angles.sin[i], angles.cos[i]) = q[i].sin_cos();
            }
        }
        angles
    }

    /// Computes the sines and cosines of angles, out of line: used at the start of a block of steps.
    #[inline(always)]
    pub(crate) fn new_out_of_line(q: &[R; N], is_angle: [bool; N]) -> Self {
        Self { sin: *q, cos: *q }.recomputed_where(q, R::from_f64(1.0), 0.0, is_angle)
    }

    /// Returns the sines and cosines of `to`, which lies a rotation `dq` from the present angles; fastest for rotations
    /// up to 1/40 rad.
    #[inline(always)]
    #[must_use]
    pub fn rotated_small(&self, to: &[R; N], dq: &[R; N], is_angle: [bool; N]) -> Self {
        let mut rotated = *self;
        for i in 0..N {
            if is_angle[i] {
                (rotated.sin[i], rotated.cos[i]) = short(self.sin[i], self.cos[i], dq[i]);
            }
        }
        let size = largest(dq, is_angle);
        if size.is_within(SHORT) { rotated } else { rotated.recomputed_where(to, size, SHORT, is_angle) }
    }

    /// Returns the sines and cosines of `to`, which lies a rotation `dq` from the present angles; fastest for rotations
    /// up to an eighth of a revolution.
    #[cfg(feature = "simd")]
    #[inline(always)]
    #[must_use]
    pub(crate) fn rotated_large(&self, to: &[R; N], dq: &[R; N], is_angle: [bool; N]) -> Self {
        let mut rotated = *self;
        for i in 0..N {
            if is_angle[i] {
                (rotated.sin[i], rotated.cos[i]) = crate::sine::rotated(self.sin[i], self.cos[i], dq[i]);
            }
        }
        let size = largest(dq, is_angle);
        if size.is_within(FRAC_PI_4) { rotated } else { rotated.recomputed_where(to, size, FRAC_PI_4, is_angle) }
    }

    /// Returns the sines and cosines of `to`, which lies a rotation `dq` from the present angles; fastest for rotations
    /// up to 6e-6 rad.
    #[inline(always)]
    #[must_use]
    pub fn rotated_tiny(&self, to: &[R; N], dq: &[R; N], is_angle: [bool; N]) -> Self {
        let mut rotated = *self;
        for i in 0..N {
            if is_angle[i] {
                (rotated.sin[i], rotated.cos[i]) = small(self.sin[i], self.cos[i], dq[i]);
            }
        }
        let size = largest(dq, is_angle);
        if size.is_within(SMALL) { rotated } else { rotated.recomputed_where(to, size, SMALL, is_angle) }
    }

    /// Returns the sines and cosines of `to`, which lies a rotation `dq` from the present angles; fastest for rotations
    /// up to 1e-8 rad.
    #[inline(always)]
    #[must_use]
    pub fn rotated_by_correction(&self, to: &[R; N], dq: &[R; N], is_angle: [bool; N]) -> Self {
        let mut rotated = *self;
        for i in 0..N {
            if is_angle[i] {
                (rotated.sin[i], rotated.cos[i]) =
                    (self.cos[i].mul_add(dq[i], self.sin[i]), self.sin[i].neg_mul_add(dq[i], self.cos[i]));
            }
        }
        let size = largest(dq, is_angle);
        if size.is_within(TINY) { rotated } else { rotated.recomputed_where(to, size, TINY, is_angle) }
    }

    /// Computes the sines and cosines of `q` in lanes in which `test` is larger than `bound`, and keeps the present
    /// ones in the others. The function is not inlined, for places where this is rarely needed.
    #[inline(always)]
    #[must_use]
    pub fn recomputed_where(&self, q: &[R; N], test: R, bound: f64, is_angle: [bool; N]) -> Self {
        let mut angles = *self;
        for i in 0..N {
            if is_angle[i] {
                let (sin, cos) = q[i].sin_cos_apart();
                angles.sin[i] = test.choose(bound, self.sin[i], sin);
                angles.cos[i] = test.choose(bound, self.cos[i], cos);
            }
        }
        angles
    }
}

#[inline(always)]
fn largest<R: Scalar, const N: usize>(dq: &[R; N], is_angle: [bool; N]) -> R {
    let mut largest = R::zero();
    for i in 0..N {
        if is_angle[i] {
            largest = dq[i].abs().max(largest);
        }
    }
    largest
}

/// `sin(x + d)` and `cos(x + d)` from those of `x`.
#[inline(always)]
fn short<R: Scalar>(sin: R, cos: R, d: R) -> (R, R) {
    let number = R::from_f64;
    let z = d * d;
    let sin_d = (d * z).mul_add(z.mul_add(number(SINE[1]), number(SINE[0])), d);
    let cos_d_less_one = (z * z).mul_add(z.mul_add(number(-1.0 / 720.0), number(1.0 / 24.0)), z * number(-0.5));
    (sin + cos.mul_add(sin_d, sin * cos_d_less_one), cos + sin.neg_mul_add(sin_d, cos * cos_d_less_one))
}

#[inline(always)]
fn small<R: Scalar>(sin: R, cos: R, d: R) -> (R, R) {
    let cos_d_less_one = d * d * R::from_f64(-0.5);
    (sin.mul_add(cos_d_less_one, cos.mul_add(d, sin)), cos.mul_add(cos_d_less_one, sin.neg_mul_add(d, cos)))
}
