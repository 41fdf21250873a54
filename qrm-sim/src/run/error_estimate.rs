//! Estimated errors of the quantities of a run.

use super::extremes::{Extremes, reach, sign};
use super::quantities::Quantities;
use crate::columns::Kind;

/// The random walk of rounding errors per step, in units in the last place of the largest coordinate (measured).
const ROUNDING_PER_STEP: f64 = 0.2;

/// Estimated errors of the quantities of a run.
#[derive(Clone, Debug)]
pub struct ErrorEstimates {
    pub(crate) quantities: Quantities,
    /// The time of the first row.
    pub(crate) start: f64,
    pub(crate) largest: Vec<f64>,
    pub(crate) at_extremes: [Vec<f64>; 2],
    /// The values and errors of turning points that may be the extremes.
    pub(crate) rivals: [Vec<(f64, f64)>; 2],
    pub(crate) at_end: Vec<f64>,
    pub(crate) of_end_time: Option<f64>,
    /// The end of the motion, and the changes of the quantities over the error of its time; none at a fixed time.
    pub(crate) at_event: (f64, Vec<f64>),
}

/// The estimated error of a quantity, in its unit.
#[derive(Clone, Copy, Debug)]
pub struct ErrorEstimate {
    /// The largest error in any row.
    pub largest: f64,
    /// The error in the last row.
    pub at_end: f64,
}

impl ErrorEstimates {
    /// Increases errors to others of the same run.
    pub(crate) fn increase_to(&mut self, others: &Self) {
        let increase = |own: &mut Vec<f64>, others: &[f64]| {
            own.iter_mut().zip(others).for_each(|(own, other)| *own = own.max(*other));
        };
        increase(&mut self.largest, &others.largest);
        increase(&mut self.at_end, &others.at_end);
        increase(&mut self.at_event.1, &others.at_event.1);
        self.at_extremes.iter_mut().zip(&others.at_extremes).for_each(|(own, other)| increase(own, other));
        for (end, (own, others)) in self.rivals.iter_mut().zip(&others.rivals).enumerate() {
            let pairs = own.iter_mut().zip(others);
            pairs.filter(|(own, other)| reach(end, **other) > reach(end, **own)).for_each(|(own, other)| *own = *other);
        }
        self.of_end_time = self.of_end_time.map(|own| own.max(others.of_end_time.unwrap_or(0.0)));
    }

    /// The error of a quantity; `None` for times, parameters and residuals.
    pub fn column(&self, kind: Kind) -> Option<ErrorEstimate> {
        let place = self.quantities.place(kind)?;
        Some(ErrorEstimate { largest: self.largest[place], at_end: self.at_end[place] + self.of_event(place) })
    }

    /// The errors of the smallest and of the largest value of a quantity. That of the motion is zero in the first row;
    /// another turning point may exceed the value by its own error.
    pub fn extremes(&self, kind: Kind, extremes: &Extremes) -> Option<[f64; 2]> {
        let place = self.quantities.place(kind)?;
        let error = |end: usize, (value, t): (f64, f64)| {
            let of_event = if t == self.at_event.0 { self.of_event(place) } else { 0.0 };
            let of_motion = if t == self.start { 0.0 } else { self.at_extremes[end][place] + of_event };
            of_motion.max(reach(end, self.rivals[end][place]) - sign(end) * value)
        };
        Some([error(0, extremes.minimum), error(1, extremes.maximum)])
    }

    /// Increases the errors of extremes that outputs may exceed: the output, the end and the distance.
    pub(crate) fn note_open(&mut self, open: &[(usize, usize, f64)]) {
        for (output, end, distance) in open {
            if let Some(place) = self.quantities.place(Kind::Output(*output))
                && let Some(error) = self.at_extremes[*end].get_mut(place)
            {
                *error = error.max(*distance);
            }
        }
    }

    /// The change of a quantity at the end over the error of the time of the end.
    fn of_event(&self, place: usize) -> f64 {
        self.at_event.1.get(place).copied().unwrap_or(0.0)
    }

    /// The error of the time at which a condition ended the run, in s; `None` if the run ended at a fixed time.
    pub fn end_time(&self) -> Option<f64> {
        self.of_end_time
    }

    /// The largest error of each coordinate in any row.
    pub fn coordinates(&self) -> &[f64] {
        &self.largest[..self.quantities.n]
    }
}

/// The accumulated rounding error after a number of steps with coordinates of this size.
pub(crate) fn rounding(size: f64, steps: u64) -> f64 {
    ROUNDING_PER_STEP * f64::EPSILON * size * (steps as f64).sqrt()
}
