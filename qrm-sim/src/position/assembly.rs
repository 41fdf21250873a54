//! The consistent start: given values are kept, the others are solved for.

use qrm_core::{Description, Mechanism};

use super::loop_solver::{LoopSolver, Position};
use super::start::Start;
use crate::solve::{LoopConstraints, Matrix, PivotedLdl, largest, least_squares, row_products, subtract_combination};

/// The constraints cannot be satisfied with the given values.
#[derive(Clone, Debug, PartialEq)]
pub struct NotAssembled {
    /// The constraint that cannot be satisfied.
    pub constraint: usize,
    /// The residual of this constraint if all others are satisfied: a length or angle for positions, its rate for
    /// rates.
    pub residual: f64,
    /// The nearest position found.
    pub q: Vec<f64>,
    /// Whether the rates, instead of the positions, cannot be solved for.
    pub rates: bool,
    /// Whether all constraints can be satisfied, but only on another branch than with the scene's own parameters.
    pub is_other_branch: bool,
}

/// The largest residual of an assembled position, in rad, or relative to the size of the mechanism.
const CLOSED: f64 = 1e-12;

/// Computes coordinates at t = 0 by damped Gauss-Newton iteration from the guesses, and rates by one linear solve.
///
/// # Errors
/// Some constraint cannot be satisfied.
pub fn assemble_from_guesses(mechanism: &dyn Mechanism, start: &Start) -> Result<(Vec<f64>, Vec<f64>), NotAssembled> {
    let weights = vec![1.0; mechanism.description().constraints.len()];
    let mut constraints = LoopConstraints::zero(start.q.len(), weights.len());
    let found = search(mechanism, start, &start.q, &weights, &mut constraints);
    constraints.evaluate(mechanism, 0.0, &found);
    if !is_closed(mechanism.description(), &constraints, &found) {
        return Err(find_open_constraint(mechanism, start, &found, &mut constraints));
    }
    let qd = rates(&constraints, start, &found)?;
    Ok((found, qd))
}

/// The coordinates of a closed position, and its rates; `None` if they do not satisfy the constraints.
pub(crate) fn completed(drive: &LoopSolver, start: &Start, position: Position) -> Option<(Vec<f64>, Vec<f64>)> {
    if !is_closed(drive.mechanism.description(), &position.constraints, &position.q) {
        return None;
    }
    let qd = if start.given == start.given_rates && !drive.mechanism.is_driven() {
        drive.linear_change(&position, |i| start.qd[i])
    } else {
        rates(&position.constraints, start, &position.q).ok()?
    };
    Some((position.q, qd))
}

/// Whether every residual is a rounding error, compared with its own terms.
fn is_closed(description: &Description, constraints: &LoopConstraints, q: &[f64]) -> bool {
    let terms = |row: &[f64]| row.iter().zip(q).map(|(derivative, q)| (derivative * q).abs()).sum::<f64>();
    let length = length(description, constraints, q).min(1.0);
    let mut rows = constraints.residuals.iter().zip(constraints.constraint_jacobian.iter()).enumerate();
    rows.all(|(k, (residual, row))| {
        let size = if is_length(description, k) { length } else { 1.0 };
        residual.abs() <= (CLOSED * size).max(64.0 * f64::EPSILON * terms(row))
    })
}

/// Whether the residual of a constraint is a length.
fn is_length(description: &Description, constraint: usize) -> bool {
    description.constraints[constraint].unit != "rad"
}

/// The size of a mechanism near a position: the longest lever of an angle or the largest coordinate that is a length,
/// without its digits after the power of two, so that scaling by it is exact.
fn length(description: &Description, constraints: &LoopConstraints, q: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for (i, position) in q.iter().enumerate() {
        if !description.is_angle(i) {
            largest = largest.max(position.abs());
            continue;
        }
        for (k, row) in constraints.constraint_jacobian.iter().enumerate() {
            if is_length(description, k) {
                largest = largest.max(row[i].abs());
            }
        }
    }
    if largest.is_normal() { f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()) } else { 1.0 }
}

