//! The event that ends an enclosed motion.

use qrm_core::{Interval, Tape, TapeSeries};

use super::flow::Flow;

/// A function of time, coordinates and rates that is negative until the motion ends.
pub(super) enum Event {
    /// `|q - from| - 2 pi`: a coordinate completes a turn in either direction.
    Turn { coordinate: usize, from: Interval },
    /// The event of a tape.
    Function(TapeSeries),
}

impl Event {
    /// Creates the event of a tape, with some parameters replaced by index; `None` if it depends on accelerations or
    /// multipliers, or the tape has none.
    pub(super) fn new(tape: &Tape, replace: impl Fn(usize) -> Option<Interval>) -> Option<Self> {
        let function = tape.event.as_ref().filter(|_| !tape.event_takes_forces())?;
        Some(Self::Function(TapeSeries::new(tape, function, replace, [1, 0])))
    }

    /// The values for a box of states in an interval of time.
    pub(super) fn value(&mut self, t: Interval, states: &[Interval]) -> Interval {
        match self {
            Self::Turn { coordinate, from } => {
                let (turned, turn) = (states[*coordinate] - *from, Interval::point(2.0) * Interval::pi());
                // The larger of the two, as the other one is negative.
                let [ahead, behind] = [turned - turn, -turned - turn];
                if ahead.hi() >= behind.hi() { ahead } else { behind }
            }
            Self::Function(series) => {
                series.set(0, 0, &[t]);
                states.iter().enumerate().for_each(|(i, state)| series.set(0, 1 + i, &[*state]));
                series.advance(0);
                series.result(0, 0)[0]
            }
        }
    }

    /// The derivatives with respect to time along the motions through a box of states; `None` if they are not known.
    pub(super) fn rate(&mut self, flow: &mut Flow, t: Interval, states: &[Interval]) -> Option<Interval> {
        let n = states.len() / 2;
        match self {
            Self::Turn { coordinate, from } => {
                let (turned, rate) = (states[*coordinate] - *from, states[n + *coordinate]);
                match (turned.lo() > 0.0, turned.hi() < 0.0) {
                    (true, _) => Some(rate),
                    (_, true) => Some(-rate),
                    _ => None,
                }
            }
            Self::Function(_) => {
                let forces = flow.expand(t, states, None, 1).ok()?.forces;
                self.value(t, states);
                let Self::Function(series) = self else { return None };
                series.set(1, 0, &[Interval::ONE]);
                let rates = states[n..].iter().chain(&forces[..n]);
                rates.enumerate().for_each(|(i, rate)| series.set(1, 1 + i, &[*rate]));
                series.advance(1);
                Some(series.result(1, 0)[0])
            }
        }
    }
}
