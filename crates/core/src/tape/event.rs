//! Properties of the event of a tape.

use core::ops::Range;
use std::vec;

use super::{Operation, Tape};

impl Tape {
    /// Whether the event depends on accelerations or multipliers.
    pub fn event_takes_forces(&self) -> bool {
        let arguments = self.arguments();
        self.event_takes(arguments.qdd..arguments.sin)
    }

    /// Whether the event depends on parameters alone.
    pub fn event_is_constant(&self) -> bool {
        let arguments = self.arguments();
        self.event.is_some() && !self.event_takes(arguments.t..arguments.constants)
    }

    /// Whether the event reads a value at one of some places.
    fn event_takes(&self, places: Range<usize>) -> bool {
        let Some(event) = &self.event else { return false };
        let mut takes = false;
        let mut look = |place: u32| takes |= places.contains(&(place as usize));
        event.operations.iter().for_each(|operation| operation.for_each_operand(&mut look));
        event.results.iter().copied().for_each(look);
        takes
    }

    /// Whether the event is linear in coordinates and in absolute values of linear terms.
    ///
    /// Such an event rises through zero and falls back only where a coordinate turns round.
    pub fn event_is_linear(&self) -> bool {
        let (Some(event), places) = (&self.event, self.arguments()) else { return false };
        let mut is_number = vec![false; places.end + event.operations.len()];
        is_number[..places.t].fill(true);
        is_number[places.constants..places.end].fill(true);
        let mut is_linear = is_number.clone();
        is_linear[places.q..places.qd].fill(true);
        for (operation, result) in event.operations.iter().zip(places.end..) {
            let number = |place: u32| is_number[place as usize];
            let linear = |place: u32| is_linear[place as usize];
            let product = |a, b| (linear(a) && number(b)) || (number(a) && linear(b));
            let is_constant = matches!(operation, Operation::Number(_) | Operation::Pi);
            let follows = match *operation {
                Operation::Neg(a) | Operation::Abs(a) => linear(a),
                Operation::Add(a, b) | Operation::Sub(a, b) => linear(a) && linear(b),
                Operation::Mul(a, b) => product(a, b),
                Operation::Div(a, b) => linear(a) && number(b),
                Operation::MulAdd(a, b, c) | Operation::NegMulAdd(a, b, c) => product(a, b) && linear(c),
                // It has two results.
                Operation::SinCos(_) => return false,
                _ => false,
            };
            is_number[result] = is_constant;
            is_linear[result] = is_constant || follows;
        }
        event.results.iter().all(|place| is_linear[*place as usize])
    }
}
