//! Steps of which not every lane can simply go on.

use qrm_core::{Kernel, MOST_STRAIN, Mechanism};

use super::crowd::{Crowd, Taken};
use super::turnover::{pick, put};
use crate::lanes::{Lanes, Token};
use crate::motion::{Moment, advance};
use crate::outcome::{Status, Undefined};
use crate::simulate::locate;
use crate::solve::Care;
use crate::walk::single;

impl<X: Mechanism<N, M>, S: Token, const N: usize, const M: usize> Crowd<'_, X, S, N, M> {
    /// Takes up a step of which not every lane can simply go on.
    #[cold]
    #[inline(never)]
    pub(super) fn settle(&mut self, t_next: Lanes<S>, taken: &Taken<X, S, N, M>) {
        let before = (self.t, self.state);
        (self.t, self.state) = (t_next, taken.end);
        let sum = taken.end.checksum();
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
                        let outputs = self.outputs_at(design, &careful);
                        self.ranges.put(lane, &outputs);
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

    #[cold]
    #[inline(never)]
    pub(super) fn follow_carefully(&mut self, from: Lanes<S>, taken: &Taken<X, S, N, M>) {
        let before = std::mem::replace(&mut self.shadow, taken.end);
        let sum = taken.end.checksum();
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
}
