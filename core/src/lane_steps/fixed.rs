//! Steps of order 4 and of a fixed length, with those of companions.

use super::{Motion, StepsBy};
use crate::batch::{DEFINED, DIFFERENCES, END_TIME, EVENT, LAST, LaneRole, MADE, PauseReason, QUALITY, STEP};
use crate::kernel::{Generated, Kernel};
use crate::lanes::{Lanes, Token};
use crate::rk4::{KernelState, rk4_step};
use crate::scalar::Scalar;

/// The sequence of steps where errors are estimated: three steps take as long as two of the companion.
const SEQUENCE: [LaneRole; 5] = {
    use LaneRole::{Companion, Main};
    [Main, Main, Main, Companion, Companion]
};

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> StepsBy<X, S, N, M> {
    /// Makes steps until some lane cannot simply go on: see [`LaneSteps::advance`].
    #[inline(always)]
    pub(super) fn run_fixed(&mut self, wants_refill: bool) -> PauseReason {
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
}
