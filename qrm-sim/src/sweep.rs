//! Many designs of one mechanism at once, in lanes: each lane makes the steps of one design until that has come to its end, and
//! then takes the next.

use std::io;

use qrm_mechanism::{Angles, Fused, Kernel, Lane, MOST_STRAIN, Mechanism, Real};

use crate::assembly::assemble;
use crate::lanes::{Lanes, Token};
use crate::linear::largest;
use crate::motion::{Method, Moment, advance, moment};
use crate::observer::{Observer, Row};
use crate::outcome::{NoStart, Status, Undefined};
use crate::shadow::{LEVER, estimate};
use crate::simulate::{End, Grid, Request, locate, simulate};
use crate::solve::Care;
use crate::stride::{LARGE, State, Stride, stride};
use crate::walk::single;

/// What every design of a sweep is asked to do.
pub struct SweepRequest<'a> {
    /// Length of the steps; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<SweepEnd<'a>>,
    /// Whether a second motion at twice the step estimates the error.
    pub estimate_error: bool,
}

/// Where designs end.
pub enum SweepEnd<'a> {
    /// At a time.
    Time(f64),
    /// When a function of the design's place, of time, coordinates and rates rises through zero.
    Condition(&'a DesignCondition<'a>),
}

/// A function of a design's place, of time, coordinates and rates.
pub type DesignCondition<'a> = dyn Fn(usize, f64, &[f64], &[f64]) -> f64 + Sync + 'a;

/// What became of a design.
#[derive(Debug)]
pub struct Finished {
    /// Why it ended; or why it could not begin.
    pub status: Result<Status, NoStart>,
    /// Steps made.
    pub steps: u64,
    /// Where it ended.
    pub end_time: f64,
    /// Coordinates there.
    pub q: Vec<f64>,
    /// Rates there.
    pub qd: Vec<f64>,
    /// Smallest and largest value of each output in any row.
    pub extremes: Vec<[f64; 2]>,
    /// Estimated largest error of a coordinate in any row.
    pub estimated_error: Option<f64>,
}

/// How many designs are made at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// As many as the processor has lanes for.
    Most,
    /// Four at most.
    Four,
    /// One.
    One,
}

/// Runs designs, each a mechanism with parameters of its own, and says what became of each, in their order.
pub fn sweep<X: Mechanism<N, M>, const N: usize, const M: usize>(
    designs: &[X],
    request: &SweepRequest,
    width: Width,
) -> Vec<Finished> {
    #[cfg(target_arch = "x86_64")]
    {
        // Constants, so that what is not used is not compiled: each set of instructions takes as long as the kernel is large.
        let four: Option<InLanes<X, pulp::x86::V3>> =
            const { if X::Kernel::<f64>::OPERATIONS <= LARGE { Some(in_four::<X, N, M>) } else { None } };
        let eight: Option<InLanes<X, pulp::x86::V4>> =
            const { if X::Kernel::<f64>::OPERATIONS <= HUGE { Some(in_eight::<X, N, M>) } else { None } };
        match (pulp::Arch::new(), width) {
            (pulp::Arch::V4(simd), Width::Most) => {
                if let Some(eight) = eight {
                    return eight(simd, designs, request);
                }
            }
            (pulp::Arch::V4(_) | pulp::Arch::V3(_), Width::Most | Width::Four) => {
                if let Some((four, simd)) = four.zip(pulp::x86::V3::try_new()) {
                    return four(simd, designs, request);
                }
            }
            _ => {}
        }
    }
    let _ = width;
    designs.iter().enumerate().map(|(place, design)| alone(place, design, request)).collect()
}

/// Runs designs in lanes.
#[cfg(target_arch = "x86_64")]
type InLanes<X, S> = fn(S, &[X], &SweepRequest) -> Vec<Finished>;

#[cfg(target_arch = "x86_64")]
fn in_four<X: Mechanism<N, M>, const N: usize, const M: usize>(
    simd: pulp::x86::V3,
    designs: &[X],
    request: &SweepRequest,
) -> Vec<Finished> {
    simd.vectorize(Crowd::<X, pulp::x86::V3, N, M>::new(designs, request))
}

#[cfg(target_arch = "x86_64")]
fn in_eight<X: Mechanism<N, M>, const N: usize, const M: usize>(
    simd: pulp::x86::V4,
    designs: &[X],
    request: &SweepRequest,
) -> Vec<Finished> {
    simd.vectorize(Crowd::<X, pulp::x86::V4, N, M>::new(designs, request))
}

