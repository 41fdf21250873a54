//! Run time and result of a method at given times.

use std::time::{Duration, Instant};

use qrm_core::Mechanism;

use crate::adaptive::Counts;
use crate::assembly::assemble;
use crate::energy_integral::{EnergyIntegral, NoIntegral};
use crate::linear::largest;
use crate::motion::{Breakdown, Method, Moment, moment};
use crate::outcome::NoStart;
use crate::solve::Care;
use crate::stepper::Stepper;
use crate::walk::{Walker, is_walked, parameters, walk};

/// A state and what belongs to it.
#[derive(Clone, Debug)]
pub struct StateAt {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Rates.
    pub qd: Vec<f64>,
    /// Outputs.
    pub outputs: Vec<f64>,
    /// Largest residual of a constraint.
    pub residual: f64,
    /// Kinetic and potential energy.
    pub energy: f64,
    /// Power of the loads without potential, and of what drives closures.
    pub power: f64,
}

/// What a method gave, and how long it took.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Seconds of each repetition, the shortest first.
    pub seconds: Vec<f64>,
    /// The states at the times that were asked for.
    pub states: Vec<StateAt>,
    /// Energy at the start.
    pub energy: f64,
    /// What one repetition did.
    pub counts: Counts,
}

/// A method with the length of its steps, if it does not choose them.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// The method.
    pub method: Method,
    /// Length of the steps.
    pub step: f64,
}

/// How often a run is repeated.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// At least so often.
    pub least: usize,
    /// And until so much time has gone by, but not longer than ten times that.
    pub time: Duration,
}

/// Runs a method to each of the times, which rise, again and again. Steps of a fixed length are made a little shorter where
/// they do not divide the way to the next time.
///
/// # Errors
/// The run cannot start, or not go to the last time.
pub fn measure<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    trial: &Trial,
    times: &[f64],
    patience: Patience,
) -> Result<Measurement, NoStart> {
    let (q, qd) = assemble(mechanism, &mechanism.start()).map_err(NoStart::NotAssembled)?;
    let first = moment(mechanism, 0.0, q, qd, &mut Care::default()).map_err(NoStart::Broken)?;
    let mut moments = Vec::with_capacity(times.len());
    let mut seconds = Vec::new();
    let mut counts = Counts::default();
    let parameters = parameters(mechanism);
    let begun = Instant::now();
    while seconds.len() < patience.least || begun.elapsed() < patience.time {
        let repetition = Instant::now();
        counts = visit(mechanism, &parameters, trial, (first, times), &mut moments).map_err(NoStart::Broken)?;
        seconds.push(repetition.elapsed().as_secs_f64());
        if begun.elapsed() > 10 * patience.time {
            break;
        }
    }
    seconds.sort_by(f64::total_cmp);
    let states = moments.iter().map(|moment| state(mechanism, moment)).collect();
    Ok(Measurement { seconds, states, energy: mechanism.energy(&first.q, &first.qd).iter().sum(), counts })
}

/// One run to each of the times.
fn visit<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    parameters: &[f64],
    Trial { method, step }: &Trial,
    (first, times): (Moment<N, M>, &[f64]),
    moments: &mut Vec<Moment<N, M>>,
) -> Result<Counts, Breakdown> {
    moments.clear();
    let mut care = Care::default();
    let end = times.last().copied().unwrap_or(0.0);
    let mut stepper = Stepper::new(mechanism, method.scheme, first, end, &mut care)?;
    let mut now = first;
    let mut rows = 0;
    for &t in times {
        let steps = if stepper.is_fixed() { ((t - now.t) / step - 1e-9).ceil().max(1.0) as u64 } else { 1 };
        rows += steps;
        let mut way = Way { from: now.t, to: t, steps, made: 0, now };
        if is_walked(method) {
            walk(mechanism, parameters, method, now, &mut care, &mut way)?;
        } else {
            while way.made < steps {
                let next = stepper.next(mechanism, method, &way.now, way.next_time(), &mut care)?;
                way.arrive(next, &mut care);
            }
        }
        now = way.now;
        moments.push(now);
    }
    Ok(stepper.counts(rows))
}

/// The way from one time to the next, in even steps.
struct Way<const N: usize, const M: usize> {
    from: f64,
    to: f64,
    steps: u64,
    made: u64,
    now: Moment<N, M>,
}

impl<const N: usize, const M: usize> Walker<N, M> for Way<N, M> {
    #[inline(always)]
    fn next_time(&self) -> f64 {
        let next = self.made + 1;
        let h = (self.to - self.from) / self.steps as f64;
        if next == self.steps { self.to } else { self.from + next as f64 * h }
    }

    #[inline(always)]
    fn arrive(&mut self, moment: Moment<N, M>, _: &mut Care) -> bool {
        self.made += 1;
        self.now = moment;
        self.made < self.steps
    }
}

/// States from the energy integral.
///
/// # Errors
/// The motion is not of the kind that has one.
pub fn exact<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    times: &[f64],
    panels: f64,
) -> Result<Vec<StateAt>, NoIntegral> {
    let integral = EnergyIntegral::new(mechanism, times.last().copied().unwrap_or(0.0), panels)?;
    let at = |t: &f64| {
        let (q, qd) = integral.state(*t)?;
        Some(state(mechanism, &moment(mechanism, *t, q, qd, &mut Care::default()).ok()?))
    };
    times.iter().map(at).collect::<Option<Vec<StateAt>>>().ok_or(NoIntegral::TurnsBack)
}

fn state<X: Mechanism<N, M>, const N: usize, const M: usize>(mechanism: &X, at: &Moment<N, M>) -> StateAt {
    let mut outputs = vec![0.0; X::DESCRIPTION.outputs.len()];
    mechanism.outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut outputs);
    let closure = mechanism.closure(at.t, &at.q);
    StateAt {
        t: at.t,
        q: at.q.to_vec(),
        qd: at.qd.to_vec(),
        outputs,
        residual: largest(&closure.constraints).1,
        energy: mechanism.energy(&at.q, &at.qd).iter().sum(),
        power: mechanism.power(at.t, &at.q, &at.qd, &at.multipliers),
    }
}
