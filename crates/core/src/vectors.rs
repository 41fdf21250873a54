//! Vector operations: sums and products of the coordinates of a step.

use crate::scalar::Scalar;

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
