//! A run from start to end: grid of steps, stop condition, rows for an observer, what can be said of the errors.

use std::time::{Duration, Instant};

use qrm_mechanism::Mechanism;

use crate::assembly::assemble;
use crate::book::Book;
use crate::motion::{Breakdown, Method, Moment, advance, moment};
use crate::observer::Observer;
use crate::outcome::{NoStart, Outcome, Status, Undefined};
use crate::shadow::Shadow;
use crate::solve::Care;
use crate::stepper::Stepper;

/// How many steps are made between two visits to the observer.
const CHUNK: usize = 1024;

/// What a run is asked to do.
pub struct Request<'a> {
    /// How steps are made.
    pub method: Method,
    /// Their length; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<End<'a>>,
    /// Whether a second run at twice the step estimates the error.
    pub estimate_error: bool,
}

/// Where a run ends.
pub enum End<'a> {
    /// At a time.
    Time(f64),
    /// When a function rises through zero.
    Condition(&'a StopFunction<'a>),
}

/// A function of time, coordinates and rates.
pub type StopFunction<'a> = dyn Fn(f64, &[f64], &[f64]) -> f64 + 'a;

/// Runs a mechanism.
///
/// # Errors
/// The run could not begin. A run that began always has an [`Outcome`].
pub fn simulate<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Outcome, NoStart> {
    let schedule = mechanism.schedule();
    let step = request.step.unwrap_or(schedule.step);
    let end_time = match request.end {
        Some(End::Time(t)) => t,
        _ => schedule.end_time,
    };
    if step <= end_time * f64::EPSILON {
        return Err(NoStart::StepTooShort { step, end_time });
    }
    let (q, qd) = assemble(mechanism, &mechanism.start()).map_err(NoStart::NotAssembled)?;
    let mut care = Care::default();
    let first = moment(mechanism, 0.0, q, qd, &mut care).map_err(NoStart::Broken)?;
    let mut run = Run {
        mechanism,
        request,
        grid: Grid { step, end_time },
        stepper: Stepper::new(mechanism, request.method.scheme, first, end_time, &mut care).map_err(NoStart::Broken)?,
        shadow: request.estimate_error.then(|| Shadow::new(mechanism, &request.method, first, end_time)).flatten(),
        book: Book::new(mechanism, &first),
        care,
    };
    if run.condition(&first).is_some_and(|value| !value.is_finite()) {
        return Err(NoStart::ConditionNotFinite);
    }
    Ok(run.run(first, observer))
}

/// The times of the steps: multiples of the step, and the end.
#[derive(Clone, Copy)]
struct Grid {
    step: f64,
    end_time: f64,
}

impl Grid {
    /// The time after `n` steps; a remainder far below a step belongs to the last one.
    fn time(&self, n: u64) -> f64 {
        let t = n as f64 * self.step;
        if t >= self.end_time - 1e-9 * self.step { self.end_time } else { t }
    }
}

