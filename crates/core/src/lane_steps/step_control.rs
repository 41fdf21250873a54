//! Steps of order 8: each lane chooses its own length by its own tolerance.

use super::{LaneMotion, StepsBy};
use crate::dop853::{Slopes, dop853_step};
use crate::kernel::Kernel;
use crate::kernel_state::KernelState;
use crate::lane_layout::{
    CHANGES, CHECKPOINT_STEP, COORDINATE_RANGES, END_TIME, EVENT, LONGEST, MAX_STEPS, QUALITY, REJECTED, SAFETY,
    SHORTEST, STEP, STEPS_MADE, TOLERANCE,
};
use crate::lanes::{Lanes, Token};
use crate::scalar::Scalar;

impl<K: Kernel<Lanes<S>, N, M>, S: Token, const N: usize, const M: usize> StepsBy<K, S, N, M> {
    /// Makes steps until some lane needs its caller: see [`LaneSteps::advance`](super::LaneSteps::advance).
    #[inline(always)]
    pub(super) fn make_steps(&mut self) {
        let number = Lanes::from_f64;
        let layout = self.layout();
        self.set_kernel();
        let [n, _] = self.kernel.sizes();
        let [mut made, mut step] = [self.number(STEPS_MADE), self.number(STEP)];
        let [longest, end_time] = [self.number(LONGEST), self.number(END_TIME)];
        let [tolerance, max_steps] = [self.number(TOLERANCE), self.number(MAX_STEPS)];
        let most_growth = self.request.most_growth();
        let mut motion = self.motion();
        let mut slopes = Slopes::zero();
        loop {
            let left = end_time - motion.t;
            let h = step.min(longest).min(left);
            let time = (motion.t, h);
            let mut attempt = dop853_step(&self.kernel, time, &motion.state, tolerance, &mut slopes);
            let error = attempt.error;
            let chosen = |accepted, rejected| error.choose(REJECTED, accepted, rejected);
            let eighth_root = error.max(number(1e-30)).sqrt().sqrt().sqrt();
            let change = (number(SAFETY) / eighth_root).min(number(CHANGES[1])).max(number(CHANGES[0]));
            // An error that is not a number is within no bound.
            step = h * error.choose(f64::MAX, change, number(CHANGES[0]));
            let t = chosen((h - left).choose(0.0, end_time, motion.t + h), motion.t);
            let end = motion.state.replaced(&attempt.result.end, chosen);
            let event = if self.request.watches_event {
                chosen(self.largest_event((t, h), &motion.state, &end), number(-1.0))
            } else {
                number(-1.0)
            };
            if self.request.ranges {
                self.accept_ranges();
                self.find_ranges(time, &motion.state, &mut attempt);
            }
            let result = &attempt.result;
            let before = motion;
            motion = LaneMotion { t, state: end };
            made = made + chosen(number(1.0), Lanes::zero());
            if self.request.checkpoints {
                for i in 0..n {
                    let [lowest, highest] = [COORDINATE_RANGES + i, COORDINATE_RANGES + n + i];
                    let q = motion.state.q[i];
                    self.set_number(lowest, q.min(self.number(lowest)));
                    self.set_number(highest, q.max(self.number(highest)));
                }
                self.store_checkpoint(made, &motion);
            }
            let mut quality = [result.growth_factor, result.residual, result.end.finite_check()];
            for number in &mut quality {
                *number = chosen(*number, Lanes::zero());
            }
            let is_stuck = (number(SHORTEST) * end_time - step).max(made - max_steps);
            let keep_running = (t - end_time).max(event).max(is_stuck).is_negative()
                && quality[0].is_within(most_growth)
                && quality[1].is_within(self.residual)
                && quality[2].is_within(0.0)
                && !self.request.waits_each_step;
            if !keep_running {
                self.set_row(layout.row_before(), &before);
                self.set_row(layout.row(), &motion);
                for (place, value) in [(STEPS_MADE, made), (STEP, step), (EVENT, event)] {
                    self.set_number(place, value);
                }
                for i in 0..3 {
                    self.set_number(QUALITY + i, quality[i]);
                }
                return;
            }
        }
    }

    /// The largest value of the scene's event at the end of a step and at the control points of the polynomial of degree 5
    /// between both ends: a bound of an event that is a convex function of the coordinates.
    #[inline(always)]
    fn largest_event(
        &self,
        (t, h): (Lanes<S>, Lanes<S>),
        begin: &KernelState<Lanes<S>, N, M>,
        end: &KernelState<Lanes<S>, N, M>,
    ) -> Lanes<S> {
        let value = |q: &[Lanes<S>; N]| {
            let value = self.kernel.event(t, q, &end.qd, &end.qdd, &end.multipliers);
            value.unwrap_or_else(|| Lanes::from_f64(-1.0))
        };
        let mut largest = value(&end.q);
        for (state, h) in [(begin, h), (end, -h)] {
            for part in [0.2, 0.4] {
                let first = h * Lanes::from_f64(part);
                // One twentieth for the second control point, nothing for the first one.
                let second = h * h * Lanes::from_f64(0.25 * (part - 0.2));
                let mut q = state.q;
                for i in 0..self.kernel.sizes()[0] {
                    q[i] = q[i] + first * state.qd[i] + second * state.qdd[i];
                }
                largest = largest.max(value(&q));
            }
        }
        largest
    }

    /// Stores the motion of the lanes that have reached their next checkpoint.
    #[inline(always)]
    fn store_checkpoint(&mut self, made: Lanes<S>, motion: &LaneMotion<S, N, M>) {
        let next = self.number(CHECKPOINT_STEP);
        let chosen = |kept, other| (next - made).choose(0.0, kept, other);
        let [row, before] = [self.layout().checkpoint(0), self.layout().checkpoint(1)];
        self.set_number(CHECKPOINT_STEP, chosen(next + next, next));
        let [n, _] = self.kernel.sizes();
        for i in 0..=2 * n {
            let (last, kept) = (self.number(row + i), self.number(before + i));
            self.set_number(before + i, chosen(last, kept));
        }
        self.set_number(row, chosen(motion.t, self.number(row)));
        for i in 0..n {
            let [q, qd] = [row + 1 + i, row + 1 + n + i];
            self.set_number(q, chosen(motion.state.q[i], self.number(q)));
            self.set_number(qd, chosen(motion.state.qd[i], self.number(qd)));
        }
    }
}