/// Kernels of more operations are not compiled for lanes.
const HUGE: usize = 2000;

/// A design by a run of its own.
fn alone<X: Mechanism<N, M>, const N: usize, const M: usize>(
    place: usize,
    design: &X,
    request: &SweepRequest,
) -> Finished {
    let mut extremes = Extremes::default();
    let until = |t: f64, q: &[f64], qd: &[f64]| match request.end {
        Some(SweepEnd::Condition(condition)) => condition(place, t, q, qd),
        _ => 0.0,
    };
    let end = match request.end {
        None => None,
        Some(SweepEnd::Time(t)) => Some(End::Time(t)),
        Some(SweepEnd::Condition(_)) => Some(End::Condition(&until)),
    };
    let method = Method::default();
    let request = Request { method, step: request.step, end, estimate_error: request.estimate_error };
    match simulate(design, &request, &mut extremes) {
        Err(reason) => Finished::unable(Err(reason)),
        Ok(outcome) => Finished {
            status: Ok(outcome.status),
            steps: outcome.counts.accepted,
            end_time: outcome.end_time,
            q: outcome.q,
            qd: outcome.qd,
            extremes: extremes.0,
            estimated_error: outcome.estimated_error,
        },
    }
}

/// Smallest and largest value of each output.
#[derive(Default)]
struct Extremes(Vec<[f64; 2]>);

impl Observer for Extremes {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        if self.0.is_empty() {
            self.0 = row.outputs.iter().map(|value| [*value; 2]).collect();
        }
        for (extremes, value) in self.0.iter_mut().zip(row.outputs) {
            *extremes = [extremes[0].min(*value), extremes[1].max(*value)];
        }
        Ok(())
    }

    fn goes_on(&mut self, _: f64, _: f64) -> io::Result<bool> {
        Ok(true)
    }

    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Designs under way.
struct Crowd<'a, X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> {
    designs: &'a [X],
    request: &'a SweepRequest<'a>,
    method: Method,
    /// The next design that waits.
    next: usize,
    finished: Vec<Option<Finished>>,
    /// The design of each lane; `None` in lanes that follow another for want of one.
    lanes: Vec<Option<Runner>>,
    parameters: Vec<Vec<f64>>,
    kernel: X::Kernel<Lanes<S>>,
    /// Steps made, and steps to the end.
    made: Lanes<S>,
    last: Lanes<S>,
    t: Lanes<S>,
    step: Lanes<S>,
    end_time: Lanes<S>,
    state: State<Lanes<S>, N, M>,
    /// The motion at twice the step.
    shadow: State<Lanes<S>, N, M>,
    difference: Lanes<S>,
    size: Lanes<S>,
    outputs: Vec<Lanes<S>>,
    lowest: Vec<Lanes<S>>,
    highest: Vec<Lanes<S>>,
    /// Not a number in lanes in which an output was none.
    defined: Lanes<S>,
    /// Whether a lane has lost its design.
    is_stale: bool,
}

/// Which motion makes a step.
#[derive(Clone, Copy)]
enum Turn {
    Step,
    Shadow,
}

/// A design in a lane.
struct Runner {
    design: usize,
    grid: Grid,
    /// Whether the motion at twice the step goes on.
    has_shadow: bool,
}

impl<X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> pulp::NullaryFnOnce for Crowd<'_, X, S, N, M> {
    type Output = Vec<Finished>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.run()
    }
}

type Number<S> = Lanes<S>;

/// A step in lanes.
type Taken<X, S, const N: usize, const M: usize> =
    Stride<Lanes<S>, <<X as Mechanism<N, M>>::Kernel<Lanes<S>> as Kernel<Lanes<S>, N, M>>::Position, N, M>;

