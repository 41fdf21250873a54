//! Steps of one motion with fused products.

use super::{StepEstimate, StepMut, StepRequest};
use crate::angles::Angles;
use crate::dop853::dop853_step;
use crate::kernel::{Generated, Kernel, MAX_GROWTH};
use crate::mechanism::StateRef;
use crate::rk4::KernelState;
use crate::scalar::{Fused, Scalar};

/// Makes a step: see [`Mechanism::dop853_step`](crate::Mechanism::dop853_step).
#[inline(always)]
pub(crate) fn dop853<X: Generated<N, M>, const N: usize, const M: usize>(
    kernel: &X::Kernel<Fused>,
    request: &StepRequest,
    from: &StateRef,
    step: StepMut,
) -> Option<StepEstimate> {
    let is_length = core::array::from_fn(|i| !X::DESCRIPTION.is_angle(i));
    let [t, h, tolerance] = [from.t, request.h, request.tolerance].map(Fused);
    let from = state::<X::Kernel<Fused>, N, M>(from)?;
    let mut made = dop853_step(kernel, (t, h), &from, (is_length, tolerance));
    let result = &made.result;
    if made.error.is_within(1.0) && !result.is_good(request.residual)
        || !(result.growth_factor.is_within(MAX_GROWTH) && made.error.is_within(f64::MAX))
    {
        return None;
    }
    write(step.end.q, &result.end.q);
    write(step.end.qd, &result.end.qd);
    write(step.end.qdd, &result.end.qdd);
    write(step.end.multipliers, &result.end.multipliers);
    let estimate = StepEstimate {
        error: made.error.0,
        stiffness: made.stiffness(h).0,
        residual: made.unprojected.residual.0,
        corrections: result.corrections,
    };
    if estimate.error > 1.0 {
        return Some(estimate);
    }
    for (i, largest) in step.corrections.iter_mut().enumerate().take(N) {
        *largest = largest.max((result.end.q[i] - made.unprojected.q[i]).abs().0);
    }
    if !step.dense.is_empty() {
        let dense = made.dense_output(kernel, (t, h), &from);
        for (k, room) in step.dense.chunks_exact_mut(N).enumerate().take(8) {
            write(room, if k < 4 { &dense.q[4 + k] } else { &dense.qd[k] });
        }
    }
    Some(estimate)
}

/// A state with the sines and cosines of its angles.
#[inline(always)]
fn state<K: Kernel<Fused, N, M>, const N: usize, const M: usize>(at: &StateRef) -> Option<KernelState<Fused, N, M>> {
    let q = numbers(at.q)?;
    let angles = Angles::new(&q, K::IS_ANGLE);
    let (qd, qdd, multipliers) = (numbers(at.qd)?, numbers(at.qdd)?, numbers(at.multipliers)?);
    Some(KernelState { q, qd, qdd, multipliers, angles })
}

#[inline(always)]
fn numbers<const K: usize>(x: &[f64]) -> Option<[Fused; K]> {
    let x: &[f64; K] = x.as_array()?;
    let mut numbers = [Fused(0.0); K];
    for i in 0..K {
        numbers[i] = Fused(x[i]);
    }
    Some(numbers)
}

#[inline(always)]
fn write<const K: usize>(room: &mut [f64], numbers: &[Fused; K]) {
    for (place, number) in room.iter_mut().zip(numbers) {
        *place = number.0;
    }
}
