//! Steps of one mechanism in the lanes of vectors: the part of a batch that is compiled for each scene.

extern crate alloc;

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use crate::angles::Angles;
use crate::batch::{
    BatchLayout, BatchRequest, DEFINED, DIFFERENCES, END_TIME, EVENT, LAST, LaneRole, MADE, PauseReason, QUALITY, STEP,
    Width,
};
use crate::kernel::{Generated, Kernel};
use crate::lanes::{Lanes, Token};
use crate::rk4::{KernelState, rk4_step};
use crate::scalar::{Fused, Scalar};

/// Steps in lanes, whatever the mechanism and the number of lanes; used by [`SimdBatch`](crate::SimdBatch), which knows
/// the places of the numbers.
pub trait LaneSteps {
    /// The number of lanes.
    fn lanes(&self) -> usize;

    /// The number of a lane at a place of the batch.
    fn get(&self, place: usize, lane: usize) -> f64;

    /// Replaces the number of a lane at a place of the batch.
    fn set(&mut self, place: usize, lane: usize, number: f64);

    /// Gives lanes their parameters.
    fn set_parameters(&mut self, values: &[Vec<f64>]);

    /// Makes steps until some lane cannot simply go on.
    fn advance(&mut self, wants_refill: bool) -> PauseReason;
}

/// Kernels of more operations are not compiled for lanes.
const MAX_LANE_OPERATIONS: usize = 2000;