impl<'a, X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> Crowd<'a, X, S, N, M> {
    #[inline(always)]
    fn new(designs: &'a [X], request: &'a SweepRequest<'a>) -> Self {
        let zero = Number::<S>::zero();
        let state = State {
            q: [zero; N],
            qd: [zero; N],
            qdd: [zero; N],
            multipliers: [zero; M],
            angles: Angles { sin: [zero; N], cos: [zero; N] },
        };
        let outputs = X::DESCRIPTION.outputs.len();
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
            outputs: vec![zero; outputs],
            lowest: vec![zero; outputs],
            highest: vec![zero; outputs],
            defined: zero,
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
                let next = self.made + Number::from_f64(1.0);
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
            && taken.strain.is_within(MOST_STRAIN)
            && taken.residual.is_within(self.method.tolerance.residual)
            && checksum(&taken.end).is_within(0.0);
        self.made = next;
        let State { q, qd, qdd, multipliers, angles } = &taken.end;
        self.kernel.outputs_at(&taken.position, t_next, q, qd, angles, qdd, multipliers, &mut self.outputs);
        if goes_on {
            (self.t, self.state) = (t_next, taken.end);
        } else {
            self.settle(t_next, &taken);
        }
        let mut defined = self.defined;
        for ((value, lowest), highest) in self.outputs.iter().zip(&mut self.lowest).zip(&mut self.highest) {
            *lowest = lowest.min(*value);
            *highest = highest.max(*value);
            defined = value.mul_add(Number::zero(), defined);
        }
        self.defined = defined;
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

    fn condition(&self, design: usize, at: &Moment<N, M>) -> Option<f64> {
        match self.request.end {
            Some(SweepEnd::Time(_)) => None,
            Some(SweepEnd::Condition(condition)) => Some(condition(design, at.t, &at.q, &at.qd)),
            None => self.designs[design].stop(at.t, &at.q, &at.qd),
        }
    }

    /// Takes up a step of which not every lane can simply go on.
    #[cold]
    #[inline(never)]
    fn settle(&mut self, t_next: Lanes<S>, taken: &Taken<X, S, N, M>) {
        let before = (self.t, self.state);
        (self.t, self.state) = (t_next, taken.end);
        let sum = checksum(&taken.end);
        for lane in 0..Lanes::<S>::COUNT {
            let Some(runner) = &mut self.lanes[lane] else { continue };
            let (design, grid) = (runner.design, runner.grid);
            let from = pick(lane, before.0.get(lane), &before.1);
            let mut next = pick(lane, self.t.get(lane), &taken.end);
            let is_good = taken.strain.get(lane).abs() <= MOST_STRAIN
                && taken.residual.get(lane) <= self.method.tolerance.residual
                && sum.get(lane) == 0.0;
            if !is_good {
                match advance(&self.designs[design], &self.method, &from, next.t, &mut Care::default()) {
                    Ok(careful) => {
                        next = careful;
                        self.put(lane, &careful);
                        for (i, value) in self.outputs_at(design, &careful).into_iter().enumerate() {
                            self.outputs[i].set(lane, value);
                        }
                    }
                    Err(breakdown) => {
                        self.finish(lane, Status::Broken(breakdown), &from);
                        continue;
                    }
                }
            }
            let condition = self.condition(design, &next);
            let ended = match condition {
                Some(value) if value.is_nan() => {
                    Err((Status::NotFinite { t: next.t, what: Undefined::Condition }, from))
                }
                Some(value) if value >= 0.0 => {
                    self.locate((lane, design), &from, &next).map(|at| Some((Status::Stopped, at)))
                }
                _ if next.t >= grid.end_time => Ok(Some((
                    match condition {
                        Some(missing) => Status::StopNotReached { nearest_time: next.t, missing: -missing },
                        None => Status::Completed,
                    },
                    next,
                ))),
                _ => Ok(None),
            };
            match ended {
                Ok(None) => {}
                Ok(Some((status, at))) => self.finish(lane, status, &at),
                Err((status, at)) => self.finish(lane, status, &at),
            }
        }
    }

    fn locate(
        &self,
        (lane, design): (usize, usize),
        from: &Moment<N, M>,
        beyond: &Moment<N, M>,
    ) -> Result<Moment<N, M>, (Status, Moment<N, M>)> {
        let value = |at: &Moment<N, M>| self.condition(design, at).unwrap_or(0.0);
        let kernel = X::Kernel::<f64>::with_values(|i| self.parameters[lane][i]);
        let step = |t: f64| single(&self.designs[design], &kernel, &self.method, from, t, &mut Care::default());
        locate(from, beyond, value, step).map_err(|breakdown| (Status::Broken(breakdown), *from))
    }

    /// Takes a step of the motion at twice the step, from the time before the last two steps.
    #[inline(always)]
    fn follow(&mut self, from: Lanes<S>, taken: Taken<X, S, N, M>) {
        let is_good = taken.strain.is_within(MOST_STRAIN)
            && taken.residual.is_within(self.method.tolerance.residual)
            && checksum(&taken.end).is_within(0.0);
        if is_good {
            self.shadow = taken.end;
        } else {
            self.follow_carefully(from, &taken);
        }
        for i in 0..N {
            self.difference = (self.shadow.q[i] - self.state.q[i]).abs().max(self.difference);
            self.size = self.state.q[i].abs().max(self.size);
        }
    }

    #[cold]
    #[inline(never)]
    fn follow_carefully(&mut self, from: Lanes<S>, taken: &Taken<X, S, N, M>) {
        let before = std::mem::replace(&mut self.shadow, taken.end);
        let sum = checksum(&taken.end);
        for lane in 0..Lanes::<S>::COUNT {
            let Some(runner) = &mut self.lanes[lane] else { continue };
            let is_good = taken.strain.get(lane).abs() <= MOST_STRAIN
                && taken.residual.get(lane) <= self.method.tolerance.residual
                && sum.get(lane) == 0.0;
            if is_good || !runner.has_shadow {
                continue;
            }
            let at = pick(lane, from.get(lane), &before);
            let design = &self.designs[runner.design];
            match advance(design, &self.method, &at, self.t.get(lane), &mut Care::default()) {
                Ok(careful) => put::<X, S, N, M>(&mut self.shadow, lane, &careful),
                Err(_) => {
                    runner.has_shadow = false;
                    // Any state will do that makes no trouble.
                    let own = pick(lane, self.t.get(lane), &self.state);
                    put::<X, S, N, M>(&mut self.shadow, lane, &own);
                }
            }
        }
    }

    /// Gives waiting designs to lanes without one; where none waits, such a lane follows another.
    #[cold]
    #[inline(never)]
    fn fill(&mut self) {
        self.is_stale = false;
        for lane in 0..Lanes::<S>::COUNT {
            while self.lanes[lane].is_none() && self.next < self.designs.len() {
                let design = self.next;
                self.next += 1;
                match self.begin(design) {
                    Ok((grid, first)) => self.enter(lane, design, grid, &first),
                    Err(reason) => self.finished[design] = Some(Finished::unable(Err(reason))),
                }
            }
        }
        let Some(leader) = self.lanes.iter().position(Option::is_some) else { return };
        for lane in 0..Lanes::<S>::COUNT {
            if self.lanes[lane].is_none() {
                self.parameters[lane] = self.parameters[leader].clone();
                let at = pick(leader, self.t.get(leader), &self.state);
                self.put(lane, &at);
                put::<X, S, N, M>(&mut self.shadow, lane, &at);
                for values in [&mut self.made, &mut self.last, &mut self.t, &mut self.step, &mut self.end_time] {
                    values.set(lane, values.get(leader));
                }
            }
        }
        self.kernel = X::Kernel::<Lanes<S>>::with_values(|i| Lanes::from_fn(|lane| self.parameters[lane][i]));
    }

    fn begin(&self, design: usize) -> Result<(Grid, Moment<N, M>), NoStart> {
        let mechanism = &self.designs[design];
        let schedule = mechanism.schedule();
        let step = self.request.step.unwrap_or(schedule.step);
        let end_time = match self.request.end {
            Some(SweepEnd::Time(t)) => t,
            _ => schedule.end_time,
        };
        if step <= end_time * f64::EPSILON {
            return Err(NoStart::StepTooShort { step, end_time });
        }
        let (q, qd) = assemble(mechanism, &mechanism.start()).map_err(NoStart::NotAssembled)?;
        let first = moment(mechanism, 0.0, q, qd, &mut Care::default()).map_err(NoStart::Broken)?;
        if self.condition(design, &first).is_some_and(|value| !value.is_finite()) {
            return Err(NoStart::ConditionNotFinite);
        }
        Ok((Grid { step, end_time }, first))
    }

    fn enter(&mut self, lane: usize, design: usize, grid: Grid, first: &Moment<N, M>) {
        let mut values = Vec::new();
        self.designs[design].visit_parameters(&mut |value| values.push(value));
        self.parameters[lane] = values;
        self.put(lane, first);
        put::<X, S, N, M>(&mut self.shadow, lane, first);
        let mut last = (grid.end_time / grid.step).floor();
        while grid.time(last as u64) < grid.end_time {
            last += 1.0;
        }
        for (values, value) in [
            (&mut self.made, 0.0),
            (&mut self.last, last),
            (&mut self.t, 0.0),
            (&mut self.step, grid.step),
            (&mut self.end_time, grid.end_time),
            (&mut self.difference, 0.0),
            (&mut self.size, largest(&first.q).1),
            (&mut self.defined, 0.0),
        ] {
            values.set(lane, value);
        }
        let outputs = self.outputs_at(design, first);
        for (i, value) in outputs.into_iter().enumerate() {
            self.lowest[i].set(lane, value);
            self.highest[i].set(lane, value);
            let sum = self.defined.get(lane) + 0.0 * value;
            self.defined.set(lane, sum);
        }
        self.lanes[lane] = Some(Runner { design, grid, has_shadow: self.request.estimate_error });
        if self.condition(design, first).is_some_and(|value| value >= 0.0) {
            self.finish(lane, Status::StoppedAtStart, first);
        }
    }

    fn outputs_at(&self, design: usize, at: &Moment<N, M>) -> Vec<f64> {
        let mut outputs = vec![0.0; X::DESCRIPTION.outputs.len()];
        self.designs[design].outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut outputs);
        outputs
    }