struct Run<'a, X, const N: usize, const M: usize> {
    mechanism: &'a X,
    request: &'a Request<'a>,
    grid: Grid,
    stepper: Stepper<N, M>,
    /// The second run, which tells the error.
    shadow: Option<Shadow<N, M>>,
    book: Book,
    care: Care,
}

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Run<'_, X, N, M> {
    fn run(&mut self, first: Moment<N, M>, observer: &mut dyn Observer) -> Outcome {
        let mut rows: Vec<Moment<N, M>> = Vec::with_capacity(CHUNK + 1);
        rows.push(first);
        // The end of the rows that were kept, and the end of what was computed.
        let mut kept_until = first;
        let mut now = first;
        let mut steps = 0;
        let mut nearest = (0.0, self.condition(&first).unwrap_or(0.0));
        let mut integration = Duration::ZERO;
        // Other methods inside its loop would slow down the one that does the least work in a step.
        let chunk = if matches!(self.stepper, Stepper::Fixed) { Self::chunk::<true> } else { Self::chunk::<false> };
        let mut status = (nearest.1 >= 0.0 && self.condition(&first).is_some()).then_some(Status::StoppedAtStart);
        loop {
            let begun = Instant::now();
            if status.is_none() {
                status = chunk(self, &mut now, &mut steps, &mut nearest, &mut rows);
            }
            integration += begun.elapsed();
            if let Some(shadow) = &mut self.shadow {
                let grid = self.grid;
                shadow.follow(self.mechanism, &rows, |row, at| at.t == grid.time(row));
            }
            let kept_before = self.book.rows;
            let kept = self.book.keep(self.mechanism, &rows, observer);
            if kept.is_err() {
                // The run ends with its last row, however much further the computation had come.
                let last = ((self.book.rows - kept_before) as usize).checked_sub(1);
                now = last.map_or(kept_until, |last| rows[last]);
                steps = self.book.rows.saturating_sub(1);
            }
            kept_until = now;
            rows.clear();
            let goes_on = kept.and_then(|()| observer.goes_on(now.t, self.grid.end_time).map_err(Status::Unwritable));
            match goes_on {
                Err(ending) => status = Some(ending),
                Ok(false) if status.is_none() => status = Some(Status::Interrupted),
                Ok(_) => {}
            }
            if let Some(status) = status {
                let status = observer.finish().map_or_else(Status::Unwritable, |()| status);
                return self.outcome(status, now, steps, integration);
            }
        }
    }

    /// Makes rows until there is room for no more; the end of the run, if it comes.
    fn chunk<const IS_RK4: bool>(
        &mut self,
        now: &mut Moment<N, M>,
        steps: &mut u64,
        nearest: &mut (f64, f64),
        rows: &mut Vec<Moment<N, M>>,
    ) -> Option<Status> {
        let mut status = None;
        while status.is_none() && rows.len() < CHUNK {
            status = self.step::<IS_RK4>(now, steps, nearest).err();
            if !matches!(status, Some(Status::Broken(_) | Status::NotFinite { .. })) {
                rows.push(*now);
            }
        }
        status
    }

    /// How far the stop condition is from true (negative), if there is one.
    #[inline(always)]
    fn condition(&self, at: &Moment<N, M>) -> Option<f64> {
        match self.request.end {
            Some(End::Time(_)) => None,
            Some(End::Condition(condition)) => Some(condition(at.t, &at.q, &at.qd)),
            None => self.mechanism.stop(at.t, &at.q, &at.qd),
        }
    }

    /// Makes a step, or part of one up to the stop condition; an error is the end of the run.
    #[inline(always)]
    fn step<const IS_RK4: bool>(
        &mut self,
        now: &mut Moment<N, M>,
        steps: &mut u64,
        nearest: &mut (f64, f64),
    ) -> Result<(), Status> {
        let t_next = self.grid.time(*steps + 1);
        let (method, care) = (&self.request.method, &mut self.care);
        let next = match IS_RK4 {
            true => advance(self.mechanism, method, now, t_next, care),
            false => self.stepper.next(self.mechanism, method, now, t_next, care),
        };
        let next = next.map_err(Status::Broken)?;
        let condition = self.condition(&next);
        if let Some(value) = condition {
            if value >= 0.0 {
                *now = self.locate(now, &next).map_err(Status::Broken)?;
                *steps += 1;
                return Err(Status::Stopped);
            }
            if value.is_nan() {
                return Err(Status::NotFinite { t: next.t, what: Undefined::Condition });
            }
            if value > nearest.1 {
                *nearest = (next.t, value);
            }
        }
        *steps += 1;
        *now = next;
        if t_next >= self.grid.end_time {
            return Err(match condition {
                Some(_) => Status::StopNotReached { nearest_time: nearest.0, missing: -nearest.1 },
                None => Status::Completed,
            });
        }
        Ok(())
    }

    /// The moment inside a step at which the stop condition becomes true, by steps of other lengths from its beginning.
    #[cold]
    fn locate(&mut self, from: &Moment<N, M>, beyond: &Moment<N, M>) -> Result<Moment<N, M>, Breakdown> {
        let value = |run: &Self, at: &Moment<N, M>| run.condition(at).unwrap_or(0.0);
        let (mut low, mut f_low) = (from.t, value(self, from));
        let (mut high, mut f_high, mut found) = (beyond.t, value(self, beyond), *beyond);
        for iteration in 0..100 {
            if f_high == 0.0 || high - low <= 2.0 * f64::EPSILON * high.abs() {
                break;
            }
            // Regula falsi, kept from creeping by a bisection every third time.
            let secant = high - f_high * (high - low) / (f_high - f_low);
            let middle = 0.5 * (low + high);
            let t = if iteration % 3 == 2 || !(secant > low && secant < high) { middle } else { secant };
            let at = self.stepper.between(self.mechanism, &self.request.method, from, t, &mut self.care)?;
            let f = value(self, &at);
            if f >= 0.0 {
                (high, f_high, found) = (t, f, at);
            } else {
                (low, f_low) = (t, f);
            }
        }
        Ok(found)
    }

    fn outcome(&mut self, status: Status, end: Moment<N, M>, steps: u64, integration: Duration) -> Outcome {
        let counts = self.stepper.counts(steps);
        Outcome {
            estimated_error: self.shadow.and_then(|shadow| shadow.error(counts.accepted)),
            error_unknown: self.shadow.is_some_and(|shadow| shadow.broke_off()),
            status,
            step: self.grid.step,
            counts,
            end_time: end.t,
            q: end.q.to_vec(),
            qd: end.qd.to_vec(),
            integration,
            residual_position: self.book.residual_position,
            residual_velocity: self.book.residual_velocity,
            largest_kinetic_energy: self.book.largest_kinetic_energy,
            largest_energy: self.book.largest_energy,
            energy_drift: self.book.is_conservative.then_some(self.book.energy_drift),
            care: self.care,
        }
    }
}
