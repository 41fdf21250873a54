//! Motions of one mechanism in the lanes of vectors: each lane makes the steps of a design of its own.

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use crate::angles::Angles;
use crate::kernel::{Generated, Kernel, MAX_GROWTH};
use crate::lanes::{Lanes, Token};
use crate::rk4::{KernelState, rk4_step};
use crate::scalar::{Fused, Scalar};

/// Motions in lanes, whatever the mechanism and the number of lanes.
///
/// Two steps of every lane are followed by one step of a companion motion at twice the step, if errors are estimated.
pub trait SimdBatch {
    /// The number of lanes.
    fn lanes(&self) -> usize;

    /// Gives lanes their parameters.
    fn set_parameters(&mut self, values: &[Vec<f64>]);

    /// Puts a motion and its companion at a row `[t, q, qd, qdd, multipliers]`, with its steps still to make.
    fn place(&mut self, lane: usize, row: &[f64], schedule: &LaneSchedule);

    /// Copies the motion of a lane to another one.
    fn copy(&mut self, from: usize, to: usize);

    /// Replaces the state of a lane, or of its companion.
    fn set_row(&mut self, which: LaneRole, lane: usize, row: &[f64]);

    /// The state of a lane, or of its companion, as a row.
    fn row(&self, which: LaneRole, lane: usize, row: &mut [f64]);

    /// Makes steps until some lane cannot simply go on.
    fn advance(&mut self, wants_refill: bool) -> PauseReason;

    /// The number of steps that a lane has made.
    fn steps(&self, lane: usize) -> u64;

    /// Whether a lane can simply go on after the step that is waited for.
    fn goes_on(&self, lane: usize) -> bool;

    /// Whether the last step of a lane, or of its companion, can be relied on.
    fn is_reliable(&self, lane: usize) -> bool;

    /// The state of a lane, or of its companion, before the last step, as a row.
    fn row_before(&self, lane: usize, row: &mut [f64]);

    /// The largest difference of a coordinate between a motion and its companion, and the largest coordinate.
    fn difference(&self, lane: usize) -> [f64; 2];

    /// The smallest and the largest value of an output so far.
    fn range(&self, lane: usize, output: usize) -> [f64; 2];

    /// Whether all outputs of a lane were numbers so far.
    fn is_defined(&self, lane: usize) -> bool;

    /// Begins the ranges of a lane with these outputs.
    fn begin_ranges(&mut self, lane: usize, outputs: &[f64]);

    /// Replaces the outputs of a lane in the row under way.
    fn set_outputs(&mut self, lane: usize, outputs: &[f64]);
}

/// The steps of a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneSchedule {
    /// Length of the steps.
    pub step: f64,
    /// Number of the last step.
    pub last: f64,
    /// Its end.
    pub end_time: f64,
}

/// A motion in a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneRole {
    /// The motion itself.
    Main,
    /// Its companion at twice the step.
    Companion,
}

/// Why a batch of motions waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PauseReason {
    /// A step was made that some lane cannot simply go on from: it is the last one, the event occurred in it or has to
    /// be looked for, or it cannot be relied on.
    Step,
    /// A companion's step cannot be relied on.
    Companion,
    /// A lane may take another design now.
    Refill,
}

/// What every lane of a batch is asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchRequest {
    /// Whether the scene's event ends a motion.
    pub watches_event: bool,
    /// Whether each step is looked at from outside: the caller has a stop condition of its own.
    pub waits_each_step: bool,
    /// Whether the ranges of outputs are wanted.
    pub ranges: bool,
    /// Whether companions estimate errors.
    pub companions: bool,
    /// Number of outputs.
    pub outputs: usize,
}

/// The size of the vectors of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Eight doubles (AVX-512).
    Eight,
    /// Four doubles (AVX2).
    Four,
}

/// Kernels of more operations are not compiled for lanes.
const MAX_LANE_OPERATIONS: usize = 2000;

