//! The equations of a mechanism at rest, with their derivatives by coordinates, rates and parameters.

use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;
use qrm_core::{Mechanism, Scalar, Tape, TapeEvaluator};

use super::error::NoModes;
use super::null_space::{NullSpace, length};
use super::seeds::{First, constants, seeded, unit};
use crate::differentiated::{Differentiated, PARTS, derivative, differentiated};
use crate::position::Start;
use crate::solve::{Dynamics, LoopConstraints};

/// A number with derivatives, and the derivatives of these along a direction.
type Second = Differentiated<Dual64>;

/// The equations `r(q, lambda) = -fbar + C_q' lambda = 0`, `C(q) = 0` of a mechanism at rest at `t = 0`.
pub(in crate::analysis) struct RestEquations<'m> {
    pub(in crate::analysis) mechanism: &'m dyn Mechanism,
    pub(in crate::analysis) tape: &'m Tape,
    first: TapeEvaluator<'m, Vec<First>>,
    second: TapeEvaluator<'m, Vec<Second>>,
    /// The values of parameters that do not have those of the scene.
    replaced: Vec<Option<f64>>,
    /// The largest length at the start of the scene.
    pub(in crate::analysis) length: f64,
}

/// The length of a mechanism in whose start all lengths are zero, in m.
const NO_LENGTH: f64 = 1e-3;

/// The equations at a position.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct RestState {
    pub(in crate::analysis) q: Vec<f64>,
    pub(in crate::analysis) mass: DMatrix<f64>,
    pub(in crate::analysis) forces: DVector<f64>,
    /// `C_q`
    pub(in crate::analysis) jacobian: DMatrix<f64>,
    pub(in crate::analysis) multipliers: DVector<f64>,
    /// `(C_q' lambda - fbar)_q`
    pub(in crate::analysis) stiffness: DMatrix<f64>,
    /// `-fbar_qd`
    pub(in crate::analysis) damping: DMatrix<f64>,
    /// The sums of the sizes of the terms of the stiffness.
    pub(in crate::analysis) stiffness_terms: DMatrix<f64>,
    pub(in crate::analysis) null_space: NullSpace,
}

/// Derivatives of the equations by parameters.
pub(in crate::analysis) struct ByParameters {
    /// `r_p`, `n` by the number of parameters.
    pub(in crate::analysis) forces: DMatrix<f64>,
    /// `C_p`
    pub(in crate::analysis) constraints: DMatrix<f64>,
    /// Whether each parameter changes the constraints.
    pub(in crate::analysis) changes_constraints: Vec<bool>,
    /// Whether each parameter changes the mass matrix.
    pub(in crate::analysis) changes_mass: Vec<bool>,
}

/// A solution `(v, mu)` of the pencil of coordinates and multipliers, or a left one.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct PencilVector {
    pub(in crate::analysis) v: DVector<f64>,
    pub(in crate::analysis) mu: DVector<f64>,
}

/// The derivatives of a number by coordinates, multipliers and parameters.
pub(in crate::analysis) struct Gradient {
    pub(in crate::analysis) q: DVector<f64>,
    pub(in crate::analysis) multipliers: DVector<f64>,
    pub(in crate::analysis) parameters: DVector<f64>,
}

impl<'m> RestEquations<'m> {
    pub(in crate::analysis) fn new(mechanism: &'m dyn Mechanism, tape: &'m Tape) -> Self {
        let replaced = replaced(tape, mechanism.parameters());
        let mut first = TapeEvaluator::<Vec<First>>::new(tape);
        first.set_parameters(|i| replaced[i].map(First::from_f64));
        let q = Start::new(mechanism).q;
        let jacobian = LoopConstraints::at(mechanism, 0.0, &q).constraint_jacobian;
        let length = length(mechanism.description(), &q, |k, i| jacobian[k][i]);
        let length = if length.is_normal() { length } else { NO_LENGTH };
        Self { mechanism, tape, first, second: TapeEvaluator::new(tape), replaced, length }
    }

