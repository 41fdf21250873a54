//! Stages of any explicit Runge-Kutta method, and projected states, by a kernel.

use core::ops::Range;

use crate::angles::Angles;
use crate::kernel::{Kernel, MAX_GROWTH};
use crate::rk4::{StepEnd, largest};

/// Stages of a step of an explicit Runge-Kutta method, `k_i = f(t + c_i h, y + h sum_j a_ij k_j)`.
#[derive(Clone, Debug)]
pub struct StageRequest<'a> {
    /// Time at the beginning of the step.
    pub t: f64,
    /// Length of the step.
    pub h: f64,
    /// The stages to evaluate; those before them are known.
    pub stages: Range<usize>,
    /// `c_i`.
    pub nodes: &'a [f64],
    /// The pairs of `j` and `a_ij`, zeros left out.
    pub rows: &'a [&'a [(usize, f64)]],
}

/// Room for a state.
#[derive(Debug)]
pub struct StateMut<'a> {
    /// Coordinates.
    pub q: &'a mut [f64],
    /// Rates.
    pub qd: &'a mut [f64],
    /// Accelerations.
    pub qdd: &'a mut [f64],
    /// Multipliers.
    pub multipliers: &'a mut [f64],
}

/// The projection of a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProjectionResult {
    /// Largest residual of a constraint before it, in its unit.
    pub residual: f64,
    /// How often the coordinates were corrected.
    pub corrections: u32,
}

/// A request to a kernel.
pub(crate) enum Evaluation<'a, const N: usize> {
    /// Rates and accelerations at stages, `N` numbers each, of a step from coordinates.
    Stages { request: &'a StageRequest<'a>, q: &'a [f64; N], rates: &'a mut [f64], accelerations: &'a mut [f64] },
    /// Accelerations and multipliers of a state at a time; before them its projection, up to a residual.
    State { t: f64, tolerance: Option<f64>, state: StateMut<'a> },
}

/// Evaluates the kernel; `None` where it does not suit a position, or a number is not finite.
///
/// The kernel stands here once, whatever it is asked for.
#[inline]
pub(crate) fn evaluate<K: Kernel<f64, N, M>, const N: usize, const M: usize>(
    kernel: &K,
    mut evaluation: Evaluation<N>,
) -> Option<ProjectionResult> {
    let (q, qd) = match &evaluation {
        Evaluation::Stages { q, .. } => (**q, [0.0; N]),
        Evaluation::State { state, .. } => (*state.q.as_array()?, *state.qd.as_array()?),
    };
    let from = Angles::new(&q, K::IS_ANGLE);
    let mut end = StepEnd { q, qd, increment: [0.0; N], angles: from, corrections: 0 };
    let mut residual = None;
    let mut stage = match &evaluation {
        Evaluation::Stages { request, .. } => request.stages.start,
        Evaluation::State { .. } => 0,
    };
    loop {
        let t = match &evaluation {
            Evaluation::Stages { request, rates, accelerations, .. } => {
                if stage == request.stages.end {
                    return Some(ProjectionResult::default());
                }
                let row = request.rows[stage];
                let (rate, acceleration) = (sum::<N>(row, rates), sum::<N>(row, accelerations));
                let mut dq = rate;
                for i in 0..N {
                    dq[i] = request.h * rate[i];
                    end.q[i] = q[i] + dq[i];
                    end.qd[i] = rates[i] + request.h * acceleration[i];
                }
                end.angles = from.turned(&end.q, &dq, K::IS_ANGLE);
                request.t + request.nodes[stage] * request.h
            }
            Evaluation::State { t, .. } => *t,
        };
        let position = kernel.position(t, &end.q, &end.angles);
        if let Evaluation::State { tolerance: Some(tolerance), .. } = &evaluation {
            let open = largest(&kernel.residuals(&position));
            residual.get_or_insert(open);
            if end.project_coordinates::<K, M>(kernel, &position) {
                continue;
            }
            if !(open <= *tolerance) {
                return None;
            }
            end.project_rates(kernel, &position);
        }
        let (qdd, multipliers) = kernel.accelerations(&position, t, &end.q, &end.qd, &end.angles);
        let is_finite = are_finite(&qdd) && are_finite(&multipliers) && are_finite(&end.q) && are_finite(&end.qd);
        if !(kernel.growth_factor(&position) <= MAX_GROWTH && is_finite) {
            return None;
        }
        match &mut evaluation {
            Evaluation::Stages { rates, accelerations, .. } => {
                rates[stage * N..][..N].copy_from_slice(&end.qd);
                accelerations[stage * N..][..N].copy_from_slice(&qdd);
                stage += 1;
            }
            Evaluation::State { state, .. } => {
                state.q.copy_from_slice(&end.q);
                state.qd.copy_from_slice(&end.qd);
                state.qdd.copy_from_slice(&qdd);
                state.multipliers.copy_from_slice(&multipliers);
                let residual = residual.unwrap_or(0.0);
                return Some(ProjectionResult { residual, corrections: end.corrections });
            }
        }
    }
}

#[inline]
fn are_finite(numbers: &[f64]) -> bool {
    // Zero times a number that is not finite is not a number.
    let mut sum = 0.0;
    for number in numbers {
        sum += number * 0.0;
    }
    sum == 0.0
}

/// The sum over the stages of a row.
#[inline(always)]
fn sum<const N: usize>(row: &[(usize, f64)], stages: &[f64]) -> [f64; N] {
    let mut sum = [0.0; N];
    for &(stage, weight) in row {
        let stage = &stages[stage * N..][..N];
        for i in 0..N {
            sum[i] += weight * stage[i];
        }
    }
    sum
}
