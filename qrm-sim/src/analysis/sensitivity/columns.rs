//! The outputs of a motion on dual numbers: their ends, extremes and integrals.

use num_dual::DualStruct;
use qrm_core::Scalar;

use super::equations::{DualEquations, DualState};
use super::error::SensitivityError;
use super::number::{Derived, Inner, Number, has_derivatives};
use super::result::Output;
use crate::run::{Extremes, ExtremesTracker, Integral, Vertex};

/// The places of the rows beside an extreme, as parts of two steps. None of them is the extreme itself: its time would
/// not be seen to change.
const PLACES: [f64; 5] = [-2.5 / 16.0, -1.5 / 16.0, -0.5 / 16.0, 0.5 / 16.0, 1.5 / 16.0];

/// Follows the outputs row by row.
pub(super) struct Columns<T: Inner> {
    extremes: ExtremesTracker<Derived<T>>,
    integrals: Vec<Integral<Derived<T>>>,
    /// The last row.
    outputs: Vec<Number<T>>,
}

impl<T: Inner> Columns<T> {
    pub(super) fn new(count: usize) -> Self {
        Self {
            extremes: ExtremesTracker::default(),
            integrals: vec![Integral::default(); count],
            outputs: vec![Number::zero(); count],
        }
    }

    /// Takes the next row.
    ///
    /// # Errors
    /// An output has no value or no derivative.
    pub(super) fn row(&mut self, equations: &mut DualEquations<T>, at: &DualState<T>) -> Result<(), SensitivityError> {
        self.outputs = equations.outputs(at)?;
        for (integral, output) in self.integrals.iter_mut().zip(&self.outputs) {
            if !(output.to_f64().is_finite() && has_derivatives(output)) {
                return Err(SensitivityError::NotSmooth { t: at.t.to_f64() });
            }
            integral.row(at.t.0, output.0);
        }
        let values: Vec<Derived<T>> = self.outputs.iter().map(|output| output.0).collect();
        self.extremes.row(at.t.0, &values);
        Ok(())
    }

    /// Looks for new extremes once more, between rows that are nearer to each other; `outputs` makes them.
    ///
    /// # Errors
    /// A row cannot be made.
    pub(super) fn refine(
        &mut self,
        mut outputs: impl FnMut(f64) -> Result<Vec<Number<T>>, SensitivityError>,
    ) -> Result<(), SensitivityError> {
        for vertex in self.extremes.take_vertices() {
            let Vertex { column, end, estimate, bracket, .. } = vertex;
            let (t, [begin, beyond]) = (estimate.1.re(), bracket.map(|t| t.re()));
            if !(begin < t && t < beyond) {
                continue;
            }
            let times = PLACES.map(|place| t + place * (beyond - begin));
            let mut tracker = ExtremesTracker::default();
            for t in times {
                tracker.row(Derived::from(t), &[outputs(t)?[column].0]);
            }
            tracker.finish();
            tracker.note_estimates();
            let Extremes { minimum, maximum, .. } = tracker.found()[0];
            let found = [minimum, maximum][end];
            let is_inside = times[0] < found.1.re() && found.1.re() < times[4];
            if is_inside {
                self.extremes.note_located(&vertex, found);
            } else {
                self.extremes.note(&vertex, estimate);
            }
        }
        Ok(())
    }

    /// Takes up what the rows so far do not tell, as no more follow.
    pub(super) fn finish(&mut self) {
        self.extremes.finish();
    }

    /// The results for each output.
    pub(super) fn outputs(&self) -> Vec<Output<T>> {
        let output = |i: usize| Output {
            end: self.outputs[i].0,
            extremes: self.extremes.found()[i],
            integral: self.integrals[i].finish(),
        };
        (0..self.outputs.len()).map(output).collect()
    }
}