    /// The values of the parameters.
    pub(in crate::analysis) fn parameters(&self) -> &'m [f64] {
        self.mechanism.parameters()
    }

    /// The numbers of coordinates and constraints.
    pub(in crate::analysis) fn sizes(&self) -> [usize; 2] {
        [self.tape.coordinates as usize, self.tape.constraints as usize]
    }

    /// The equations at a closed position; `preferred` are the coordinates that should be the independent ones.
    ///
    /// # Errors
    /// The position is singular, or a number is not finite.
    pub(in crate::analysis) fn at(&mut self, q: &[f64], preferred: &[bool]) -> Result<RestState, NoModes> {
        let [n, m] = self.sizes();
        let not_finite = || NoModes::NotFinite { q: q.to_vec() };
        let dynamics = Dynamics::at(self.mechanism, 0.0, q, &vec![0.0; n]);
        let jacobian = DMatrix::from_fn(m, n, |k, i| dynamics.constraint_jacobian[k][i]);
        let mass = DMatrix::from_fn(n, n, |i, j| dynamics.mass_matrix[i][j]);
        let forces = DVector::from_column_slice(&dynamics.generalized_forces);
        if !jacobian.iter().chain(mass.iter()).chain(forces.iter()).all(|entry| entry.is_finite()) {
            return Err(not_finite());
        }
        let [mut stiffness, mut damping] = [(); 2].map(|()| DMatrix::zeros(n, n));
        // The derivatives of `C_q`, for each coordinate a matrix.
        let mut curvature = vec![DMatrix::<f64>::zeros(m, n); n];
        let mut results = vec![First::zero(); self.tape.dynamics_length()];
        for from in (0..2 * n).step_by(PARTS) {
            let [q, qd] = [(q, 0), (&vec![0.0; n], n)].map(|(values, first)| seeded(values, first, from));
            self.first.dynamics(First::zero(), &q, &qd, &mut results);
            let [_, forces, jacobian, _] = self.tape.split_dynamics(&results);
            for part in 0..PARTS.min(2 * n - from) {
                let seed = from + part;
                for i in 0..n {
                    let by = -derivative(&forces[i], part);
                    match seed.checked_sub(n) {
                        None => stiffness[(i, seed)] = by,
                        Some(rate) => damping[(i, rate)] = by,
                    }
                }
                if let Some(curvature) = curvature.get_mut(seed) {
                    for (place, entry) in jacobian.iter().enumerate() {
                        curvature[(place / n, place % n)] = derivative(entry, part);
                    }
                }
            }
        }
        let null_space =
            NullSpace::new(self.mechanism.description(), q, (&jacobian, &curvature), (preferred, self.length))
                .ok_or_else(|| NoModes::Singular { q: q.to_vec() })?;
        let multipliers = null_space.multipliers(&forces);
        let mut stiffness_terms = stiffness.abs();
        for (j, curvature) in curvature.iter().enumerate() {
            for i in 0..n {
                for k in 0..m {
                    let term = multipliers[k] * curvature[(k, i)];
                    stiffness[(i, j)] += term;
                    stiffness_terms[(i, j)] += term.abs();
                }
            }
        }
        if !stiffness.iter().chain(damping.iter()).all(|entry: &f64| entry.is_finite()) {
            return Err(not_finite());
        }
        let q = q.to_vec();
        Ok(RestState { q, mass, forces, jacobian, multipliers, stiffness, damping, stiffness_terms, null_space })
    }

    /// The derivatives of the equations by all parameters.
    pub(in crate::analysis) fn by_parameters(&mut self, at: &RestState) -> ByParameters {
        let [n, m] = self.sizes();
        let count = self.parameters().len();
        let mut by = ByParameters {
            forces: DMatrix::zeros(n, count),
            constraints: DMatrix::zeros(m, count),
            changes_constraints: vec![false; count],
            changes_mass: vec![false; count],
        };
        let (q, qd) = (constants(&at.q), vec![First::zero(); n]);
        let mut results = vec![First::zero(); self.tape.dynamics_length()];
        let mut constraints = vec![First::zero(); self.tape.loop_constraints.results.len()];
        for from in (0..count).step_by(PARTS) {
            self.seed_parameters(Some(from));
            self.first.dynamics(First::zero(), &q, &qd, &mut results);
            self.first.loop_constraints(First::zero(), &q, &mut constraints);
            let [mass, forces, jacobian, _] = self.tape.split_dynamics(&results);
            let [residuals, ..] = self.tape.split_loop_constraints(&constraints);
            for part in 0..PARTS.min(count - from) {
                let p = from + part;
                for i in 0..n {
                    let of_constraints = |k: usize| at.multipliers[k] * derivative(&jacobian[k * n + i], part);
                    by.forces[(i, p)] = (0..m).map(of_constraints).sum::<f64>() - derivative(&forces[i], part);
                }
                for k in 0..m {
                    by.constraints[(k, p)] = derivative(&residuals[k], part);
                }
                let changes = |numbers: &[First]| numbers.iter().any(|number| derivative(number, part) != 0.0);
                by.changes_constraints[p] = changes(residuals) || changes(jacobian);
                by.changes_mass[p] = changes(mass);
            }
        }
        self.seed_parameters(None);
        by
    }

    /// The derivatives of `w' (A - square B) z` by coordinates, multipliers and parameters, where
    /// `A = [K, C_q'; C_q, 0]`, `B = [Mbar, 0; 0, 0]`, and `z`, `w` are right and left solutions.
    pub(in crate::analysis) fn gradient(
        &mut self,
        at: &RestState,
        [right, left]: [&PencilVector; 2],
        square: f64,
    ) -> Gradient {
        let [n, m] = self.sizes();
        let count = self.parameters().len();
        let mut gradient =
            Gradient { q: DVector::zeros(n), multipliers: DVector::zeros(m), parameters: DVector::zeros(count) };
        let qd = vec![Second::zero(); n];
        let mut results = vec![Second::zero(); self.tape.dynamics_length()];
        for from in (0..n + count).step_by(PARTS) {
            let part = |seed: usize| seed.checked_sub(from).filter(|part| *part < PARTS);
            let unit = |place: Option<usize>| {
                std::array::from_fn(|part| Dual64::from(if place == Some(part) { 1.0 } else { 0.0 }))
            };
            let (replaced, values) = (&self.replaced, self.mechanism.parameters());
            self.second.set_parameters(|i| match part(n + i) {
                None => replaced[i].map(Second::from_f64),
                place => Some(differentiated(Dual64::from(values[i]), unit(place))),
            });
            let along = |i: usize| differentiated(Dual64::new(at.q[i], right.v[i]), unit(part(i)));
            let q: Vec<Second> = (0..n).map(along).collect();
            self.second.dynamics(Second::zero(), &q, &qd, &mut results);
            let [mass, forces, jacobian, _] = self.tape.split_dynamics(&results);
            if from == 0 {
                for k in 0..m {
                    gradient.multipliers[k] = (0..n).map(|i| left.v[i] * jacobian[k * n + i].0.re.eps).sum();
                }
            }
            for part in 0..PARTS.min(n + count - from) {
                let mut sum = 0.0;
                for i in 0..n {
                    sum -= left.v[i] * derivative(&forces[i], part).eps;
                    for j in 0..n {
                        sum -= square * left.v[i] * right.v[j] * derivative(&mass[i * n + j], part).re;
                    }
                    for k in 0..m {
                        let by = derivative(&jacobian[k * n + i], part);
                        sum += left.v[i] * (at.multipliers[k] * by.eps + right.mu[k] * by.re);
                        sum += left.mu[k] * right.v[i] * by.re;
                    }
                }
                match (from + part).checked_sub(n) {
                    None => gradient.q[from + part] = sum,
                    Some(p) => gradient.parameters[p] = sum,
                }
            }
        }
        gradient
    }

    /// The evaluator on numbers with derivatives by the parameters from this one on, or by none of them.
    pub(in crate::analysis) fn with_parameters(&mut self, from: Option<usize>) -> &mut TapeEvaluator<'m, Vec<First>> {
        self.seed_parameters(from);
        &mut self.first
    }

    fn seed_parameters(&mut self, from: Option<usize>) {
        let (replaced, values) = (&self.replaced, self.mechanism.parameters());
        self.first.set_parameters(|i| {
            let part = from.and_then(|from| i.checked_sub(from)).filter(|part| *part < PARTS);
            match part {
                None => replaced[i].map(First::from_f64),
                Some(part) => Some(differentiated(values[i], unit(part))),
            }
        });
    }
}

impl RestState {
    /// The generalized forces on the independent coordinates that are not balanced: `N' r`.
    pub(in crate::analysis) fn unbalanced(&self) -> DVector<f64> {
        self.null_space.basis.transpose() * (self.jacobian.transpose() * &self.multipliers - &self.forces)
    }
}

/// The parameters whose values differ from those that the scene gives them, with these values; the scene computes some
/// from others.
fn replaced(tape: &Tape, values: &[f64]) -> Vec<Option<f64>> {
    let mut replaced = vec![None; values.len()];
    let mut evaluator = TapeEvaluator::<Vec<f64>>::new(tape);
    loop {
        evaluator.set_parameters(|i| replaced[i]);
        let own = evaluator.parameters();
        let differs = |i: &usize| own[*i].to_bits() != values[*i].to_bits() && replaced[*i].is_none();
        let Some(first) = (0..values.len()).find(differs) else { return replaced };
        replaced[first] = Some(values[first]);
    }
}
