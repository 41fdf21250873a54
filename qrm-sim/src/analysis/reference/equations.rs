//! The equations of motion in double-double precision.

use qrm_core::{Mechanism, Scalar, Tape, TapeEvaluator};

use super::elimination::Elimination;
use super::least_norm::least_norm;
use super::number::Number;
use crate::analysis::measure::StateAt;
use crate::integrate::StepError;
use crate::position::{DependentCoordinates, NotAssembled, Start, assemble};
use crate::solve::{LoopConstraints, PivotedLdl, constraint_rank, row_products};

/// The equations of motion of a mechanism, evaluated by its tape.
///
/// States are coordinates followed by rates. Accelerations, multipliers and corrections solve a saddle-point system
/// `M x + C_q' w = f`, `C_q x = -b`, in which `C_q` has independent rows.
pub(super) struct Equations<'t> {
    pub(super) evaluator: TapeEvaluator<'t, Vec<Number>>,
    /// The constraints that are independent of each other.
    independent: Vec<usize>,
    saddle: Elimination,
    /// Right-hand side of the system, `f` then `-b`, and its solution, `x` then `w`.
    right: Vec<Number>,
    solution: Vec<Number>,
    /// Results of the tape's functions.
    dynamics: Vec<Number>,
    constraints: Vec<Number>,
    mass_matrix: Vec<Number>,
    /// The number of operations left.
    pub(super) budget: u64,
}

/// The largest number of operations in one run: a few seconds.
const BUDGET: u64 = 100_000_000;

/// The number of passes to a start on the constraints. Each adds about twelve digits to the initial sixteen.
const PASSES: usize = 4;

impl<'t> Equations<'t> {
    /// Creates the equations with these values of all parameters, and with all constraints.
    pub(super) fn new(tape: &'t Tape, parameters: &[f64]) -> Self {
        let (n, m) = (tape.coordinates as usize, tape.constraints as usize);
        let zero = |size| vec![Number::zero(); size];
        Self {
            evaluator: TapeEvaluator::with_parameters(tape, parameters),
            independent: (0..m).collect(),
            saddle: Elimination::zero(n + m),
            right: zero(n + m),
            solution: zero(n + m),
            dynamics: zero(tape.dynamics.results.len()),
            constraints: zero(tape.loop_constraints.results.len()),
            mass_matrix: zero(n * n),
            budget: BUDGET,
        }
    }

    /// Takes the independent constraints from equations with the same constraints.
    pub(super) fn with_constraints_of(self, others: &Equations) -> Self {
        self.with_constraints(others.independent.clone())
    }

    /// Removes the constraints that are redundant along the motion from a closed position.
    pub(super) fn without_redundancy(self, mechanism: &dyn Mechanism, q: &[Number]) -> Self {
        let q: Vec<f64> = q.iter().map(|q| q.to_f64()).collect();
        let rank = constraint_rank(mechanism, 0.0, &q);
        if rank == self.independent.len() {
            return self;
        }
        let jacobian = LoopConstraints::at(mechanism, 0.0, &q).constraint_jacobian;
        let mut independent = PivotedLdl::with_rank(&row_products(&jacobian), rank).independent().to_vec();
        independent.sort_unstable();
        self.with_constraints(independent)
    }

    fn with_constraints(self, independent: Vec<usize>) -> Self {
        let size = self.evaluator.tape().coordinates as usize + independent.len();
        let [right, solution] = [(); 2].map(|()| vec![Number::zero(); size]);
        Self { independent, saddle: Elimination::zero(size), right, solution, ..self }
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
        self.budget == 0
    }

    /// The derivative of a state with respect to time: rates, then accelerations.
    ///
    /// # Errors
    /// The accelerations are not determined.
    pub(super) fn slope(&mut self, t: Number, y: &[Number], slope: &mut [Number]) -> Result<(), StepError> {
        let (q, qd) = y.split_at(y.len() / 2);
        let n = q.len();
        self.evaluator.dynamics(t, q, qd, &mut self.dynamics);
        let tape = self.evaluator.tape();
        let [mass_matrix, forces, jacobian, bias] = tape.split_dynamics(&self.dynamics);
        write_saddle(self.saddle.entries_mut(), n, mass_matrix, (jacobian, &self.independent));
        let size = self.right.len() as u64;
        self.budget = self.budget.saturating_sub(tape.dynamics.operations.len() as u64 + size * size * (size / 3 + 1));
        self.right[..n].copy_from_slice(forces);
        self.right[n..].iter_mut().zip(&self.independent).for_each(|(right, &k)| *right = -bias[k]);
        self.factor()?;
        self.solve()?;
        slope[..n].copy_from_slice(qd);
        slope[n..].copy_from_slice(&self.solution[..n]);
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
        if self.right.len() == n {
            return Ok(());
        }
        self.evaluator.mass_matrix(&y[..n], &mut self.mass_matrix);
        self.evaluator.loop_constraints(t, &y[..n], &mut self.constraints);
        let [_, jacobian, _] = self.evaluator.tape().split_loop_constraints(&self.constraints);
        write_saddle(self.saddle.entries_mut(), n, &self.mass_matrix, (jacobian, &self.independent));
        self.factor()?;
        for rates in [false, true] {
            let residuals = self.residuals(t, y, rates);
            self.right[..n].fill(Number::zero());
            self.right[n..].iter_mut().zip(&self.independent).for_each(|(right, &k)| *right = -residuals[k]);
            self.solve()?;
            let moved = &mut y[if rates { n } else { 0 }..][..n];
            moved.iter_mut().zip(&self.solution).for_each(|(x, change)| *x = *x + *change);
        }
        Ok(())
    }

