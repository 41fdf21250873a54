//! The arguments that the event and the outputs of a tape depend on.

use core::ops::Range;
use std::vec;
use std::vec::Vec;

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

    /// Whether some output depends on accelerations or multipliers.
    pub fn outputs_take_forces(&self) -> bool {
        self.outputs_by_forces().contains(&true)
    }

    /// Whether each output depends on accelerations or multipliers.
    pub fn outputs_by_forces(&self) -> Vec<bool> {
        let places = self.arguments();
        let mut takes = vec![false; places.end];
        takes[places.qdd..places.sin].fill(true);
        for operation in self.outputs.operations.iter() {
            let mut follows = false;
            operation.for_each_operand(&mut |place: u32| follows |= takes[place as usize]);
            takes.push(follows);
            if matches!(operation, Operation::SinCos(_)) {
                takes.push(follows);
            }
        }
        self.outputs.results.iter().map(|place| takes[*place as usize]).collect()
    }

    /// Whether outputs have operations that may peak within a small part of the motion: exponentials, and the signs by
    /// which tables choose.
    pub fn outputs_may_be_narrow(&self) -> bool {
        use Operation as Op;
        let is_narrow = |operation: &Op| matches!(operation, Op::Exp(_) | Op::Sign(_) | Op::Min(..) | Op::Max(..));
        self.outputs.operations.iter().any(is_narrow)
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

    /// Whether the event is certainly a convex function of the coordinates alone: it is then largest at an end of a line,
    /// and at a control point of a polynomial.
    pub fn event_is_convex(&self) -> bool {
        let (Some(event), places) = (&self.event, self.arguments()) else { return false };
        let mut is_number = vec![false; places.end + event.operations.len()];
        is_number[..places.t].fill(true);
        is_number[places.constants..places.end].fill(true);
        let mut is_linear = is_number.clone();
        is_linear[places.q..places.qd].fill(true);
        let mut is_convex = is_linear.clone();
        for (operation, result) in event.operations.iter().zip(places.end..) {
            let number = |place: u32| is_number[place as usize];
            let linear = |place: u32| is_linear[place as usize];
            let convex = |place: u32| is_convex[place as usize];
            let product = |a, b| (linear(a) && number(b)) || (number(a) && linear(b));
            let is_constant = matches!(operation, Operation::Number(_) | Operation::Pi);
            let (follows, stays_convex) = match *operation {
                Operation::Neg(a) => (linear(a), linear(a)),
                Operation::Abs(a) => (false, linear(a)),
                Operation::Max(a, b) => (false, convex(a) && convex(b)),
                Operation::Add(a, b) => (linear(a) && linear(b), convex(a) && convex(b)),
                Operation::Sub(a, b) => (linear(a) && linear(b), convex(a) && linear(b)),
                Operation::Mul(a, b) => (product(a, b), product(a, b)),
                Operation::Div(a, b) => (linear(a) && number(b), linear(a) && number(b)),
                Operation::MulAdd(a, b, c) | Operation::NegMulAdd(a, b, c) => {
                    (product(a, b) && linear(c), product(a, b) && convex(c))
                }
                // It has two results.
                Operation::SinCos(_) => return false,
                _ => (false, false),
            };
            is_number[result] = is_constant;
            is_linear[result] = is_constant || follows;
            is_convex[result] = is_constant || stays_convex;
        }
        event.results.iter().all(|place| is_convex[*place as usize])
    }
}
