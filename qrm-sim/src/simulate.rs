//! A run from start to end: grid of steps, stop condition, rows for an observer, what can be said of the errors.

use std::time::{Duration, Instant};

use qrm_core::Mechanism;

use crate::assembly::assemble;
use crate::book::Book;
use crate::motion::{self, Breakdown, Method, Moment, moment};
use crate::observer::Observer;
use crate::outcome::{NoStart, Outcome, Status, Undefined};
use crate::shadow::Shadow;
use crate::solve::Care;
use crate::stepper::Stepper;
use crate::walk::{Walker, is_walked, parameters, walk};

/// How many steps are made between two visits to the observer.
const CHUNK: usize = 1024;

/// One of so many steps is looked at more closely.
const SAMPLED: usize = 32;

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
        parameters: parameters(mechanism),
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
pub(crate) struct Grid {
    pub(crate) step: f64,
    pub(crate) end_time: f64,
}

impl Grid {
    /// The time after `n` steps; a remainder far below a step belongs to the last one.
    pub(crate) fn time(&self, n: u64) -> f64 {
        let t = n as f64 * self.step;
        if t >= self.end_time - 1e-9 * self.step { self.end_time } else { t }
    }
}

/// A run that is made by the kernel.
struct Runner<'r, 'a, X, const N: usize, const M: usize> {
    run: &'r Run<'a, X, N, M>,
    road: &'r mut Road<N, M>,
    status: Option<Status>,
}

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Walker<N, M> for Runner<'_, '_, X, N, M> {
    #[inline(always)]
    fn next_time(&self) -> f64 {
        self.run.grid.time(self.road.steps + 1)
    }

    #[inline(always)]
    fn arrive(&mut self, next: Moment<N, M>, care: &mut Care) -> bool {
        self.status = self.run.arrive(next, self.road, care);
        self.status.is_none() && self.road.rows.len() < CHUNK
    }
}

/// How far a run has come.
struct Road<const N: usize, const M: usize> {
    /// The last row that was taken.
    now: Moment<N, M>,
    steps: u64,
    /// When the stop condition was nearest to true, and by how much it was not.
    nearest: (f64, f64),
    /// Rows that nobody has taken yet.
    rows: Vec<Moment<N, M>>,
}

impl<const N: usize, const M: usize> Road<N, M> {
    #[inline(always)]
    fn take(&mut self, next: Moment<N, M>) {
        self.steps += 1;
        self.rows.push(next);
    }

    /// The last row.
    fn last(&self) -> Moment<N, M> {
        self.rows.last().copied().unwrap_or(self.now)
    }
}