    /// Rounds a state, and adds outputs and checks.
    ///
    /// # Errors
    /// The accelerations are not determined.
    pub(super) fn described(&mut self, t: Number, y: &[Number]) -> Result<StateAt, StepError> {
        let mut slope = y.to_vec();
        self.slope(t, y, &mut slope)?;
        let (q, qd) = y.split_at(y.len() / 2);
        let (qdd, multipliers) = self.solution.split_at(q.len());
        let [_, _, jacobian, bias] = self.evaluator.tape().split_dynamics(&self.dynamics);
        let multipliers = if multipliers.len() == bias.len() {
            multipliers.to_vec()
        } else {
            least_norm(jacobian, q.len(), &self.independent, multipliers).ok_or(StepError::NotFinite)?
        };
        let mut outputs = vec![Number::zero(); self.evaluator.tape().outputs.results.len()];
        self.evaluator.outputs(t, q, qd, qdd, &multipliers, &mut outputs);
        let power = self.evaluator.power(t, q, qd, qdd, &multipliers).to_f64();
        let [kinetic, potential] = self.evaluator.energy(q, qd);
        let doubles = |numbers: &[Number]| numbers.iter().map(|number| number.to_f64()).collect::<Vec<f64>>();
        let (qdd, multipliers) = (doubles(qdd), doubles(&multipliers));
        let residual = doubles(&self.residuals(t, y, false)).into_iter().map(f64::abs).fold(0.0, f64::max);
        Ok(StateAt {
            t: t.to_f64(),
            q: doubles(q),
            qd: doubles(qd),
            qdd,
            multipliers,
            outputs: doubles(&outputs),
            residual,
            energy: (kinetic + potential).to_f64(),
            power,
        })
    }

    /// The residuals of the constraints, `C`, or of their rates, `C_q qd + C_t`.
    pub(super) fn residuals(&mut self, t: Number, y: &[Number], rates: bool) -> Vec<Number> {
        let (q, qd) = y.split_at(y.len() / 2);
        self.evaluator.loop_constraints(t, q, &mut self.constraints);
        let [residuals, jacobian, constraint_rate] = self.evaluator.tape().split_loop_constraints(&self.constraints);
        if !rates {
            return residuals.to_vec();
        }
        let rows = jacobian.chunks_exact(q.len().max(1)).zip(constraint_rate);
        rows.map(|(row, rate)| row.iter().zip(qd).fold(*rate, |sum, (entry, qd)| sum + *entry * *qd)).collect()
    }

    fn factor(&mut self) -> Result<(), StepError> {
        if self.saddle.factor() { Ok(()) } else { Err(StepError::NotFinite) }
    }

    fn solve(&mut self) -> Result<(), StepError> {
        self.saddle.solve(&self.right, &mut self.solution);
        let is_finite = self.solution.iter().all(|x| x.to_f64().is_finite());
        if is_finite { Ok(()) } else { Err(StepError::NotFinite) }
    }
}

/// Writes `[M C_q'; C_q 0]` with some rows of `C_q`.
fn write_saddle(entries: &mut [Number], n: usize, mass_matrix: &[Number], (jacobian, rows): (&[Number], &[usize])) {
    let m = rows.len();
    let size = n + m;
    for i in 0..n {
        entries[i * size..][..n].copy_from_slice(&mass_matrix[i * n..][..n]);
    }
    for (k, row) in rows.iter().enumerate() {
        for i in 0..n {
            entries[i * size + n + k] = jacobian[row * n + i];
            entries[(n + k) * size + i] = jacobian[row * n + i];
        }
        entries[(n + k) * size + n..][..m].fill(Number::zero());
    }
}
