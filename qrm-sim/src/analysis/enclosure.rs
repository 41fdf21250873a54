//! Intervals that provably contain the motion.

mod crossing;
mod event;
mod flow;
mod linear;
mod manifold;
mod matrix;
mod start;
mod state_set;
mod step;

use qrm_core::{Interval, Model, Tape, TapeSeries};

use self::crossing::CrossingResult;
use self::event::Event;
use self::flow::Flow;
pub use self::flow::NoSeries;
use self::state_set::StateSet;
use self::step::{ORDER, Step};
use crate::position::NotAssembled;

/// New values of parameters by name.
type Values<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// The end of an enclosed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnclosureEnd<'a> {
    /// At a time, in s.
    Time(f64),
    /// When a coordinate has completed a turn in either direction, or at an earlier time.
    Turn {
        /// The coordinate.
        coordinate: usize,
        /// The latest time, in s.
        before: f64,
    },
    /// When the event of a tape rises through zero, or at an earlier time. It depends on time, coordinates and rates.
    Event {
        /// The tape.
        tape: &'a Tape,
        /// The latest time, in s.
        before: f64,
    },
}

/// Intervals that contain the motion at its end.
#[derive(Clone, Debug)]
pub struct Enclosure {
    /// The time, in s.
    pub t: Interval,
    /// Coordinates.
    pub q: Vec<Interval>,
    /// Rates of the coordinates.
    pub qd: Vec<Interval>,
    /// Accelerations.
    pub qdd: Vec<Interval>,
    /// Multipliers.
    pub multipliers: Vec<Interval>,
    /// Outputs.
    pub outputs: Vec<Interval>,
    /// The number of steps.
    pub steps: u64,
    /// Whether the coordinate has completed its turn, or the event has come.
    pub is_at_event: bool,
}

/// The reason why a motion could not be enclosed further, and the last enclosed state.
#[derive(Clone, Debug)]
pub struct NotEnclosed {
    /// The last state that contains the motion; `None` at the start.
    pub reached: Option<Box<Enclosure>>,
    /// The reason.
    pub reason: Reason,
}

/// The reason why a motion is not enclosed.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
    /// The given values do not determine the others, or there are too many of them.
    NotGiven,
    /// It was not proved that there is exactly one start near the computed one.
    NotIsolated,
    /// Friction depends on joint forces, which the functions of the tape find by iteration.
    Friction,
    /// The series of the equations of motion need too much memory.
    TooLarge,
    /// There is no series, or its existence was not proved.
    NoSeries(NoSeries),
    /// Steps became too short or too many because the intervals became too wide.
    StepTooShort,
    /// The event depends on accelerations or multipliers.
    EventOnForces,
    /// It was not proved that the event has not come at the start.
    EventAtStart,
    /// The time of the event could not be isolated.
    NotCrossed,
    /// The caller interrupted the computation.
    Interrupted,
}

/// The largest number of intervals in a series, 500 MB.
const MOST_INTERVALS: usize = 30_000_000;
/// The largest number of steps.
const MOST_STEPS: u64 = 100_000;
/// The largest ratio of a step to the previous one.
const GROWTH: f64 = 1.3;
/// The factor by which a step is extended beyond the end, so that it certainly contains the end.
const BEYOND: f64 = 1.0 + 1e-12;
/// An enclosure ends when steps become shorter than this fraction of the longest one.
const SHORTEST: f64 = 1e-4;

/// Encloses the motion of a mechanism from its scene's start, with some parameters replaced by name.
///
/// The motion is that of the exact equations of the tape, for all numbers that round to its doubles
/// ([`Interval::rounded`]). Accelerations follow from the saddle-point system, so a motion that satisfies the
/// constraints at its start satisfies them at all times.
///
/// # Errors
/// A proof failed; the error tells how far the motion was enclosed.
pub fn enclose(
    model: &Model,
    values: &dyn Fn(&str) -> Option<f64>,
    end: EnclosureEnd,
    is_interrupted: &dyn Fn() -> bool,
) -> Result<Enclosure, NotEnclosed> {
    let at_start = |reason| NotEnclosed { reached: None, reason };
    if !model.description.friction.is_empty() {
        return Err(at_start(Reason::Friction));
    }
    let dynamics = model.tape().full_dynamics().operations.len();
    if dynamics * (1 + 2 * model.tape().coordinates as usize) * (1 + ORDER) > MOST_INTERVALS {
        return Err(at_start(Reason::TooLarge));
    }
    Motion::new(model, values).map_err(at_start)?.follow(end, is_interrupted)
}

fn replaced(model: &Model, values: Values, i: usize) -> Option<Interval> {
    values(model.description.parameters[i].name).map(Interval::rounded)
}

/// A motion during its enclosure.
struct Motion<'m> {
    model: &'m Model,
    values: Values<'m>,
    flow: Flow,
    outputs: TapeSeries,
    set: StateSet,
    steps: u64,
}

