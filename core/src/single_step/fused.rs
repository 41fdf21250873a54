//! Steps of one motion with fused products.

use super::{StepEstimate, StepMut, StepRequest};
use crate::angles::Angles;
use crate::dop853::{DENSE, Slopes, dop853_step};
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
    let mut slopes = Slopes::zero();
    let mut made = dop853_step(kernel, (t, h), &from, (is_length, tolerance), &mut slopes);
    let is_suited = made.result.growth_factor.is_within(MAX_GROWTH) && made.error.is_within(f64::MAX);
    let is_accepted = made.error.is_within(1.0);
    if !is_suited || is_accepted && !made.result.is_good(request.residual) {
        return None;
    }
    let estimate = StepEstimate {
        error: made.error.0,
        stiffness: made.stiffness(h).0,
        residual: made.unprojected.residual.0,
        corrections: made.result.corrections,
    };
    if !is_accepted {
        return Some(estimate);
    }
    if !step.dense.is_empty() {
        let dense = made.dense_output(kernel, (t, h), &from);
        if !(made.result.growth_factor.is_within(MAX_GROWTH) && dense.finite_check().is_within(0.0)) {
            return None;
        }
        let (of_q, of_qd) = step.dense.split_at_mut(DENSE.len() * N);
        for k in 0..DENSE.len() {
            write(&mut of_q[k * N..][..N], &dense.q[4 + k])?;
            write(&mut of_qd[k * N..][..N], &dense.qd[4 + k])?;
        }
    }
    let end = &made.result.end;
    write(step.end.q, &end.q)?;
    write(step.end.qd, &end.qd)?;
    write(step.end.qdd, &end.qdd)?;
    write(step.end.multipliers, &end.multipliers)?;
    for (i, largest) in step.corrections.iter_mut().enumerate().take(N) {
        *largest = largest.max((end.q[i] - made.unprojected.q[i]).abs().0);
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
fn write<const K: usize>(room: &mut [f64], numbers: &[Fused; K]) -> Option<()> {
    let room: &mut [f64; K] = room.as_mut_array()?;
    for i in 0..K {
        room[i] = numbers[i].0;
    }
    Some(())
}