struct Run<'a, X, const N: usize, const M: usize> {
    mechanism: &'a X,
    request: &'a Request<'a>,
    parameters: Vec<f64>,
    grid: Grid,
    stepper: Stepper<N, M>,
    /// The second run, which tells the error.
    shadow: Option<Shadow<N, M>>,
    book: Book,
    care: Care,
}

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Run<'_, X, N, M> {
    fn run(&mut self, first: Moment<N, M>, observer: &mut dyn Observer) -> Outcome {
        let nearest = (0.0, self.condition(&first).unwrap_or(0.0));
        let mut road = Road { now: first, steps: 0, nearest, rows: Vec::with_capacity(CHUNK + 1) };
        road.rows.push(first);
        // The end of the rows that were kept.
        let mut kept_until = first;
        let mut integration = Duration::ZERO;
        let mut status = (nearest.1 >= 0.0 && self.condition(&first).is_some()).then_some(Status::StoppedAtStart);
        loop {
            let begun = Instant::now();
            if status.is_none() {
                status = self.chunk(&mut road);
            }
            integration += begun.elapsed();
            self.sample(&road.rows);
            if let Some(shadow) = &mut self.shadow {
                let grid = self.grid;
                shadow.follow(self.mechanism, &road.rows, |row, at| at.t == grid.time(row));
            }
            let kept_before = self.book.rows;
            let kept = self.book.keep(self.mechanism, &road.rows, observer);
            if kept.is_err() {
                // The run ends with its last row, however much further the computation had come.
                let last = ((self.book.rows - kept_before) as usize).checked_sub(1);
                road.now = last.map_or(kept_until, |last| road.rows[last]);
                road.steps = self.book.rows.saturating_sub(1);
            }
            kept_until = road.now;
            road.rows.clear();
            let goes_on =
                kept.and_then(|()| observer.goes_on(road.now.t, self.grid.end_time).map_err(Status::Unwritable));
            match goes_on {
                Err(ending) => status = Some(ending),
                Ok(false) if status.is_none() => status = Some(Status::Interrupted),
                Ok(_) => {}
            }
            if let Some(status) = status {
                let status = observer.finish().map_or_else(Status::Unwritable, |()| status);
                return self.outcome(status, road.now, road.steps, integration);
            }
        }
    }

    /// Makes rows until there is room for no more; the end of the run, if it comes.
    fn chunk(&mut self, road: &mut Road<N, M>) -> Option<Status> {
        let (mechanism, method) = (self.mechanism, &self.request.method);
        let mut care = self.care;
        let made = match &self.stepper {
            Stepper::Fixed if is_walked(method) => {
                let now = road.last();
                let mut walker = Runner { run: self, road, status: None };
                let made = walk(mechanism, &self.parameters, method, now, &mut care, &mut walker);
                (made, walker.status)
            }
            _ => loop {
                let t_next = self.grid.time(road.steps + 1);
                match self.stepper.next(mechanism, method, &road.last(), t_next, &mut care) {
                    Ok(next) => match self.arrive(next, road, &mut care) {
                        None if road.rows.len() < CHUNK => {}
                        status => break (Ok(()), status),
                    },
                    Err(breakdown) => break (Err(breakdown), None),
                }
            },
        };
        self.care = care;
        road.now = road.last();
        made.0.err().map(Status::Broken).or(made.1)
    }

    /// Makes some of a kernel's steps once more by the plain functions, which tell what it leaves unsaid: how far the loops were
    /// open before they were corrected, and by how much.
    fn sample(&mut self, rows: &[Moment<N, M>]) {
        if !is_walked(&self.request.method) {
            return;
        }
        for steps in rows.windows(2).step_by(SAMPLED) {
            let mut care = Care::default();
            // What cannot be made again was made by the plain functions already.
            if motion::advance(self.mechanism, &self.request.method, &steps[0], steps[1].t, &mut care).is_ok() {
                self.care.open = self.care.open.max(care.open);
                self.care.moved = self.care.moved.max(care.moved);
            }
        }
    }

    /// How far the stop condition is from true (negative), if there is one.
    #[inline(always)]
    fn condition(&self, at: &Moment<N, M>) -> Option<f64> {
        match self.request.end {
            Some(End::Time(_)) => None,
            Some(End::Condition(condition)) => {
                // Copies: what is passed on by its address lives in memory, and a moment should live in registers.
                let (q, qd) = (at.q, at.qd);
                Some(condition(at.t, &q, &qd))
            }
            None => self.mechanism.stop(at.t, &at.q, &at.qd),
        }
    }

    /// Takes up the moment at the end of a step; the end of the run, if that was it.
    #[inline(always)]
    fn arrive(&self, next: Moment<N, M>, road: &mut Road<N, M>, care: &mut Care) -> Option<Status> {
        let condition = self.condition(&next);
        if next.t < self.grid.end_time && condition.is_none_or(|value| value < 0.0) {
            if let Some(value) = condition
                && value > road.nearest.1
            {
                road.nearest = (next.t, value);
            }
            road.take(next);
            return None;
        }
        Some(self.end(next, condition, road, care))
    }

    /// Takes up the last moment: the end of a step, or when the stop condition became true in it.
    #[cold]
    fn end(&self, next: Moment<N, M>, condition: Option<f64>, road: &mut Road<N, M>, care: &mut Care) -> Status {
        match condition {
            Some(value) if value.is_nan() => Status::NotFinite { t: next.t, what: Undefined::Condition },
            Some(value) if value >= 0.0 => match self.locate(&road.last(), &next, care) {
                Ok(found) => {
                    road.take(found);
                    Status::Stopped
                }
                Err(breakdown) => Status::Broken(breakdown),
            },
            _ => {
                let before = road.nearest;
                let (nearest_time, nearest) =
                    condition.map_or(before, |v| if v > before.1 { (next.t, v) } else { before });
                road.take(next);
                match condition {
                    Some(_) => Status::StopNotReached { nearest_time, missing: -nearest },
                    None => Status::Completed,
                }
            }
        }
    }

    fn locate(&self, from: &Moment<N, M>, beyond: &Moment<N, M>, care: &mut Care) -> Result<Moment<N, M>, Breakdown> {
        let value = |at: &Moment<N, M>| self.condition(at).unwrap_or(0.0);
        let step = |t: f64| self.stepper.between(self.mechanism, &self.request.method, from, t, care);
        locate(from, beyond, value, step)
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
            nearest_singular: self.book.rank.nearest(),
            energy_imbalance: self.stepper.imbalance().unwrap_or_else(|| self.book.balance.finished().excess),
            energy_drift: self.book.is_conservative.then_some(self.book.energy_drift),
            care: self.care,
        }
    }
}

/// The moment inside a step at which a condition becomes true, by steps of other lengths from its beginning.
pub(crate) fn locate<const N: usize, const M: usize>(
    from: &Moment<N, M>,
    beyond: &Moment<N, M>,
    value: impl Fn(&Moment<N, M>) -> f64,
    mut step: impl FnMut(f64) -> Result<Moment<N, M>, Breakdown>,
) -> Result<Moment<N, M>, Breakdown> {
    let (mut low, mut f_low) = (from.t, value(from));
    let (mut high, mut f_high, mut found) = (beyond.t, value(beyond), *beyond);
    for iteration in 0..100 {
        if f_high == 0.0 || high - low <= 2.0 * f64::EPSILON * high.abs() {
            break;
        }
        // Regula falsi, kept from creeping by a bisection every third time.
        let secant = high - f_high * (high - low) / (f_high - f_low);
        let middle = 0.5 * (low + high);
        let t = if iteration % 3 == 2 || !(secant > low && secant < high) { middle } else { secant };
        let at = step(t)?;
        let f = value(&at);
        if f >= 0.0 {
            (high, f_high, found) = (t, f, at);
        } else {
            (low, f_low) = (t, f);
        }
    }
    Ok(found)
}