impl<'m> Motion<'m> {
    fn new(model: &'m Model, values: Values<'m>) -> Result<Self, Reason> {
        let (tape, replace) = (model.tape(), |i: usize| replaced(model, values, i));
        let mut flow = Flow::new(tape, &replace, ORDER);
        let states = start::start(model, values, &mut flow.manifold)?;
        let set = StateSet::from_box(&mut flow.manifold, 0.0, &states).ok_or(Reason::NotIsolated)?;
        Ok(Self { model, values, flow, outputs: TapeSeries::new(tape, &tape.outputs, replace, [0, 0]), set, steps: 0 })
    }

    fn follow(mut self, end: EnclosureEnd, is_interrupted: &dyn Fn() -> bool) -> Result<Enclosure, NotEnclosed> {
        match self.advance(end, is_interrupted) {
            Ok(at_event) => {
                let is_at_event = at_event.is_some();
                let (t, states) = at_event.unwrap_or_else(|| (Interval::point(self.set.t), self.set.hull.clone()));
                let reached = self.described(t, &states, is_at_event);
                reached.map_err(|reason| NotEnclosed { reached: None, reason: Reason::NoSeries(reason) })
            }
            Err(reason) => {
                let (t, states) = (Interval::point(self.set.t), self.set.hull.clone());
                let reached = self.described(t, &states, false).ok().filter(|_| self.steps > 0);
                Err(NotEnclosed { reached: reached.map(Box::new), reason })
            }
        }
    }

    /// Makes steps to the end; returns the time of the event and the states at that time if the event comes first.
    fn advance(
        &mut self,
        end: EnclosureEnd,
        is_interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<(Interval, Vec<Interval>)>, Reason> {
        let (end_time, mut event) = match end {
            EnclosureEnd::Time(t) => (t, None),
            EnclosureEnd::Turn { coordinate, before } => {
                (before, Some(Event::Turn { coordinate, from: self.set.hull[coordinate] }))
            }
            EnclosureEnd::Event { tape, before } => {
                let replace = |i: usize| replaced(self.model, self.values, i);
                let event = Event::new(tape, replace).ok_or(Reason::EventOnForces)?;
                (before, Some(event))
            }
        };
        let start = Interval::point(self.set.t);
        if event.as_mut().is_some_and(|event| !(event.value(start, &self.set.hull).hi() < 0.0)) {
            return Err(Reason::EventAtStart);
        }
        let (mut longest, mut last) = (0.0_f64, f64::INFINITY);
        while self.set.t < end_time {
            if is_interrupted() {
                return Err(Reason::Interrupted);
            }
            let left = end_time - self.set.t;
            let length = (GROWTH * last).min(BEYOND * left);
            let step = Step::new(&mut self.flow, self.set.clone(), length).map_err(Reason::NoSeries)?;
            last = step.length;
            longest = longest.max(last);
            let reaches_end = (Interval::point(end_time) - Interval::point(self.set.t)).hi() <= step.length;
            // Rounded down, so that the time certainly lies within the step.
            let to = if reaches_end { end_time } else { (self.set.t + step.length).next_down() };
            let is_short = to < end_time && step.length < SHORTEST * longest;
            if is_short || to <= self.set.t || self.steps >= MOST_STEPS {
                return Err(step.obstacle.map_or(Reason::StepTooShort, Reason::NoSeries));
            }
            self.steps += 1;
            let result = match &mut event {
                Some(event) => step.states_or_crossing(&mut self.flow, event, to)?,
                None => CrossingResult::NotReached(
                    step.states(&mut self.flow, to).ok_or(Reason::NoSeries(NoSeries::Singular))?,
                ),
            };
            match result {
                CrossingResult::NotReached(set) => self.set = set,
                CrossingResult::At(t, states) => return Ok(Some((t, states))),
            }
        }
        Ok(None)
    }

    /// Completes a state by all quantities that follow from it.
    fn described(&mut self, t: Interval, states: &[Interval], is_at_event: bool) -> Result<Enclosure, NoSeries> {
        let forces = self.flow.expand(t, states, None, 1)?.forces;
        let n = self.model.tape().coordinates as usize;
        let arguments = [&[t], states, &forces].concat();
        arguments.iter().enumerate().for_each(|(i, value)| self.outputs.set(0, i, &[*value]));
        self.outputs.advance(0);
        Ok(Enclosure {
            t,
            q: states[..n].to_vec(),
            qd: states[n..].to_vec(),
            qdd: forces[..n].to_vec(),
            multipliers: forces[n..].to_vec(),
            outputs: (0..self.outputs.results()).map(|i| self.outputs.result(0, i)[0]).collect(),
            steps: self.steps,
            is_at_event,
        })
    }
}
