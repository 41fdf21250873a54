//! The equations of motion of one state in double-double precision, 32 digits.

mod elimination;
mod least_norm;
mod saddle_point;

use qrm_core::{DoubleDouble, Scalar, Tape, TapeEvaluator};

use self::elimination::Elimination;
use self::least_norm::least_norm;
pub(crate) use self::saddle_point::PreciseSaddlePoint;

/// A double-double number, about 32 digits.
pub(crate) type Number = DoubleDouble;

/// The equations of motion of a mechanism, evaluated by its tape.
///
/// States are coordinates followed by rates. Accelerations, multipliers and corrections solve a saddle-point system
/// `M x + C_q' w = f`, `C_q x = -b`, in which `C_q` has independent rows.
#[derive(Clone, Debug)]
pub(crate) struct PreciseEquations<'t> {
    pub(crate) evaluator: TapeEvaluator<'t, Vec<Number>>,
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
    /// The number of operations for accelerations so far.
    pub(crate) operations: u64,
}

impl<'t> PreciseEquations<'t> {
    /// Creates the equations with these values of all parameters.
    pub(crate) fn new(tape: &'t Tape, parameters: &[f64], independent: Vec<usize>) -> Self {
        let n = tape.coordinates as usize;
        let size = n + independent.len();
        let zero = |size| vec![Number::zero(); size];
        Self {
            evaluator: TapeEvaluator::with_parameters(tape, parameters),
            independent,
            saddle: Elimination::zero(size),
            right: zero(size),
            solution: zero(size),
            dynamics: zero(tape.dynamics_length()),
            constraints: zero(tape.loop_constraints.results.len()),
            mass_matrix: zero(n * n),
            operations: 0,
        }
    }

    /// Replaces the constraints by these ones, which are independent of each other.
    pub(crate) fn with_constraints(self, independent: Vec<usize>) -> Self {
        let size = self.evaluator.tape().coordinates as usize + independent.len();
        let [right, solution] = [(); 2].map(|()| vec![Number::zero(); size]);
        Self { independent, saddle: Elimination::zero(size), right, solution, ..self }
    }

    /// The constraints that are independent of each other.
    pub(crate) fn independent(&self) -> &[usize] {
        &self.independent
    }

    /// Computes the accelerations of a state, and the multipliers of the independent constraints behind them; `None` if
    /// they are not determined.
    pub(crate) fn accelerations(&mut self, t: Number, y: &[Number]) -> Option<&[Number]> {
        let (q, qd) = y.split_at(y.len() / 2);
        let (n, size) = (q.len(), self.right.len() as u64);
        let tape = self.evaluator.tape();
        let of_momenta = tape.momenta.as_ref().map_or(0, |momenta| n * momenta.operations.len());
        let of_dynamics = (tape.dynamics.operations.len() + of_momenta) as u64;
        self.operations += of_dynamics + size * size * (size / 3 + 1);
        self.evaluator.dynamics(t, q, qd, &mut self.dynamics);
        let [mass_matrix, forces, jacobian, bias] = self.evaluator.tape().split_dynamics(&self.dynamics);
        write_saddle(self.saddle.entries_mut(), n, mass_matrix, (jacobian, &self.independent));
        self.right[..n].copy_from_slice(forces);
        self.right[n..].iter_mut().zip(&self.independent).for_each(|(right, &k)| *right = -bias[k]);
        self.saddle.factor().then(|| self.solve())??;
        Some(&self.solution)
    }

    /// The multipliers of all constraints with the last accelerations; those of least norm where constraints repeat
    /// others, and `None` if they are not determined.
    pub(crate) fn multipliers(&self) -> Option<Vec<Number>> {
        let tape = self.evaluator.tape();
        let [_, _, jacobian, bias] = tape.split_dynamics(&self.dynamics);
        let n = tape.coordinates as usize;
        let own = &self.solution[n..];
        if own.len() == bias.len() { Some(own.to_vec()) } else { least_norm(jacobian, n, &self.independent, own) }
    }

    /// Sets the metric of corrections to the mass matrix of a position.
    pub(crate) fn set_metric(&mut self, q: &[Number]) {
        self.evaluator.mass_matrix(q, &mut self.mass_matrix);
    }

    /// Moves coordinates by a step of Newton's method towards the constraints, in the metric, which squares their
    /// error. Returns the largest correction; `None` if it is not determined.
    pub(crate) fn correct_coordinates(&mut self, t: Number, q: &mut [Number]) -> Option<f64> {
        let (n, m) = (q.len(), self.independent.len());
        if m == 0 {
            return Some(0.0);
        }
        self.evaluator.loop_constraints(t, q, &mut self.constraints);
        let [residuals, jacobian, _] = self.evaluator.tape().split_loop_constraints(&self.constraints);
        write_saddle(self.saddle.entries_mut(), n, &self.mass_matrix, (jacobian, &self.independent));
        self.right[..n].fill(Number::zero());
        self.right[n..].iter_mut().zip(&self.independent).for_each(|(right, &k)| *right = -residuals[k]);
        self.saddle.factor().then(|| self.solve())??;
        Some(add(&self.solution, q))
    }

    /// Moves the rates of a state onto the tangent space of the constraints, with the factors of the last correction;
    /// `None` if that is not determined.
    pub(crate) fn correct_rates(&mut self, t: Number, y: &mut [Number]) -> Option<f64> {
        let n = y.len() / 2;
        if self.independent.is_empty() {
            return Some(0.0);
        }
        let residuals = self.residuals(t, y, true);
        self.right[n..].iter_mut().zip(&self.independent).for_each(|(right, &k)| *right = -residuals[k]);
        self.solve()?;
        Some(add(&self.solution, &mut y[n..]))
    }

    /// The residuals of the constraints, `C`, or of their rates, `C_q qd + C_t`.
    pub(crate) fn residuals(&mut self, t: Number, y: &[Number], rates: bool) -> Vec<Number> {
        let (q, qd) = y.split_at(y.len() / 2);
        self.evaluator.loop_constraints(t, q, &mut self.constraints);
        let [residuals, jacobian, constraint_rate] = self.evaluator.tape().split_loop_constraints(&self.constraints);
        if !rates {
            return residuals.to_vec();
        }
        let rows = jacobian.chunks_exact(q.len().max(1)).zip(constraint_rate);
        rows.map(|(row, rate)| row.iter().zip(qd).fold(*rate, |sum, (entry, qd)| sum + *entry * *qd)).collect()
    }

    fn solve(&mut self) -> Option<()> {
        self.saddle.solve(&self.right, &mut self.solution);
        self.solution.iter().all(|x| x.to_f64().is_finite()).then_some(())
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

/// Adds changes to numbers; returns the largest change.
fn add(changes: &[Number], to: &mut [Number]) -> f64 {
    let mut largest: f64 = 0.0;
    for (x, change) in to.iter_mut().zip(changes) {
        *x = *x + *change;
        largest = largest.max(change.to_f64().abs());
    }
    largest
}
