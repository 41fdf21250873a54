//! The first guess of a periodic motion: a cycle of the ordinary motion.

use std::f64::consts::{PI, TAU};

use qrm_core::Mechanism;

use super::SteadyRequest;
use super::error::NoSteadyMotion;
use super::return_map::Orbit;
use crate::integrate::{Integrator, quintic};
use crate::position::{LoopSolver, Start, completed};
use crate::state::State;

/// The guess of a periodic motion.
pub(super) struct Guess {
    /// The start, and the period.
    pub(super) orbit: Orbit,
    /// The coordinate of the phase, where the period is free.
    pub(super) phase: Option<usize>,
}

/// States without a turn or a reversal after which no more is expected.
const MOST_STATES: u32 = 500_000;
/// A motion has come to rest when its cycles have become smaller than this part of the largest.
const REST: f64 = 1e-6;
/// The number of states in a cycle among which its end is sought, and the most of all.
const ROWS: u32 = 400;
const MOST_ROWS: u32 = 100_000;
/// The number of parts of a period after which a caller may interrupt.
const PARTS: u32 = 16;
/// The largest difference of angles that belong to one position.
const SAME: f64 = 1e-6;

/// Follows the ordinary motion for the periods of the request, and one more where the period is free.
///
/// # Errors
/// The motion has no cycle, or cannot be continued.
pub(super) fn guess(
    mechanism: &dyn Mechanism,
    request: &SteadyRequest,
    start: &Start,
    first: &State,
) -> Result<Guess, NoSteadyMotion> {
    let mut motion = Motion::new(mechanism, request, first)?;
    let is_prescribed = !start.given.contains(&true);
    let settle = if is_prescribed { 0 } else { request.settle };
    let (at, period, phase) = match request.period {
        Some(period) => {
            let period = period * f64::from(request.cycles.max(1));
            for part in 1..=PARTS * settle {
                motion.advance(f64::from(part) * period / f64::from(PARTS))?;
            }
            (motion.to, period, None)
        }
        None => {
            let given = (0..start.given.len()).find(|&i| start.given[i]);
            let phase = request.phase.or(given).ok_or(NoSteadyMotion::NoPhase)?;
            let (at, period) = cycle(&mut motion, request, first, phase)?;
            let period = return_time(mechanism, request, (&at, phase), period)?;
            (at, period, Some(phase))
        }
    };
    let start = with_few_turns(mechanism, start, first, &at);
    Ok(Guess { orbit: Orbit { start, period, parameter: 0.0 }, phase })
}