    fn put(&mut self, lane: usize, at: &Moment<N, M>) {
        put::<X, S, N, M>(&mut self.state, lane, at);
    }

    /// Notes what became of a lane's design, which ended at a moment.
    fn finish(&mut self, lane: usize, status: Status, at: &Moment<N, M>) {
        let Some(runner) = self.lanes[lane].take() else { return };
        self.is_stale = true;
        let outputs = self.outputs_at(runner.design, at);
        let undefined = outputs.iter().position(|value| !value.is_finite());
        let status = match undefined.or((!(self.defined.get(lane) == 0.0)).then_some(0)) {
            Some(output) => Status::NotFinite { t: at.t, what: Undefined::Output(output) },
            None => status,
        };
        let extremes = outputs
            .iter()
            .enumerate()
            .map(|(i, value)| [self.lowest[i].get(lane).min(*value), self.highest[i].get(lane).max(*value)]);
        let steps = self.made.get(lane) as u64;
        let (difference, size) = (self.difference.get(lane), self.size.get(lane).max(largest(&at.q).1));
        let is_known = runner.has_shadow && steps >= 2 && difference.is_finite();
        self.finished[runner.design] = Some(Finished {
            status: Ok(status),
            steps,
            end_time: at.t,
            q: at.q.to_vec(),
            qd: at.qd.to_vec(),
            extremes: extremes.collect(),
            estimated_error: is_known.then(|| estimate(difference / LEVER, size, steps)),
        });
    }
}

