//! Bounds of an event between states.

use qrm_core::{Interval, Mechanism, Tape};

use super::NEARNESS;
use crate::bounds::{ArgumentPolynomials, FunctionBounds, argument, ball};
use crate::state::State;

/// The smallest and the largest margin of intervals that are tried, in widths of those that are asked for.
const LEAST_MARGIN: f64 = 1.0 / 64.0;
const MOST_MARGIN: f64 = 1e4;

/// Bounds of an event with the parameters of a mechanism.
#[derive(Clone, Debug)]
pub(crate) struct EventBounds {
    pub(super) function: FunctionBounds,
    /// The numbers and values of the parameters that it uses.
    parameters: Vec<(usize, f64)>,
    /// Intervals of the arguments within which the event is negative; empty if none are known.
    negative: Vec<Interval>,
    /// The margin of the next such intervals, in widths of those that are asked for.
    margin: f64,
    /// How far below zero the event counts as negative.
    nearness: f64,
}

impl EventBounds {
    /// `None` if the tape has no event.
    pub(super) fn new(tape: &Tape, mechanism: &dyn Mechanism, nearness: f64) -> Option<Self> {
        let event = tape.event.as_ref()?;
        let values = mechanism.parameters();
        Some(Self {
            function: FunctionBounds::new(tape, event, mechanism),
            parameters: tape.parameters_of(event).map(|i| (i, values[i])).collect(),
            negative: Vec::new(),
            margin: 1.0,
            nearness,
        })
    }

    /// Whether they are those of another mechanism of the same scene too.
    pub(super) fn hold_for(&self, mechanism: &dyn Mechanism) -> bool {
        let values = mechanism.parameters();
        self.parameters.iter().all(|(i, value)| values[*i] == *value)
    }

    /// Sets how far below zero the event counts as negative.
    pub(super) fn set_nearness(&mut self, nearness: f64) {
        self.nearness = nearness;
        self.negative.clear();
        self.margin = 1.0;
    }

    /// Whether the event is negative in all of a step, and not near zero, by its natural bound.
    pub(super) fn is_negative_in(&mut self, motion: &ArgumentPolynomials) -> bool {
        self.natural_bound(&motion.ranges()).is_none()
    }

    /// The natural bound where the arguments lie in intervals; `None` if the event is negative there.
    ///
    /// Larger intervals are tried, so that the answer is known for those that follow.
    fn natural_bound(&mut self, ranges: &[Interval]) -> Option<Interval> {
        let mut pairs = ranges.iter().zip(&self.negative);
        if self.negative.len() == ranges.len() && pairs.all(|(range, negative)| range.is_inside(*negative)) {
            return None;
        }
        if self.margin >= 1.0 {
            let reach = 0.5 + self.margin;
            let larger: Vec<Interval> = ranges.iter().map(|range| ball(range.mid(), reach * range.width())).collect();
            if self.near(&larger).hi() < -self.nearness {
                self.negative = larger;
                self.margin = (2.0 * self.margin).min(MOST_MARGIN);
                return None;
            }
        }
        let natural = self.near(ranges);
        let is_negative = natural.hi() < -self.nearness;
        self.margin *= if is_negative { 2.0 } else { 0.5 };
        self.margin = self.margin.clamp(LEAST_MARGIN, MOST_MARGIN);
        (!is_negative).then_some(natural)
    }

    /// The natural bound where the arguments lie in intervals or near them.
    fn near(&mut self, ranges: &[Interval]) -> Interval {
        let near = |range: &Interval| ball(range.mid(), 0.5 * range.width() + NEARNESS * range.magnitude());
        let near: Vec<Interval> = ranges.iter().map(near).collect();
        self.function.evaluate(0, &near)
    }

    /// Whether the event comes near zero at a state.
    pub(super) fn is_near_zero(&mut self, at: &State) -> bool {
        let arguments: Vec<Interval> =
            self.function.arguments.iter().map(|number| Interval::point(argument(at, *number))).collect();
        self.near(&arguments).hi() >= -self.nearness
    }

    /// Whether the event may come near zero where each argument and its rate lie in intervals.
    ///
    /// `at` are arguments among them, `[before, after]` the largest times to there and from there on.
    pub(super) fn may_come_near_zero(
        &mut self,
        [ranges, rates]: [&[Interval]; 2],
        at: &[Interval],
        [before, after]: [f64; 2],
    ) -> bool {
        let Some(natural) = self.natural_bound(ranges) else { return false };
        if !natural.is_finite() || self.function.may_jump() {
            return true;
        }
        let slope = self.function.evaluate(1, rates);
        (self.near(at) + slope * Interval::new(-before, after)).hi() >= -self.nearness
    }
}