/// The start of a cycle, and the time that it takes.
fn cycle(
    motion: &mut Motion,
    request: &SteadyRequest,
    first: &State,
    phase: usize,
) -> Result<(State, f64), NoSteadyMotion> {
    let is_angle = motion.mechanism.description().is_angle(phase);
    let step = motion.mechanism.schedule().step;
    let cycles = request.cycles.max(1);
    let mut turns = vec![first.clone()];
    let mut reversals: Vec<f64> = Vec::new();
    // The states since the last but one cycle of reversals.
    let mut states: Vec<State> = vec![first.clone()];
    let (mut largest, mut idle, mut row, mut last_turn) = (0.0_f64, 0, 0_u64, 0.0);
    loop {
        row += 1;
        idle += 1;
        let from = motion.to.clone();
        motion.advance(row as f64 * step)?;
        let to = &motion.to;
        states.push(to.clone());
        let last = turns.last().map_or(first.q[phase], |turn| turn.q[phase]);
        if is_angle && (to.q[phase] - last).abs() >= TAU {
            let direction = (to.q[phase] - last).signum();
            let target = last + TAU * direction;
            // An angle that swings over more than a turn does not turn.
            if let [.., before, last] = &turns[..]
                && (last.q[phase] - before.q[phase]) * direction < 0.0
            {
                turns.clear();
            }
            turns.push(passing(&from, to, phase, target));
            idle = 0;
            states.retain(|state| state.t >= last_turn);
            last_turn = to.t;
            let wanted = request.settle.max(1) as usize * cycles as usize;
            if turns.len() > wanted {
                let begin = if request.settle == 0 { 0 } else { wanted };
                let period = turns[wanted].t - turns[wanted - cycles as usize].t;
                return Ok((turns.swap_remove(begin), period));
            }
        }
        if from.qd[phase] * to.qd[phase] < 0.0 || to.qd[phase] == 0.0 && from.qd[phase] != 0.0 {
            reversals.push(to.t);
            idle = 0;
            let kept = 2 * cycles as usize;
            let since = reversals.len().checked_sub(kept + 1).map_or(0.0, |place| reversals[place]);
            states.retain(|state| state.t >= since);
            let range = |states: &[State]| {
                let q = || states.iter().map(|state| state.q[phase]);
                q().fold(f64::NEG_INFINITY, f64::max) - q().fold(f64::INFINITY, f64::min)
            };
            let of_cycle = range(&states);
            largest = largest.max(of_cycle);
            if of_cycle < REST * largest {
                return Err(NoSteadyMotion::AtRest { t: to.t });
            }
            let advance = (states.last().map_or(0.0, |last| last.q[phase]) - states[0].q[phase]).abs();
            let wanted = (request.settle.max(1) as usize) * kept + 1;
            // Rates of a turning crank may change their sign too.
            if reversals.len() > wanted && !(is_angle && advance > PI) {
                let fastest = |a: &&State, b: &&State| a.qd[phase].total_cmp(&b.qd[phase]);
                let swiftest = states.iter().max_by(fastest).unwrap_or(first);
                // A turning point tells no phase.
                let is_moving = first.qd[phase].abs() > REST * swiftest.qd[phase];
                let begin = if request.settle == 0 && is_moving { first } else { swiftest };
                let ends = [reversals.len() - 1, reversals.len() - 1 - kept].map(|place| reversals[place]);
                return Ok((begin.clone(), ends[0] - ends[1]));
            }
        }
        if idle >= MOST_STATES {
            let last = turns.last().map_or(0.0, |turn| turn.t).max(reversals.last().copied().unwrap_or(0.0));
            let rate = to.qd.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
            let at_first = first.qd.iter().chain(&first.qdd).fold(0.0_f64, |most, rate| most.max(rate.abs()));
            return Err(if rate <= REST * at_first {
                NoSteadyMotion::AtRest { t: to.t }
            } else {
                NoSteadyMotion::NoCycle { coordinate: phase, last, t: to.t }
            });
        }
    }
}

/// The time after which a coordinate returns, near an estimate: it passes its start, or turns back as there where the
/// motion begins at rest. The estimate itself, where it does not return.
fn return_time(
    mechanism: &dyn Mechanism,
    request: &SteadyRequest,
    (begin, phase): (&State, usize),
    estimate: f64,
) -> Result<f64, NoSteadyMotion> {
    let first = State { t: 0.0, ..begin.clone() };
    let mut motion = Motion::new(mechanism, request, &first)?;
    let is_angle = mechanism.description().is_angle(phase);
    let is_at_rest = first.qd[phase].abs() <= REST * (first.qdd[phase] * estimate).abs();
    let (start, direction) =
        if is_at_rest { (0.0, first.qdd[phase].signum()) } else { (first.q[phase], first.qd[phase].signum()) };
    let number = |at: &State| {
        let value = if is_at_rest { at.qd[phase] } else { at.q[phase] };
        let turns = if is_angle && !is_at_rest { TAU * ((value - start) / TAU).round() } else { 0.0 };
        direction * (value - start - turns)
    };
    let mut nearest = estimate;
    let rows = ROWS.saturating_mul(request.cycles.max(1)).min(MOST_ROWS);
    // Its end may come later than estimated.
    for row in 1..=rows + rows / 2 {
        let t = estimate * f64::from(row) / f64::from(rows);
        motion.advance(t)?;
        let (from, to) = (&motion.from, &motion.to);
        let [before, after] = [number(from), number(to)];
        if before < 0.0 && after >= 0.0 && after - before < 1.0 {
            let [mut low, mut high] = [from.t, to.t];
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if number(&quintic(from, to, middle)) < 0.0 { low = middle } else { high = middle }
            }
            // The motion itself, where the polynomial is near enough.
            for _ in 0..3 {
                let made = motion.integrator.between(mechanism, &motion.from, high);
                let at = made.map_err(|error| NoSteadyMotion::Settling { t: motion.from.t, error })?;
                let slope = direction * if is_at_rest { at.qdd[phase] } else { at.qd[phase] };
                let next = high - number(&at) / slope;
                if !(motion.from.t < next && next <= motion.to.t) {
                    break;
                }
                high = next;
            }
            if nearest == estimate || (high - estimate).abs() < (nearest - estimate).abs() {
                nearest = high;
            }
        }
    }
    Ok(nearest)
}

