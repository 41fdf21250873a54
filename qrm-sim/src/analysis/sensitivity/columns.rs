//! The outputs of a motion on dual numbers: their ends, extremes and integrals.

use qrm_core::Scalar;

use super::SensitivityError;
use super::equations::{DualEquations, DualState};
use super::number::{Derived, Inner, Number, has_derivatives};
use super::result::Output;
use crate::run::{Extremes, ExtremesTracker, Integral};

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
        equations.evaluator.outputs(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut self.outputs);
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

    /// The results for each output.
    pub(super) fn finish(mut self) -> Vec<Output<T>> {
        self.extremes.finish();
        let columns = self.integrals.iter().zip(&self.outputs).zip(self.extremes.found());
        let output = |((integral, end), extremes): ((&Integral<Derived<T>>, &Number<T>), &Extremes<Derived<T>>)| {
            Output { end: end.0, extremes: *extremes, integral: integral.finish() }
        };
        columns.map(output).collect()
    }
}