/// A batch of motions of a generated mechanism; `None` where the processor has no vectors of that width, or the kernel
/// is too large for them.
#[inline]
pub(crate) fn batch<X: Generated<N, M>, const N: usize, const M: usize>(
    width: Width,
    request: BatchRequest,
    residual: f64,
) -> Option<Box<dyn SimdBatch>> {
    #[cfg(target_arch = "x86_64")]
    {
        // Constants, so that what is not used is not compiled.
        type Make = fn(BatchRequest, f64) -> Option<Box<dyn SimdBatch>>;
        let four: Option<Make> = const {
            if X::Kernel::<f64>::OPERATIONS <= Fused::INLINE_LIMIT { Some(make_four::<X, N, M>) } else { None }
        };
        let eight: Option<Make> = const {
            if X::Kernel::<f64>::OPERATIONS <= MAX_LANE_OPERATIONS { Some(make_eight::<X, N, M>) } else { None }
        };
        match width {
            Width::Eight => eight?(request, residual),
            Width::Four => four?(request, residual),
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = (width, request, residual, MAX_LANE_OPERATIONS);
        None
    }
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn make_four<X: Generated<N, M>, const N: usize, const M: usize>(
    request: BatchRequest,
    residual: f64,
) -> Option<Box<dyn SimdBatch>> {
    let token = pulp::x86::V3::try_new()?;
    Some(Box::new(LaneBatch::<X, pulp::x86::V3, N, M>::new(token, request, residual)))
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn make_eight<X: Generated<N, M>, const N: usize, const M: usize>(
    request: BatchRequest,
    residual: f64,
) -> Option<Box<dyn SimdBatch>> {
    let token = pulp::x86::V4::try_new()?;
    Some(Box::new(LaneBatch::<X, pulp::x86::V4, N, M>::new(token, request, residual)))
}

/// Motions in the lanes of one kind of vector.
struct LaneBatch<X: Generated<N, M>, S: Token, const N: usize, const M: usize> {
    token: S,
    request: BatchRequest,
    residual: f64,
    kernel: X::Kernel<Lanes<S>>,
    /// Steps made, and steps to the end.
    made: Lanes<S>,
    last: Lanes<S>,
    step: Lanes<S>,
    end_time: Lanes<S>,
    /// The motions and their companions.
    motions: [Motion<S, N, M>; 2],
    /// The motions before the step that is waited for.
    before: Motion<S, N, M>,
    /// Growth factor, residual and finite_check of the step that is waited for.
    quality: [Lanes<S>; 3],
    /// The value of the scene's event after it.
    event: Lanes<S>,
    difference: Lanes<S>,
    size: Lanes<S>,
    /// Outputs of the last row, their smallest and their largest values.
    outputs: Vec<Lanes<S>>,
    lowest: Vec<Lanes<S>>,
    highest: Vec<Lanes<S>>,
    /// Not a number in lanes in which an output was none.
    defined: Lanes<S>,
    /// The place in the sequence of two steps and one of the companions.
    phase: usize,
    /// Whether something remains to be done of the step that was waited for.
    is_pending: bool,
}

/// A motion in each lane.
#[derive(Clone, Copy)]
struct Motion<S: Token, const N: usize, const M: usize> {
    t: Lanes<S>,
    state: KernelState<Lanes<S>, N, M>,
}

impl<S: Token, const N: usize, const M: usize> Motion<S, N, M> {
    /// Writes the motion of a lane as a row.
    #[inline]
    fn read(&self, lane: usize, row: &mut [f64]) {
        let Self { t, state } = self;
        row[0] = t.get(lane);
        for i in 0..N {
            row[1 + i] = state.q[i].get(lane);
            row[1 + N + i] = state.qd[i].get(lane);
            row[1 + 2 * N + i] = state.qdd[i].get(lane);
        }
        for k in 0..M {
            row[1 + 3 * N + k] = state.multipliers[k].get(lane);
        }
    }
}

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> LaneBatch<X, S, N, M> {
    #[inline]
    fn new(token: S, request: BatchRequest, residual: f64) -> Self {
        let zero = Lanes::<S>::from_fn(|_| 0.0);
        let state = KernelState {
            q: [zero; N],
            qd: [zero; N],
            qdd: [zero; N],
            multipliers: [zero; M],
            angles: Angles { sin: [zero; N], cos: [zero; N] },
        };
        let motion = Motion { t: zero, state };
        let outputs = vec![zero; if request.ranges { request.outputs } else { 0 }];
        Self {
            token,
            request,
            residual,
            kernel: X::Kernel::<Lanes<S>>::with_values(|_| zero),
            made: zero,
            last: zero,
            step: zero,
            end_time: zero,
            motions: [motion; 2],
            before: motion,
            quality: [zero; 3],
            event: zero,
            difference: zero,
            size: zero,
            lowest: outputs.clone(),
            highest: outputs.clone(),
            outputs,
            defined: zero,
            phase: 0,
            is_pending: false,
        }
    }

    /// Makes steps until some lane cannot simply go on: see [`SimdBatch::advance`].
    #[inline(always)]
    fn run(&mut self, wants_refill: bool) -> PauseReason {
        if self.is_pending {
            self.is_pending = false;
            self.finish_phase();
        }
        loop {
            if self.phase == 0 && wants_refill {
                return PauseReason::Refill;
            }
            // One call makes all steps: the step is long when it is compiled.
            let role = self.role();
            let next = self.made + Lanes::from_f64(1.0);
            let t_next = match role {
                LaneRole::Main => (next - self.last).choose(0.25, self.end_time, next * self.step),
                LaneRole::Companion => self.motions[0].t,
            };
            let Motion { t, state } = &self.motions[role as usize];
            let result = rk4_step(&self.kernel, *t, t_next - *t, state);
            let mut goes_on = result.is_good(self.residual);
            if role == LaneRole::Main {
                let KernelState { q, qd, qdd, multipliers, angles } = &result.end;
                let event = if self.request.watches_event { self.kernel.event(t_next, q, qd) } else { None };
                self.event = event.unwrap_or(Lanes::from_f64(-1.0));
                goes_on = goes_on
                    && (next - self.last).is_negative()
                    && self.event.is_negative()
                    && !self.request.waits_each_step;
                self.made = next;
                if self.request.ranges {
                    let position = &result.position;
                    self.kernel.outputs_at(position, t_next, q, qd, angles, qdd, multipliers, &mut self.outputs);
                }
            }
            if !goes_on {
                self.before = self.motions[role as usize];
                self.quality = [result.growth_factor, result.residual, result.end.finite_check()];
            }
            self.motions[role as usize] = Motion { t: t_next, state: result.end };
            if !goes_on {
                self.is_pending = true;
                return match role {
                    LaneRole::Main => PauseReason::Step,
                    LaneRole::Companion => PauseReason::Companion,
                };
            }
            self.finish_phase();
        }
    }

    /// Whose step is under way.
    #[inline(always)]
    fn role(&self) -> LaneRole {
        if self.phase == 2 { LaneRole::Companion } else { LaneRole::Main }
    }

    /// Takes up the outputs of a row, or the differences of the companions, and goes on to the next phase.
    #[inline(always)]
    fn finish_phase(&mut self) {
        if self.role() == LaneRole::Companion {
            let [main, companion] = &self.motions;
            for i in 0..N {
                self.difference = (companion.state.q[i] - main.state.q[i]).abs().max(self.difference);
                self.size = main.state.q[i].abs().max(self.size);
            }
        } else {
            let mut defined = self.defined;
            for i in 0..self.outputs.len() {
                let value = self.outputs[i];
                self.lowest[i] = self.lowest[i].min(value);
                self.highest[i] = self.highest[i].max(value);
                defined = value.mul_add(Lanes::zero(), defined);
            }
            self.defined = defined;
        }
        self.phase = match self.phase {
            0 => 1,
            1 if self.request.companions => 2,
            _ => 0,
        };
    }
}

/// Gives the run the instructions of the token.
struct Run<'a, X: Generated<N, M>, S: Token, const N: usize, const M: usize> {
    batch: &'a mut LaneBatch<X, S, N, M>,
    wants_refill: bool,
}

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> pulp::NullaryFnOnce for Run<'_, X, S, N, M> {
    type Output = PauseReason;

    #[inline(always)]
    fn call(self) -> PauseReason {
        self.batch.run(self.wants_refill)
    }
}

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> SimdBatch for LaneBatch<X, S, N, M> {
    #[inline]
    fn lanes(&self) -> usize {
        Lanes::<S>::COUNT
    }

    #[inline]
    fn set_parameters(&mut self, values: &[Vec<f64>]) {
        self.kernel = X::Kernel::<Lanes<S>>::with_values(|i| Lanes::from_fn(|lane| values[lane][i]));
    }

    #[inline]
    fn place(&mut self, lane: usize, row: &[f64], schedule: &LaneSchedule) {
        self.set_row(LaneRole::Main, lane, row);
        self.set_row(LaneRole::Companion, lane, row);
        let size = row[1..=N].iter().fold(0.0, |size: f64, q| if q.abs() > size { q.abs() } else { size });
        for (values, value) in [
            (&mut self.made, 0.0),
            (&mut self.last, schedule.last),
            (&mut self.step, schedule.step),
            (&mut self.end_time, schedule.end_time),
            (&mut self.difference, 0.0),
            (&mut self.size, size),
        ] {
            values.set(lane, value);
        }
    }

    #[inline]
    fn copy(&mut self, from: usize, to: usize) {
        let mut row = vec![0.0; 1 + 3 * N + M];
        self.row(LaneRole::Main, from, &mut row);
        self.set_row(LaneRole::Main, to, &row);
        self.set_row(LaneRole::Companion, to, &row);
        for values in [&mut self.made, &mut self.last, &mut self.step, &mut self.end_time] {
            values.set(to, values.get(from));
        }
    }

    #[inline]
    fn set_row(&mut self, which: LaneRole, lane: usize, row: &[f64]) {
        let Motion { t, state } = &mut self.motions[which as usize];
        t.set(lane, row[0]);
        for i in 0..N {
            let q = row[1 + i];
            state.q[i].set(lane, q);
            state.qd[i].set(lane, row[1 + N + i]);
            state.qdd[i].set(lane, row[1 + 2 * N + i]);
            if X::Kernel::<Fused>::IS_ANGLE[i] {
                let (sin, cos) = Fused(q).sin_cos();
                state.angles.sin[i].set(lane, sin.0);
                state.angles.cos[i].set(lane, cos.0);
            }
        }
        for k in 0..M {
            state.multipliers[k].set(lane, row[1 + 3 * N + k]);
        }
    }

    #[inline]
    fn row(&self, which: LaneRole, lane: usize, row: &mut [f64]) {
        self.motions[which as usize].read(lane, row);
    }

    #[inline]
    fn advance(&mut self, wants_refill: bool) -> PauseReason {
        let token = self.token;
        token.vectorize(Run { batch: self, wants_refill })
    }

    #[inline]
    fn steps(&self, lane: usize) -> u64 {
        self.made.get(lane) as u64
    }

    #[inline]
    fn goes_on(&self, lane: usize) -> bool {
        !self.request.waits_each_step
            && self.made.get(lane) < self.last.get(lane)
            && self.event.get(lane) < 0.0
            && self.is_reliable(lane)
    }

    #[inline]
    fn is_reliable(&self, lane: usize) -> bool {
        let [growth_factor, residual, finite_check] = &self.quality;
        growth_factor.get(lane).abs() <= MAX_GROWTH
            && residual.get(lane) <= self.residual
            && finite_check.get(lane) == 0.0
    }

    #[inline]
    fn row_before(&self, lane: usize, row: &mut [f64]) {
        self.before.read(lane, row);
    }

    #[inline]
    fn difference(&self, lane: usize) -> [f64; 2] {
        [self.difference.get(lane), self.size.get(lane)]
    }

    #[inline]
    fn range(&self, lane: usize, output: usize) -> [f64; 2] {
        [self.lowest[output].get(lane), self.highest[output].get(lane)]
    }

    #[inline]
    fn is_defined(&self, lane: usize) -> bool {
        self.defined.get(lane) == 0.0
    }

    #[inline]
    fn begin_ranges(&mut self, lane: usize, outputs: &[f64]) {
        self.defined.set(lane, outputs.iter().map(|value| 0.0 * value).sum());
        for ((lowest, highest), value) in self.lowest.iter_mut().zip(&mut self.highest).zip(outputs) {
            lowest.set(lane, *value);
            highest.set(lane, *value);
        }
    }

    #[inline]
    fn set_outputs(&mut self, lane: usize, outputs: &[f64]) {
        for (output, value) in self.outputs.iter_mut().zip(outputs) {
            output.set(lane, *value);
        }
    }
}