/// The state between two others at which a coordinate has a value.
fn passing(from: &State, to: &State, coordinate: usize, value: f64) -> State {
    let (mut low, mut high) = (from.t, to.t);
    let rises = to.q[coordinate] > from.q[coordinate];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (quintic(from, to, middle).q[coordinate] < value) == rises { low = middle } else { high = middle }
    }
    let mut at = quintic(from, to, high);
    at.q[coordinate] = value;
    at
}

/// The start of a period at a state, with the given angles nearest to those of the first state: whole turns are left
/// out where the position remains the same.
fn with_few_turns(mechanism: &dyn Mechanism, start: &Start, first: &State, at: &State) -> Start {
    if !start.given.contains(&true) {
        // Constraints prescribe it.
        return Start { q: first.q.clone(), qd: first.qd.clone(), ..start.clone() };
    }
    let description = mechanism.description();
    let turns = |i: usize| TAU * ((at.q[i] - first.q[i]) / TAU).round();
    // After whole turns an angle is the same to the last digit.
    let few = |i: usize| match at.q[i] - turns(i) {
        _ if !description.is_angle(i) => at.q[i],
        angle if (angle - first.q[i]).abs() < SAME => first.q[i],
        angle => angle,
    };
    let begin = |q: Vec<f64>| Start { q, qd: at.qd.clone(), given: start.given.clone(), ..start.clone() };
    let reduced = begin((0..at.q.len()).map(few).collect());
    let guess = reduced.q.clone();
    let all = begin(at.q.clone());
    closed(mechanism, reduced)
        .filter(|found| found.q.iter().zip(&guess).all(|(q, guess)| (q - guess).abs() < 10.0 * SAME))
        .or_else(|| closed(mechanism, all.clone()))
        .unwrap_or(all)
}

/// A start with the dependent coordinates and rates, to rounding errors; `None` if there are none near its own.
pub(super) fn closed(mechanism: &dyn Mechanism, start: Start) -> Option<Start> {
    let solver = LoopSolver::new(mechanism, start.given.clone())?;
    let position = solver.solve_loops(start.q.clone())?;
    let (q, qd) = completed(&solver, &start, position)?;
    Some(Start { q, qd, ..start })
}

/// The ordinary motion.
struct Motion<'a> {
    mechanism: &'a dyn Mechanism,
    integrator: Integrator,
    from: State,
    to: State,
    keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
}

impl<'a> Motion<'a> {
    fn new(mechanism: &'a dyn Mechanism, request: &SteadyRequest<'a>, first: &State) -> Result<Self, NoSteadyMotion> {
        let made = Integrator::new(mechanism, request.settings, first, f64::INFINITY);
        let integrator = made.map_err(|error| NoSteadyMotion::Settling { t: first.t, error })?;
        let (from, to) = (first.clone(), first.clone());
        Ok(Self { mechanism, integrator, from, to, keep_running: request.keep_running })
    }

    /// Advances to a time.
    fn advance(&mut self, t: f64) -> Result<(), NoSteadyMotion> {
        std::mem::swap(&mut self.from, &mut self.to);
        let made = self.integrator.advance(self.mechanism, &self.from, t, &mut self.to);
        made.map_err(|error| NoSteadyMotion::Settling { t: self.from.t, error })?;
        // The steps so far are not asked for.
        self.integrator.take_steps();
        if self.keep_running.is_some_and(|keep_running| !keep_running(t, t)) {
            return Err(NoSteadyMotion::Interrupted { t });
        }
        Ok(())
    }
}
