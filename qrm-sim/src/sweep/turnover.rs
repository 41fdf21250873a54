//! How designs come into lanes and leave them.

use qrm_core::{Angles, Fused, Kernel, Mechanism, State};

use super::crowd::{Crowd, Runner};
use super::{Finished, SweepEnd, alone};
use crate::assembly::assemble;
use crate::lanes::{Lanes, Token};
use crate::linear::largest;
use crate::motion::{Moment, moment};
use crate::outcome::{NoStart, Status, Undefined};
use crate::shadow::{LEVER, estimate};
use crate::simulate::Grid;
use crate::solve::Care;

impl<X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> Crowd<'_, X, S, N, M> {
    /// Gives waiting designs to lanes without one; where none waits, such a lane follows another.
    #[cold]
    #[inline(never)]
    pub(super) fn fill(&mut self) {
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
        // The first row stands at zero, however near the end is.
        let mut last = (grid.end_time / grid.step).floor().max(1.0);
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
        ] {
            values.set(lane, value);
        }
        let outputs = self.outputs_at(design, first);
        self.ranges.begin(lane, &outputs);
        self.lanes[lane] = Some(Runner { design, grid, has_shadow: self.request.estimate_error });
        if self.condition(design, first).is_some_and(|value| value >= 0.0) {
            self.finish(lane, Status::StoppedAtStart, first);
        }
    }

    pub(super) fn outputs_at(&self, design: usize, at: &Moment<N, M>) -> Vec<f64> {
        let mut outputs = vec![0.0; X::DESCRIPTION.outputs.len()];
        self.designs[design].outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut outputs);
        outputs
    }

    pub(super) fn put(&mut self, lane: usize, at: &Moment<N, M>) {
        put::<X, S, N, M>(&mut self.state, lane, at);
    }

    /// Notes what became of a lane's design, which ended at a moment.
    pub(super) fn finish(&mut self, lane: usize, status: Status, at: &Moment<N, M>) {
        let Some(runner) = self.lanes[lane].take() else { return };
        self.is_stale = true;
        if !status.is_done() || !self.ranges.is_defined(lane) {
            // A run of its own says when what went wrong.
            self.finished[runner.design] = Some(alone(runner.design, &self.designs[runner.design], self.request));
            return;
        }
        let outputs = self.outputs_at(runner.design, at);
        let status = match outputs.iter().position(|value| !value.is_finite()) {
            Some(output) => Status::NotFinite { t: at.t, what: Undefined::Output(output) },
            None => status,
        };
        let steps = self.made.get(lane) as u64;
        let (difference, size) = (self.difference.get(lane), self.size.get(lane).max(largest(&at.q).1));
        let is_known = runner.has_shadow && steps >= 2 && difference.is_finite();
        self.finished[runner.design] = Some(Finished {
            status: Ok(status),
            steps,
            end_time: at.t,
            q: at.q.to_vec(),
            qd: at.qd.to_vec(),
            extremes: self.ranges.of(lane, &outputs),
            estimated_error: is_known.then(|| estimate(difference / LEVER, size, steps)),
        });
    }
}

/// The state of a lane.
pub(super) fn pick<S: Token, const N: usize, const M: usize>(
    lane: usize,
    t: f64,
    at: &State<Lanes<S>, N, M>,
) -> Moment<N, M> {
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
pub(super) fn put<X: Mechanism<N, M>, S: Token, const N: usize, const M: usize>(
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
