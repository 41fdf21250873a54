//! Blocks of rows by steps of fixed length.

use crate::angles::Angles;
use crate::kernel::Kernel;
use crate::kernel_state::KernelState;
use crate::rk4::rk4_step;
use crate::scalar::Scalar;

/// The layout of a row: `t`, `q`, `qd`, `qdd`, `multipliers`, the number of corrections of the coordinates in the step
/// that ends here, and the value of the scene's event (-1 if it is not watched).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowLayout {
    /// Number of coordinates.
    pub n: usize,
    /// Number of constraints.
    pub m: usize,
}

impl RowLayout {
    /// The number of entries of a row.
    #[inline(always)]
    pub const fn width(self) -> usize {
        3 + 3 * self.n + self.m
    }

    /// The index of the number of corrections.
    #[inline(always)]
    pub const fn corrections(self) -> usize {
        1 + 3 * self.n + self.m
    }

    /// The index of the event's value.
    #[inline(always)]
    pub const fn event(self) -> usize {
        self.corrections() + 1
    }
}

/// The steps to make: row `k` stands at `origin + k step`, and the last one at `end_time`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowRequest {
    /// Time of row 0.
    pub origin: f64,
    /// Length of the steps.
    pub step: f64,
    /// Time of the last row.
    pub end_time: f64,
    /// The number of the row at which the steps begin.
    pub first: u64,
    /// Largest accepted residual of a constraint after a step.
    pub residual: f64,
    /// Whether the scene's event stops the steps.
    pub watches_event: bool,
}

impl RowRequest {
    /// The time of a row; a remainder far below a step is merged into the last step.
    #[inline(always)]
    pub fn time(&self, row: u64) -> f64 {
        let t = self.origin + row as f64 * self.step;
        if t >= self.end_time - 1e-9 * self.step { self.end_time } else { t }
    }
}

/// The result of a request for rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowResult {
    /// The number of rows written after the first one.
    pub rows_written: usize,
    /// The reason to stop; `None` if the next step is unreliable: some number is not finite, a residual is too large,
    /// or the kernel is not valid at the position.
    pub reason: Option<StopReason>,
}

/// The reason to stop before the buffer holds further rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The buffer is full.
    Full,
    /// The last row stands at the end time.
    End,
    /// The event's value in the last row is not below zero.
    Event,
}

/// Makes rows: see [`Mechanism::integrate_rk4`](crate::Mechanism::integrate_rk4).
#[inline(always)]
pub(crate) fn integrate_rk4<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    request: &RowRequest,
    rows: &mut [f64],
) -> RowResult {
    let [n, m] = kernel.sizes();
    let layout = RowLayout { n, m };
    let mut rows = rows.chunks_exact_mut(layout.width());
    let Some(first) = rows.next() else { return RowResult { rows_written: 0, reason: Some(StopReason::Full) } };
    let (mut t, mut state) = read(kernel, layout, first);
    let mut rows_written = 0;
    for row in rows {
        if t >= request.end_time {
            return RowResult { rows_written, reason: Some(StopReason::End) };
        }
        let next = request.time(request.first + rows_written as u64 + 1);
        let result = rk4_step(kernel, R::from_f64(t), R::from_f64(next - t), &state);
        if !result.is_good(request.residual) {
            return RowResult { rows_written, reason: None };
        }
        state = result.end;
        t = next;
        let event = match kernel.event(R::from_f64(t), &state.q, &state.qd, &state.qdd, &state.multipliers) {
            Some(value) if request.watches_event => value.to_f64(),
            _ => -1.0,
        };
        write(row, layout, t, &state, result.corrections, event);
        rows_written += 1;
        // Written so that a value that is not a number also stops the steps.
        if !(event < 0.0) {
            return RowResult { rows_written, reason: Some(StopReason::Event) };
        }
    }
    RowResult { rows_written, reason: Some(if t >= request.end_time { StopReason::End } else { StopReason::Full }) }
}

#[inline(always)]
fn read<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    RowLayout { n, m }: RowLayout,
    row: &[f64],
) -> (f64, KernelState<R, N, M>) {
    let (mut q, mut qd, mut qdd, mut multipliers) = ([R::zero(); N], [R::zero(); N], [R::zero(); N], [R::zero(); M]);
    for i in 0..n {
        q[i] = R::from_f64(row[1 + i]);
        qd[i] = R::from_f64(row[1 + n + i]);
        qdd[i] = R::from_f64(row[1 + 2 * n + i]);
    }
    for k in 0..m {
        multipliers[k] = R::from_f64(row[1 + 3 * n + k]);
    }
    (row[0], KernelState { q, qd, qdd, multipliers, angles: Angles::new_out_of_line(&q, kernel.has_angle()) })
}

#[inline(always)]
fn write<R: Scalar, const N: usize, const M: usize>(
    row: &mut [f64],
    RowLayout { n, m }: RowLayout,
    t: f64,
    state: &KernelState<R, N, M>,
    corrections: u32,
    event: f64,
) {
    row[0] = t;
    for i in 0..n {
        row[1 + i] = state.q[i].to_f64();
        row[1 + n + i] = state.qd[i].to_f64();
        row[1 + 2 * n + i] = state.qdd[i].to_f64();
    }
    for k in 0..m {
        row[1 + 3 * n + k] = state.multipliers[k].to_f64();
    }
    row[1 + 3 * n + m] = f64::from(corrections);
    row[2 + 3 * n + m] = event;
}