impl Finished {
    /// A design that did not begin.
    fn unable(status: Result<Status, NoStart>) -> Self {
        Self {
            status,
            steps: 0,
            end_time: 0.0,
            q: Vec::new(),
            qd: Vec::new(),
            extremes: Vec::new(),
            estimated_error: None,
        }
    }
}

/// Not zero in lanes in which a number of a state is not finite.
#[inline(always)]
fn checksum<S: Token, const N: usize, const M: usize>(at: &State<Lanes<S>, N, M>) -> Lanes<S> {
    let mut sum = Number::<S>::zero();
    for i in 0..N {
        sum = sum + at.qdd[i];
    }
    for k in 0..M {
        sum = sum + at.multipliers[k];
    }
    sum * Number::zero()
}

/// The state of a lane.
fn pick<S: Token, const N: usize, const M: usize>(lane: usize, t: f64, at: &State<Lanes<S>, N, M>) -> Moment<N, M> {
    Moment {
        t,
        q: at.q.map(|value| value.get(lane)),
        qd: at.qd.map(|value| value.get(lane)),
        qdd: at.qdd.map(|value| value.get(lane)),
        multipliers: at.multipliers.map(|value| value.get(lane)),
        corrections: 0,
    }
}

/// Gives a lane another state.
fn put<X: Mechanism<N, M>, S: Token, const N: usize, const M: usize>(
    state: &mut State<Lanes<S>, N, M>,
    lane: usize,
    at: &Moment<N, M>,
) {
    let angles = Angles::new(&at.q.map(Fused), X::Kernel::<Fused>::IS_ANGLE);
    for i in 0..N {
        state.q[i].set(lane, at.q[i]);
        state.qd[i].set(lane, at.qd[i]);
        state.qdd[i].set(lane, at.qdd[i]);
        state.angles.sin[i].set(lane, angles.sin[i].0);
        state.angles.cos[i].set(lane, angles.cos[i].0);
    }
    for k in 0..M {
        state.multipliers[k].set(lane, at.multipliers[k]);
    }
}
