//! Smallest and largest values in lanes.

use qrm_core::Scalar;

use crate::lanes::{Lanes, Token};

/// Smallest and largest value of each output; of none, if nobody asks.
pub(super) struct Ranges<S: Token> {
    /// Those of the last row.
    pub(super) outputs: Vec<Lanes<S>>,
    lowest: Vec<Lanes<S>>,
    highest: Vec<Lanes<S>>,
    /// Not a number in lanes in which an output was none.
    defined: Lanes<S>,
}

impl<S: Token> Ranges<S> {
    pub(super) fn new(count: usize) -> Self {
        let zero = Lanes::zero();
        Self { outputs: vec![zero; count], lowest: vec![zero; count], highest: vec![zero; count], defined: zero }
    }

    /// Begins a lane anew.
    pub(super) fn begin(&mut self, lane: usize, outputs: &[f64]) {
        self.defined.set(lane, outputs.iter().map(|value| 0.0 * value).sum());
        for ((lowest, highest), value) in self.lowest.iter_mut().zip(&mut self.highest).zip(outputs) {
            lowest.set(lane, *value);
            highest.set(lane, *value);
        }
    }

    /// Gives a lane other outputs in the last row.
    pub(super) fn put(&mut self, lane: usize, outputs: &[f64]) {
        for (output, value) in self.outputs.iter_mut().zip(outputs) {
            output.set(lane, *value);
        }
    }

    /// Takes up the last row.
    #[inline(always)]
    pub(super) fn widen(&mut self) {
        let mut defined = self.defined;
        for ((value, lowest), highest) in self.outputs.iter().zip(&mut self.lowest).zip(&mut self.highest) {
            *lowest = lowest.min(*value);
            *highest = highest.max(*value);
            defined = value.mul_add(Lanes::zero(), defined);
        }
        self.defined = defined;
    }

    /// Whether all outputs of a lane were numbers.
    pub(super) fn is_defined(&self, lane: usize) -> bool {
        self.defined.get(lane) == 0.0
    }

    /// Those of a lane, with the outputs of its end.
    pub(super) fn of(&self, lane: usize, end: &[f64]) -> Vec<[f64; 2]> {
        let ranges = self.lowest.iter().zip(&self.highest).zip(end);
        ranges.map(|((lowest, highest), value)| [lowest.get(lane).min(*value), highest.get(lane).max(*value)]).collect()
    }
}