/// The steps of a generated mechanism in lanes; `None` where the processor has no vectors of that width, or the kernel
/// is too large for them.
#[inline]
pub(crate) fn lane_steps<X: Generated<N, M>, const N: usize, const M: usize>(
    width: Width,
    request: BatchRequest,
    residual: f64,
) -> Option<Box<dyn LaneSteps>> {
    #[cfg(target_arch = "x86_64")]
    {
        // Constants, so that what is not used is not compiled.
        type Make = fn(BatchRequest, f64) -> Option<Box<dyn LaneSteps>>;
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
) -> Option<Box<dyn LaneSteps>> {
    let token = pulp::x86::V3::try_new()?;
    Some(Box::new(StepsBy::<X, pulp::x86::V3, N, M>::new(token, request, residual)))
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn make_eight<X: Generated<N, M>, const N: usize, const M: usize>(
    request: BatchRequest,
    residual: f64,
) -> Option<Box<dyn LaneSteps>> {
    let token = pulp::x86::V4::try_new()?;
    Some(Box::new(StepsBy::<X, pulp::x86::V4, N, M>::new(token, request, residual)))
}

/// The sequence of steps where errors are estimated: three steps take as long as two of the companion.
const SEQUENCE: [LaneRole; 5] = {
    use LaneRole::{Companion, Main};
    [Main, Main, Main, Companion, Companion]
};

/// Steps by one kind of vector.
struct StepsBy<X: Generated<N, M>, S: Token, const N: usize, const M: usize> {
    token: S,
    request: BatchRequest,
    residual: f64,
    kernel: X::Kernel<Lanes<S>>,
    /// At the places of the layout.
    numbers: Vec<Lanes<S>>,
    /// The place in the sequence of steps.
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

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> StepsBy<X, S, N, M> {
    #[inline]
    fn new(token: S, request: BatchRequest, residual: f64) -> Self {
        let zero = Lanes::zero();
        let layout = BatchLayout::new(N, M, X::DESCRIPTION.outputs.len(), &request);
        Self {
            token,
            request,
            residual,
            kernel: X::Kernel::<Lanes<S>>::with_values(&|_| zero),
            numbers: vec![zero; layout.places()],
            phase: 0,
            is_pending: false,
        }
    }

    /// Makes steps until some lane cannot simply go on: see [`LaneSteps::advance`].
    #[inline(always)]
    fn run(&mut self, wants_refill: bool) -> PauseReason {
        let mut made = self.number(MADE);
        let [last, step, end_time] = [self.number(LAST), self.number(STEP), self.number(END_TIME)];
        let main = self.motion(LaneRole::Main);
        let mut motions = [main, if self.request.companions { self.motion(LaneRole::Companion) } else { main }];
        if self.is_pending {
            self.is_pending = false;
            self.finish_phase(&motions);
        }
        let reason = loop {
            if self.phase == 0 && wants_refill {
                break PauseReason::Refill;
            }
            // One call makes all steps: the step is long when it is compiled.
            let role = self.role();
            let next = made + Lanes::from_f64(1.0);
            let t_next = match role {
                LaneRole::Main => (next - last).choose(0.25, end_time, next * step),
                LaneRole::Companion if self.is_last_phase() => motions[0].t,
                LaneRole::Companion => (made - Lanes::from_f64(1.5)) * step,
            };
            let Motion { t, state } = &motions[role as usize];
            let result = rk4_step(&self.kernel, *t, t_next - *t, state);
            let mut goes_on = result.is_good(self.residual);
            let mut event = Lanes::from_f64(-1.0);
            if role == LaneRole::Main {
                let KernelState { q, qd, qdd, multipliers, angles } = &result.end;
                if self.request.watches_event
                    && let Some(value) = self.kernel.event(t_next, q, qd)
                {
                    event = value;
                }
                goes_on =
                    goes_on && (next - last).is_negative() && event.is_negative() && !self.request.waits_each_step;
                made = next;
                if self.request.ranges {
                    let layout = self.layout();
                    let outputs = &mut self.numbers[layout.outputs()..][..layout.output_count];
                    let position = &result.position;
                    self.kernel.outputs_at(position, t_next, q, qd, angles, qdd, multipliers, outputs);
                }
            }
            if !goes_on {
                self.set_row(self.layout().row_before(), &motions[role as usize]);
                self.set_number(EVENT, event);
                self.set_number(QUALITY, result.growth_factor);
                self.set_number(QUALITY + 1, result.residual);
                self.set_number(QUALITY + 2, result.end.finite_check());
            }
            motions[role as usize] = Motion { t: t_next, state: result.end };
            if !goes_on {
                self.is_pending = true;
                break match role {
                    LaneRole::Main => PauseReason::Step,
                    LaneRole::Companion => PauseReason::Companion,
                };
            }
            self.finish_phase(&motions);
        };
        self.set_number(MADE, made);
        self.set_row(self.layout().row(LaneRole::Main), &motions[0]);
        if self.request.companions {
            self.set_row(self.layout().row(LaneRole::Companion), &motions[1]);
        }
        reason
    }

    #[inline(always)]
    fn layout(&self) -> BatchLayout {
        BatchLayout::new(N, M, X::DESCRIPTION.outputs.len(), &self.request)
    }

    /// Whose step is under way.
    #[inline(always)]
    fn role(&self) -> LaneRole {
        SEQUENCE[self.phase]
    }

    /// Whether motion and companion stand at the same time after the step under way.
    #[inline(always)]
    fn is_last_phase(&self) -> bool {
        self.phase + 1 == SEQUENCE.len()
    }

    /// Takes up the outputs of a row, or the differences of the companions, and goes on to the next phase.
    #[inline(always)]
    fn finish_phase(&mut self, [main, companion]: &[Motion<S, N, M>; 2]) {
        if self.is_last_phase() {
            for i in 0..N {
                let (own, q) = (companion.state.q[i], main.state.q[i]);
                let [difference, lowest, highest] = [0, 1, 2].map(|kind| DIFFERENCES + kind * N + i);
                self.set_number(difference, (own - q).abs().max(self.number(difference)));
                self.set_number(lowest, q.min(self.number(lowest)));
                self.set_number(highest, q.max(self.number(highest)));
            }
        } else if self.role() == LaneRole::Main {
            let mut defined = self.number(DEFINED);
            let count = self.layout().output_count;
            let place = self.layout().outputs();
            let (outputs, ranges) = self.numbers[place..].split_at_mut(count);
            let (lowest, highest) = ranges.split_at_mut(count);
            for i in 0..count {
                lowest[i] = lowest[i].min(outputs[i]);
                highest[i] = highest[i].max(outputs[i]);
                defined = outputs[i].mul_add(Lanes::zero(), defined);
            }
            self.set_number(DEFINED, defined);
        }
        self.phase = if self.request.companions { (self.phase + 1) % SEQUENCE.len() } else { 0 };
    }

    #[inline(always)]
    fn number(&self, place: usize) -> Lanes<S> {
        self.numbers[place]
    }

    #[inline(always)]
    fn set_number(&mut self, place: usize, number: Lanes<S>) {
        self.numbers[place] = number;
    }

    #[inline(always)]
    fn motion(&self, role: LaneRole) -> Motion<S, N, M> {
        let place = self.layout().row(role);
        let zero = Lanes::zero();
        let (mut q, mut qd, mut qdd, mut multipliers) = ([zero; N], [zero; N], [zero; N], [zero; M]);
        for i in 0..N {
            q[i] = self.number(place + 1 + i);
            qd[i] = self.number(place + 1 + N + i);
            qdd[i] = self.number(place + 1 + 2 * N + i);
        }
        for k in 0..M {
            multipliers[k] = self.number(place + 1 + 3 * N + k);
        }
        let angles = Angles::apart(&q, X::Kernel::<Lanes<S>>::IS_ANGLE);
        Motion { t: self.number(place), state: KernelState { q, qd, qdd, multipliers, angles } }
    }

    #[inline(always)]
    fn set_row(&mut self, place: usize, Motion { t, state }: &Motion<S, N, M>) {
        self.set_number(place, *t);
        for i in 0..N {
            self.set_number(place + 1 + i, state.q[i]);
            self.set_number(place + 1 + N + i, state.qd[i]);
            self.set_number(place + 1 + 2 * N + i, state.qdd[i]);
        }
        for k in 0..M {
            self.set_number(place + 1 + 3 * N + k, state.multipliers[k]);
        }
    }
}

/// Gives the run the instructions of the token.
struct Run<'a, X: Generated<N, M>, S: Token, const N: usize, const M: usize> {
    steps: &'a mut StepsBy<X, S, N, M>,
    wants_refill: bool,
}

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> pulp::NullaryFnOnce for Run<'_, X, S, N, M> {
    type Output = PauseReason;

    #[inline(always)]
    fn call(self) -> PauseReason {
        self.steps.run(self.wants_refill)
    }
}

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> LaneSteps for StepsBy<X, S, N, M> {
    #[inline]
    fn lanes(&self) -> usize {
        Lanes::<S>::COUNT
    }

    #[inline]
    fn get(&self, place: usize, lane: usize) -> f64 {
        self.numbers[place].get(lane)
    }

    #[inline]
    fn set(&mut self, place: usize, lane: usize, number: f64) {
        self.numbers[place].set(lane, number);
    }

    #[inline]
    fn set_parameters(&mut self, values: &[Vec<f64>]) {
        self.kernel = X::Kernel::<Lanes<S>>::with_values(&|i| Lanes::from_fn(|lane| values[lane][i]));
    }

    #[inline]
    fn advance(&mut self, wants_refill: bool) -> PauseReason {
        let token = self.token;
        token.vectorize(Run { steps: self, wants_refill })
    }
}
