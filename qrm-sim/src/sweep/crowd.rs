//! Designs under way in lanes: the steps that all lanes make together.

use qrm_core::{Angles, Kernel, Mechanism, Scalar, State, Stride, stride};

use super::ranges::Ranges;
use super::turnover::pick;
use super::{Finished, SweepEnd, SweepRequest};
use crate::lanes::{Lanes, Token};
use crate::motion::{Method, Moment};
use crate::simulate::Grid;

/// Designs under way.
pub(super) struct Crowd<'a, X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> {
    pub(super) designs: &'a [X],
    pub(super) request: &'a SweepRequest<'a>,
    pub(super) method: Method,
    /// The next design that waits.
    pub(super) next: usize,
    pub(super) finished: Vec<Option<Finished>>,
    /// The design of each lane; `None` in lanes that follow another for want of one.
    pub(super) lanes: Vec<Option<Runner>>,
    pub(super) parameters: Vec<Vec<f64>>,
    pub(super) kernel: X::Kernel<Lanes<S>>,
    /// Steps made, and steps to the end.
    pub(super) made: Lanes<S>,
    pub(super) last: Lanes<S>,
    pub(super) t: Lanes<S>,
    pub(super) step: Lanes<S>,
    pub(super) end_time: Lanes<S>,
    pub(super) state: State<Lanes<S>, N, M>,
    /// The motion at twice the step.
    pub(super) shadow: State<Lanes<S>, N, M>,
    pub(super) difference: Lanes<S>,
    pub(super) size: Lanes<S>,
    /// Of the outputs.
    pub(super) ranges: Ranges<S>,
    /// Whether a lane has lost its design.
    pub(super) is_stale: bool,
}

/// Which motion makes a step.
#[derive(Clone, Copy)]
enum Turn {
    Step,
    Shadow,
}

/// A design in a lane.
pub(super) struct Runner {
    pub(super) design: usize,
    pub(super) grid: Grid,
    /// Whether the motion at twice the step goes on.
    pub(super) has_shadow: bool,
}

impl<X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> pulp::NullaryFnOnce for Crowd<'_, X, S, N, M> {
    type Output = Vec<Finished>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.run()
    }
}

/// A step in lanes.
pub(super) type Taken<X, S, const N: usize, const M: usize> =
    Stride<Lanes<S>, <<X as Mechanism<N, M>>::Kernel<Lanes<S>> as Kernel<Lanes<S>, N, M>>::Position, N, M>;

impl<'a, X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> Crowd<'a, X, S, N, M> {
    #[inline(always)]
    pub(super) fn new(designs: &'a [X], request: &'a SweepRequest<'a>) -> Self {
        let zero = Lanes::<S>::zero();
        let state = State {
            q: [zero; N],
            qd: [zero; N],
            qdd: [zero; N],
            multipliers: [zero; M],
            angles: Angles { sin: [zero; N], cos: [zero; N] },
        };
        let outputs = if request.extremes { X::DESCRIPTION.outputs.len() } else { 0 };
        Self {
            designs,
            request,
            method: Method::default(),
            next: 0,
            finished: designs.iter().map(|_| None).collect(),
            lanes: (0..Lanes::<S>::COUNT).map(|_| None).collect(),
            parameters: vec![vec![0.0; X::DESCRIPTION.parameters.len()]; Lanes::<S>::COUNT],
            kernel: X::Kernel::<Lanes<S>>::with_values(|_| zero),
            made: zero,
            last: zero,
            t: zero,
            step: zero,
            end_time: zero,
            state,
            shadow: state,
            difference: zero,
            size: zero,
            ranges: Ranges::new(outputs),
            is_stale: false,
        }
    }

    #[inline(always)]
    fn run(mut self) -> Vec<Finished> {
        self.fill();
        while self.lanes.iter().any(Option::is_some) {
            // Two steps, beside which the other motion makes one. One call makes them all: the step is long when it is compiled.
            let from = self.t;
            let [both, one] = [[Turn::Step, Turn::Step, Turn::Shadow], [Turn::Step; 3]];
            for turn in if self.request.estimate_error { both } else { one } {
                let next = self.made + Lanes::from_f64(1.0);
                let (t, t_next, state) = match turn {
                    Turn::Step => {
                        (self.t, (next - self.last).choose(0.25, self.end_time, next * self.step), &self.state)
                    }
                    Turn::Shadow => (from, self.t, &self.shadow),
                };
                let taken = stride(&self.kernel, t, t_next - t, state);
                match turn {
                    Turn::Step => self.advance(next, t_next, taken),
                    Turn::Shadow => self.follow(from, taken),
                }
            }
            if self.is_stale {
                self.fill();
            }
        }
        self.finished.into_iter().flatten().collect()
    }

    /// Takes a step in every lane.
    #[inline(always)]
    fn advance(&mut self, next: Lanes<S>, t_next: Lanes<S>, taken: Taken<X, S, N, M>) {
        let condition = self.conditions(t_next, &taken.end);
        let goes_on = (next - self.last).is_negative()
            && condition.is_none_or(Lanes::is_negative)
            && taken.is_good(self.method.tolerance.residual);
        self.made = next;
        if self.request.extremes {
            let State { q, qd, qdd, multipliers, angles } = &taken.end;
            let outputs = &mut self.ranges.outputs;
            self.kernel.outputs_at(&taken.position, t_next, q, qd, angles, qdd, multipliers, outputs);
        }
        if goes_on {
            (self.t, self.state) = (t_next, taken.end);
        } else {
            self.settle(t_next, &taken);
        }
        self.ranges.widen();
    }

    /// How far the stop condition is from true, if it can be told in lanes.
    #[inline(always)]
    fn conditions(&self, t: Lanes<S>, at: &State<Lanes<S>, N, M>) -> Option<Lanes<S>> {
        match self.request.end {
            Some(SweepEnd::Time(_)) => None,
            Some(SweepEnd::Condition(_)) => Some(Lanes::from_fn(|lane| {
                let at = pick(lane, t.get(lane), at);
                let design = self.lanes[lane].as_ref().map(|runner| runner.design);
                design.and_then(|design| self.condition(design, &at)).unwrap_or(-1.0)
            })),
            None => self.kernel.ending(t, &at.q, &at.qd),
        }
    }

    pub(super) fn condition(&self, design: usize, at: &Moment<N, M>) -> Option<f64> {
        match self.request.end {
            Some(SweepEnd::Time(_)) => None,
            Some(SweepEnd::Condition(condition)) => Some(condition(design, at.t, &at.q, &at.qd)),
            None => self.designs[design].stop(at.t, &at.q, &at.qd),
        }
    }

    /// Takes a step of the motion at twice the step, from the time before the last two steps.
    #[inline(always)]
    fn follow(&mut self, from: Lanes<S>, taken: Taken<X, S, N, M>) {
        if taken.is_good(self.method.tolerance.residual) {
            self.shadow = taken.end;
        } else {
            self.follow_carefully(from, &taken);
        }
        for i in 0..N {
            self.difference = (self.shadow.q[i] - self.state.q[i]).abs().max(self.difference);
            self.size = self.state.q[i].abs().max(self.size);
        }
    }
}
