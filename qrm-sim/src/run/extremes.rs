//! The smallest and largest values of columns, and their times.

use super::extreme_search::SEARCHES;
use crate::polynomial::Number;

/// The relative difference, in parts of the range, below which extremes tie and the first one counts: otherwise
/// rounding errors would decide.
const TIE: f64 = 1e-9;

/// Extremes of one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes<D = f64> {
    /// Smallest value and its time.
    pub minimum: (D, D),
    /// Largest value and its time.
    pub maximum: (D, D),
    /// How far other values lie beyond the smallest and the largest one: they tie with these, and came later.
    pub excess: [f64; 2],
}

/// An extreme of a column found by a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FoundExtreme {
    /// The column.
    pub(crate) column: usize,
    /// 0 for the smallest value, 1 for the largest one.
    pub(crate) end: usize,
    /// The value.
    pub(crate) value: f64,
    /// The time of the extreme.
    pub(crate) t: f64,
}

/// A possible extreme of a column between two rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex<D = f64> {
    /// The column.
    pub(crate) column: usize,
    /// 0 for a smallest value, 1 for a largest one.
    pub(crate) end: usize,
    /// The estimated time and value, from the rows.
    pub(crate) estimate: (D, D),
    /// The times of the neighbouring rows.
    pub(crate) bracket: [D; 2],
    /// The largest deviation of the value from the estimate.
    pub(super) value_uncertainty: f64,
    /// The largest deviation of the value from the estimate if the polynomial is accurate; `None` at corners.
    pub(super) agreement: Option<f64>,
}

impl Vertex {
    /// Whether the value of the motion at the estimated time agrees with the estimate.
    pub(crate) fn agrees(&self, value: f64) -> bool {
        self.agreement.is_some_and(|agreement| (value - self.estimate.0).abs() <= agreement)
    }
}

impl<D: Number> Extremes<D> {
    /// Begins with a value.
    pub(super) fn new(t: D, value: D) -> Self {
        Self { minimum: (value, t), maximum: (value, t), excess: [0.0; 2] }
    }

    /// The largest difference between tied values; of an unbounded column, by the size of its other end.
    pub(super) fn tie(&self) -> f64 {
        TIE * self.range()
    }

    /// The range of the values; of an unbounded column, the size of its other end.
    pub(super) fn range(&self) -> f64 {
        let ends = [self.minimum.0.re(), self.maximum.0.re()];
        let range = ends[1] - ends[0];
        if range.is_finite() {
            range
        } else {
            ends.into_iter().filter(|end| end.is_finite()).fold(0.0, |_, end| end.abs())
        }
    }

    /// Records a value; among tied values, one from before the time `begin` counts.
    #[inline]
    pub(super) fn note(&mut self, t: D, value: D, begin: Option<D>) {
        if self.minimum.0.re() <= value.re() && value.re() <= self.maximum.0.re() {
            return;
        }
        let tie = self.tie();
        let margin = |of: D| if begin.is_some_and(|begin| of.re() < begin.re()) { tie } else { 0.0 };
        let leads = [self.minimum.0.re() - value.re(), value.re() - self.maximum.0.re()];
        let replaces = [leads[0] > margin(self.minimum.1), leads[1] > margin(self.maximum.1)];
        if replaces[0] {
            self.minimum = (value, t);
        }
        if replaces[1] {
            self.maximum = (value, t);
        }
        if SEARCHES {
            for (excess, (lead, replaces)) in self.excess.iter_mut().zip(leads.into_iter().zip(replaces)) {
                *excess = if replaces { (*excess - lead).max(0.0) } else { excess.max(lead) };
            }
        }
    }
}