/// Finds the last constraint that stays open when all others are satisfied, and its residual; if there is none, the
/// constraint with the largest residual.
fn find_open_constraint(
    mechanism: &dyn Mechanism,
    start: &Start,
    found: &[f64],
    constraints: &mut LoopConstraints,
) -> NotAssembled {
    let (constraint, residual) = largest(&constraints.residuals);
    let count = constraints.residuals.len();
    let alone = (0..count).rev().find_map(|constraint| {
        let mut weights = vec![1.0; count];
        weights[constraint] = 1e-6;
        let q = search(mechanism, start, found, &weights, constraints);
        constraints.evaluate(mechanism, 0.0, &q);
        let residual = std::mem::replace(&mut constraints.residuals[constraint], 0.0).abs();
        let is_alone = largest(&constraints.residuals).1 <= (1e-3 * residual).min(1e-9);
        is_alone.then_some((constraint, residual, q))
    });
    let (constraint, residual, q) = alone.unwrap_or_else(|| (constraint, residual, found.to_vec()));
    NotAssembled { constraint, residual, q, rates: false, is_other_branch: false }
}

/// Minimizes the weighted residuals over the coordinates that are not given, with the size of the mechanism as the unit
/// of length.
fn search(
    mechanism: &dyn Mechanism,
    start: &Start,
    from: &[f64],
    weights: &[f64],
    constraints: &mut LoopConstraints,
) -> Vec<f64> {
    let description = mechanism.description();
    constraints.evaluate(mechanism, 0.0, from);
    let length = length(description, constraints, from);
    let unit = |i: usize| if description.is_angle(i) { 1.0 } else { length };
    let scaled: Vec<f64> = from.iter().enumerate().map(|(i, q)| q / unit(i)).collect();
    let mut q = from.to_vec();
    let mut found = least_squares(&scaled, &start.given, weights.len(), &mut |scaled, residuals| {
        q.iter_mut().zip(scaled).enumerate().for_each(|(i, (q, scaled))| *q = scaled * unit(i));
        constraints.evaluate(mechanism, 0.0, &q);
        for (k, weight) in weights.iter().enumerate() {
            let weight = if is_length(description, k) { weight / length } else { *weight };
            residuals.values[k] = constraints.residuals[k] * weight;
            let row = constraints.constraint_jacobian[k].iter().enumerate().map(|(i, entry)| entry * weight * unit(i));
            residuals.jacobian[k].iter_mut().zip(row).for_each(|(own, entry)| *own = entry);
        }
    });
    found.iter_mut().enumerate().for_each(|(i, q)| *q *= unit(i));
    found
}

/// The rates that are not given, from `C_q qd + C_t = 0`.
pub(super) fn rates(constraints: &LoopConstraints, start: &Start, q: &[f64]) -> Result<Vec<f64>, NotAssembled> {
    let mut qd: Vec<f64> =
        start.qd.iter().zip(&start.given_rates).map(|(qd, given)| if *given { *qd } else { 0.0 }).collect();
    let dependents = DependentCoordinates::new(&constraints.constraint_jacobian, &start.given_rates);
    // The second pass removes the rounding errors of the first.
    for _ in 0..2 {
        let rates = constraints.velocity_residual(&qd);
        dependents.follow(&mut qd, &rates);
    }
    let (constraint, residual) = largest(&constraints.velocity_residual(&qd));
    let scale = qd.iter().fold(1.0, |most: f64, v| most.max(v.abs()));
    if !(residual <= 1e-9 * scale) {
        return Err(NotAssembled { constraint, residual, q: q.to_vec(), rates: true, is_other_branch: false });
    }
    Ok(qd)
}

/// The coordinates or rates that follow from the given ones through the constraints.
pub(crate) struct DependentCoordinates {
    /// The Jacobian without the columns of given ones.
    rows: Matrix,
    factors: PivotedLdl,
}

impl DependentCoordinates {
    pub(crate) fn new(jacobian: &Matrix, given: &[bool]) -> Self {
        let (m, n) = (jacobian.rows(), jacobian.columns());
        let rows = Matrix::from_fn(m, n, |r, i| if given[i] { 0.0 } else { jacobian[r][i] });
        let factors = PivotedLdl::new(&row_products(&rows));
        Self { rows, factors }
    }

    /// Moves `x` by the smallest `dx` with `C_q dx = -residual`.
    pub(crate) fn follow(&self, x: &mut [f64], residual: &[f64]) {
        let mut weights = residual.to_vec();
        self.factors.solve(&mut weights);
        subtract_combination(x, &self.rows, &weights);
    }
}
