//! Intervals that are proved to contain the motion.

mod crossing;
mod flow;
mod linear;
mod manifold;
mod matrix;
mod start;
mod state_set;
mod step;

use crate::position::NotAssembled;
use qrm_core::{Interval, Model, TapeSeries};

use self::crossing::Passage;
use self::flow::Flow;
pub use self::flow::NoSeries;
use self::state_set::StateSet;
use self::step::{ORDER, Step};

/// New values for parameters, by their names.
type Values<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// Where an enclosed motion ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnclosureEnd {
    /// At a time, in s.
    Time(f64),
    /// When a coordinate has made a turn in either direction, or at a time before.
    Turn {
        /// The coordinate.
        coordinate: usize,
        /// The time, in s.
        before: f64,
    },
}

/// Intervals that contain the motion at its end.
#[derive(Clone, Debug)]
pub struct Enclosure {
    /// When, in s.
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
    /// Steps up to here.
    pub steps: u64,
    /// Whether the coordinate has made its turn.
    pub has_turned: bool,
}

/// How far a motion was enclosed, and why no further.
#[derive(Clone, Debug)]
pub struct NotEnclosed {
    /// The last state that contains the motion; `None` at the start.
    pub reached: Option<Box<Enclosure>>,
    /// Why it ended.
    pub reason: Reason,
}

/// Why a motion is not enclosed.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
    /// The values that are given do not determine the others, or are too many.
    NotGiven,
    /// No proof was found that there is exactly one start near the computed one.
    NotIsolated,
    /// Friction by the forces in joints, which the functions of the tape find by iteration.
    Friction,
    /// The series of the equations of motion need more memory than is reasonable.
    TooLarge,
    /// There is no series, or it was not proved that there is one.
    NoSeries(NoSeries),
    /// Steps became too short or too many, because the intervals became too wide.
    StepTooShort,
    /// The time of the turn was not separated from others.
    NotCrossed,
    /// The caller ended it.
    Interrupted,
}

/// Most intervals of a series, 500 MB.
const MOST_INTERVALS: usize = 30_000_000;
/// Most steps.
const MOST_STEPS: u64 = 100_000;
/// How much longer a step may be than the one before.
const GROWTH: f64 = 1.3;
/// How far a step may go beyond the end, so that the end is within it for certain.
const BEYOND: f64 = 1.0 + 1e-12;
/// Steps shorter than this part of the longest one end an enclosure.
const SHORTEST: f64 = 1e-4;

/// Encloses the motion of a mechanism from its scene's start, with some parameters replaced by their names.
///
/// The motion is that of the exact equations that the tape states, for all values of its numbers that round to their
/// doubles ([`Interval::rounded`]). Accelerations follow from the saddle-point system, so that a motion that meets the
/// constraints at its start meets them ever after.
///
/// # Errors
/// Something was not proved; the error says how far the motion was enclosed.
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
    let dynamics = model.tape().dynamics.operations.len();
    if dynamics * (1 + 2 * model.tape().coordinates as usize) * (1 + ORDER) > MOST_INTERVALS {
        return Err(at_start(Reason::TooLarge));
    }
    Motion::new(model, values).map_err(at_start)?.follow(end, is_interrupted)
}

fn replaced(model: &Model, values: Values, i: usize) -> Option<Interval> {
    values(model.description.parameters[i].name).map(Interval::rounded)
}

/// A motion that is being enclosed.
struct Motion<'m> {
    model: &'m Model,
    flow: Flow,
    outputs: TapeSeries,
    set: StateSet,
    steps: u64,
}

impl<'m> Motion<'m> {
    fn new(model: &'m Model, values: Values) -> Result<Self, Reason> {
        let (tape, replace) = (model.tape(), |i: usize| replaced(model, values, i));
        let mut flow = Flow::new(tape, &replace, ORDER);
        let states = start::start(model, values, &mut flow.manifold)?;
        let set = StateSet::from_box(&mut flow.manifold, 0.0, &states).ok_or(Reason::NotIsolated)?;
        Ok(Self { model, flow, outputs: TapeSeries::new(tape, &tape.outputs, replace, [0, 0]), set, steps: 0 })
    }

    fn follow(mut self, end: EnclosureEnd, is_interrupted: &dyn Fn() -> bool) -> Result<Enclosure, NotEnclosed> {
        match self.advance(end, is_interrupted) {
            Ok(turned) => {
                let (t, states) =
                    turned.clone().unwrap_or_else(|| (Interval::point(self.set.t), self.set.hull.clone()));
                let reached = self.described(t, &states, turned.is_some());
                reached.map_err(|reason| NotEnclosed { reached: None, reason: Reason::NoSeries(reason) })
            }
            Err(reason) => {
                let (t, states) = (Interval::point(self.set.t), self.set.hull.clone());
                let reached = self.described(t, &states, false).ok().filter(|_| self.steps > 0);
                Err(NotEnclosed { reached: reached.map(Box::new), reason })
            }
        }
    }

    /// Makes steps to the end; the time of a turn and the states there, if there is one before.
    fn advance(
        &mut self,
        end: EnclosureEnd,
        is_interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<(Interval, Vec<Interval>)>, Reason> {
        let states = self.set.hull.clone();
        let turn = Interval::point(2.0) * Interval::pi();
        let (end_time, targets) = match end {
            EnclosureEnd::Time(t) => (t, None),
            EnclosureEnd::Turn { coordinate, before } => {
                (before, Some((coordinate, [states[coordinate] - turn, states[coordinate] + turn])))
            }
        };
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
            // Rounded down, the time is within the step for certain.
            let to = if reaches_end { end_time } else { (self.set.t + step.length).next_down() };
            let is_short = to < end_time && step.length < SHORTEST * longest;
            if is_short || to <= self.set.t || self.steps >= MOST_STEPS {
                return Err(step.obstacle.map_or(Reason::StepTooShort, Reason::NoSeries));
            }
            self.steps += 1;
            let passage = match targets {
                Some((coordinate, targets)) => step.passage(&mut self.flow, coordinate, targets, to)?,
                None => Passage::Not(step.states(&mut self.flow, to).ok_or(Reason::NoSeries(NoSeries::Singular))?),
            };
            match passage {
                Passage::Not(set) => self.set = set,
                Passage::At(t, states) => return Ok(Some((t, states))),
            }
        }
        Ok(None)
    }

    /// The state with all that follows from it.
    fn described(&mut self, t: Interval, states: &[Interval], has_turned: bool) -> Result<Enclosure, NoSeries> {
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
            has_turned,
        })
    }
}
