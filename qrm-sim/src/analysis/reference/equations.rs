//! The equations of motion of a reference: their start, slopes and complete states.

use qrm_core::{Mechanism, Scalar};

use crate::analysis::measure::StateAt;
use crate::integrate::StepError;
use crate::position::{DependentCoordinates, NotAssembled, Start, assemble};
use crate::solve::{LoopConstraints, Number, PivotedLdl, PreciseEquations, constraint_rank, row_products};

/// The largest number of operations in one run: a few seconds.
const MOST_OPERATIONS: u64 = 100_000_000;

/// The number of passes to a start on the constraints. Each adds about twelve digits to the initial sixteen.
const PASSES: usize = 4;

impl PreciseEquations<'_> {
    /// Removes the constraints that are redundant along the motion from a closed position.
    pub(super) fn without_redundancy(self, mechanism: &dyn Mechanism, q: &[Number]) -> Self {
        let q: Vec<f64> = q.iter().map(|q| q.to_f64()).collect();
        let rank = constraint_rank(mechanism, 0.0, &q);
        if rank == self.independent().len() {
            return self;
        }
        let jacobian = LoopConstraints::at(mechanism, 0.0, &q).constraint_jacobian;
        let mut independent = PivotedLdl::with_rank(&row_products(&jacobian), rank).independent().to_vec();
        independent.sort_unstable();
        self.with_constraints(independent)
    }

    /// Computes coordinates and rates at the start: given ones are kept, the others follow from the constraints.
    ///
    /// # Errors
    /// The constraints cannot be satisfied.
    pub(super) fn start(&mut self, mechanism: &dyn Mechanism) -> Result<Vec<Number>, NotAssembled> {
        let start = Start::new(mechanism);
        let (q, qd) = assemble(mechanism, Start::new(mechanism))?;
        let n = q.len();
        let mut y = vec![Number::zero(); 2 * n];
        let (own_q, own_qd) = y.split_at_mut(n);
        self.evaluator.start(own_q, own_qd);
        let given = || start.given.iter().chain(&start.given_rates);
        for ((own, value), given) in y.iter_mut().zip(q.iter().chain(&qd)).zip(given()) {
            if !given {
                *own = (*value).into();
            }
        }
        // The Jacobian in double precision suffices for corrections of the last digits.
        let jacobian = LoopConstraints::at(mechanism, 0.0, &q).constraint_jacobian;
        for (rates, given) in [(false, &start.given), (true, &start.given_rates)] {
            let dependents = DependentCoordinates::new(&jacobian, given);
            for _ in 0..PASSES {
                let residuals: Vec<f64> =
                    self.residuals(Number::zero(), &y, rates).iter().map(|residual| residual.to_f64()).collect();
                let mut change = vec![0.0; n];
                dependents.follow(&mut change, &residuals);
                let moved = &mut y[if rates { n } else { 0 }..][..n];
                moved.iter_mut().zip(change).for_each(|(x, change)| *x = *x + change.into());
            }
        }
        Ok(y)
    }

    /// Whether the operations of a run are used up.
    pub(super) fn is_spent(&self) -> bool {
        self.operations > MOST_OPERATIONS
    }

    /// The derivative of a state with respect to time: rates, then accelerations.
    ///
    /// # Errors
    /// The accelerations are not determined.
    pub(super) fn slope(&mut self, t: Number, y: &[Number], slope: &mut [Number]) -> Result<(), StepError> {
        let n = y.len() / 2;
        let accelerations = self.accelerations(t, y).ok_or(StepError::NotFinite)?;
        slope[n..].copy_from_slice(&accelerations[..n]);
        slope[..n].copy_from_slice(&y[n..]);
        Ok(())
    }

    /// Projects a state that is near the constraints onto them, by the smallest corrections in the mass metric.
    ///
    /// One step of Newton's method suffices: it squares errors that are as small as a tolerance.
    ///
    /// # Errors
    /// The corrections are not determined.
    pub(super) fn project(&mut self, t: Number, y: &mut [Number]) -> Result<(), StepError> {
        let n = y.len() / 2;
        self.set_metric(&y[..n]);
        let corrected = self.correct_coordinates(t, &mut y[..n]).and_then(|_| self.correct_rates(t, y));
        corrected.map(drop).ok_or(StepError::NotFinite)
    }

    /// Rounds a state, and adds outputs and checks.
    ///
    /// # Errors
    /// The accelerations are not determined.
    pub(super) fn described(&mut self, t: Number, y: &[Number]) -> Result<StateAt, StepError> {
        let (q, qd) = y.split_at(y.len() / 2);
        let qdd = self.accelerations(t, y).ok_or(StepError::NotFinite)?[..q.len()].to_vec();
        let multipliers = self.multipliers().ok_or(StepError::NotFinite)?;
        let mut outputs = vec![Number::zero(); self.evaluator.tape().outputs.results.len()];
        self.evaluator.outputs(t, q, qd, &qdd, &multipliers, &mut outputs);
        let power = self.evaluator.power(t, q, qd, &qdd, &multipliers).to_f64();
        let [kinetic, potential] = self.evaluator.energy(q, qd);
        let doubles = |numbers: &[Number]| numbers.iter().map(|number| number.to_f64()).collect::<Vec<f64>>();
        let residual = doubles(&self.residuals(t, y, false)).into_iter().map(f64::abs).fold(0.0, f64::max);
        Ok(StateAt {
            t: t.to_f64(),
            q: doubles(q),
            qd: doubles(qd),
            qdd: doubles(&qdd),
            multipliers: doubles(&multipliers),
            outputs: doubles(&outputs),
            residual,
            energy: (kinetic + potential).to_f64(),
            power,
        })
    }
}
