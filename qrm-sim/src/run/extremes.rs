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
    /// The values and times of turning points that come closest to the smallest and the largest value, or tie with
    /// them: by the error of the motion, these may be the extremes.
    pub(crate) rivals: [Option<(D, D)>; 2],
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
    /// How far it lies behind the extreme, if it is a rival of that.
    pub(crate) behind: Option<f64>,
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

/// The sign that turns smallest values (0) into largest ones (1).
pub(super) fn sign(end: usize) -> f64 {
    if end == 0 { -1.0 } else { 1.0 }
}

/// The largest value, or the smallest one with its sign changed, that a value with an error may have.
pub(super) fn reach(end: usize, (value, error): (f64, f64)) -> f64 {
    sign(end) * value + error
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
        Self { minimum: (value, t), maximum: (value, t), rivals: [None; 2] }
    }

    /// Records another value that may be the extreme; of tied ones, the last counts.
    pub(super) fn note_rival(&mut self, end: usize, (value, t): (D, D)) {
        if SEARCHES {
            let lead = self.rivals[end].map_or(f64::INFINITY, |(known, _)| sign(end) * (value.re() - known.re()));
            if lead >= -self.tie() {
                self.rivals[end] = Some((value, t));
            }
        }
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
        for end in 0..2 {
            if leads[end] > 0.0 && !replaces[end] {
                self.note_rival(end, (value, t));
            }
        }
    }
}
