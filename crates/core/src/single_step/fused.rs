//! Steps of one motion with fused products.

use super::{StepEstimate, StepMut, StepRequest};
use crate::angles::Angles;
use crate::buffers::StateRef;
use crate::dop853::{DENSE, Slopes, dop853_step};
use crate::kernel::{Kernel, MAX_GROWTH};
use crate::kernel_state::KernelState;
use crate::projection::padded;
use crate::scalar::{Fused, Scalar};

/// Makes a step: see [`Mechanism::dop853_step`](crate::Mechanism::dop853_step).
#[inline(always)]
pub(crate) fn dop853<K: Kernel<Fused, N, M>, const N: usize, const M: usize>(
    kernel: &K,
    request: &StepRequest,
    from: &StateRef,
    step: StepMut,
) -> Option<StepEstimate> {
    let [n, m] = kernel.sizes();
    let [t, h, tolerance] = [from.t, request.h, request.tolerance].map(Fused);
    let from = state(kernel, from)?;
    let mut slopes = Slopes::zero();
    let mut made = dop853_step(kernel, (t, h), &from, tolerance, &mut slopes);
    let is_valid_everywhere = made.result.growth_factor.is_within(MAX_GROWTH) && made.error.is_within(f64::MAX);
    let is_accepted = made.error.is_within(1.0);
    if !is_valid_everywhere || is_accepted && !made.result.is_good(request.residual) {
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
        let (of_q, of_qd) = step.dense.split_at_mut(DENSE.len() * n);
        for k in 0..DENSE.len() {
            write(&mut of_q[k * n..][..n], &dense.q[4 + k], n)?;
            write(&mut of_qd[k * n..][..n], &dense.qd[4 + k], n)?;
        }
    }
    let end = &made.result.end;
    write(step.end.q, &end.q, n)?;
    write(step.end.qd, &end.qd, n)?;
    write(step.end.qdd, &end.qdd, n)?;
    write(step.end.multipliers, &end.multipliers, m)?;
    for (i, largest) in step.corrections.iter_mut().enumerate().take(n) {
        *largest = largest.max((end.q[i] - made.unprojected.q[i]).abs().0);
    }
    Some(estimate)
}

/// A state with the sines and cosines of its angles.
#[inline(always)]
fn state<K: Kernel<Fused, N, M>, const N: usize, const M: usize>(
    kernel: &K,
    at: &StateRef,
) -> Option<KernelState<Fused, N, M>> {
    let [n, m] = kernel.sizes();
    let q = padded(at.q, n)?;
    let angles = Angles::new(&q, kernel.has_angle());
    let (qd, qdd, multipliers) = (padded(at.qd, n)?, padded(at.qdd, n)?, padded(at.multipliers, m)?);
    Some(KernelState { q, qd, qdd, multipliers, angles })
}

/// Fills a buffer with the first of some numbers.
#[inline(always)]
fn write(room: &mut [f64], numbers: &[Fused], count: usize) -> Option<()> {
    if room.len() != count || numbers.len() < count {
        return None;
    }
    for i in 0..count {
        room[i] = numbers[i].0;
    }
    Some(())
}
