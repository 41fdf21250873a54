//! Solves the loops of a mechanism for given coordinates, from position to position until the mechanism locks.

use std::borrow::Cow;
use std::cmp::Ordering;

use qrm_core::Mechanism;

use super::assembly::assemble_from_guesses;
use super::start::Start;
use crate::solve::{Dynamics, LoopConstraints, Lu, Matrix, PivotedLdl, constraint_rank, dot, largest, row_products};

/// A mechanism whose given coordinates are moved externally, while the others follow from the constraints.
#[derive(Clone)]
pub struct LoopSolver<'m> {
    /// The mechanism.
    pub mechanism: &'m dyn Mechanism,
    /// The time, for constraints that depend on it.
    pub t: f64,
    partition: Cow<'m, CoordinatePartition>,
}

/// The given coordinates, the dependent ones, and the constraints that determine these.
#[derive(Clone, Debug)]
pub(crate) struct CoordinatePartition {
    given: Vec<bool>,
    /// The dependent coordinates, as many as there are independent constraints.
    dependent: Vec<usize>,
    /// The independent constraints.
    independent: Vec<usize>,
}

/// A closed position.
#[derive(Clone, Debug)]
pub struct Position {
    /// The coordinates.
    pub q: Vec<f64>,
    /// The determinant of `C_q` with respect to the dependent coordinates. It is zero where the given coordinates
    /// cannot move the others; other units change it by a constant factor.
    pub determinant: f64,
    /// The constraints at the position.
    pub(crate) constraints: LoopConstraints,
    /// The factors of the block of `C_q` with this determinant.
    block: Lu,
}

impl Position {
    /// Whether the determinant is so close to that of another position that no other branch lies between.
    pub(crate) fn is_on_branch_of(&self, other: &Self) -> bool {
        let change = self.determinant / other.determinant;
        change < SMOOTH && change > 1.0 / SMOOTH
    }
}

/// A limit position: the given coordinates cannot be moved beyond it.
#[derive(Clone, Debug)]
pub struct LimitPosition {
    /// The last position before.
    pub position: Position,
    /// The coordinates towards which the mechanism was moving; only the given ones matter.
    pub target: Vec<f64>,
}

/// The largest number of corrections of a position that was extrapolated from its neighbour: if more are needed, the
/// neighbour is too far away.
const ITERATIONS: usize = 8;
/// The largest residual of a closed position, relative to the terms of the residual.
const CLOSED: f64 = 1e-11;
/// The longest step of an angle, so that the other angles are not confused with those a turn later.
const LONGEST: f64 = 0.2;
/// The largest ratio of determinants in a step, so that no other branch is reached unnoticed.
const SMOOTH: f64 = 4.0;
/// The largest deviation of angles from the linear extrapolation, relative to the change of the fastest angle.
pub(crate) const CONTINUATION: f64 = 0.1;
/// The largest effect of rounding errors on an angle near a singular position.
const ROUNDING: f64 = 1e-12;
/// The smallest fraction of the path that is tried as a step.
const SHORTEST: f64 = 1e-10;
/// The distance beyond a limit position at which constraints are examined, in rad, or relative to the size of the
/// mechanism.
const BEYOND: f64 = 1e-2;
/// The smallest step of an angle: where branches cross, rounding errors join them at about this distance.
const SHORTEST_ANGLE: f64 = 1e-7;

impl<'m> LoopSolver<'m> {
    /// Creates the solver; `None` if the number of other coordinates differs from that of independent constraints.
    pub fn new(mechanism: &'m dyn Mechanism, given: Vec<bool>) -> Option<Self> {
        let dependent: Vec<usize> = (0..given.len()).filter(|&i| !given[i]).collect();
        let count = mechanism.description().constraints.len();
        let independent = match dependent.len().cmp(&count) {
            Ordering::Greater => return None,
            Ordering::Equal => (0..count).collect(),
            Ordering::Less => independent(mechanism, &dependent)?,
        };
        let partition = CoordinatePartition { given, dependent, independent };
        Some(Self { mechanism, t: 0.0, partition: Cow::Owned(partition) })
    }

    /// The partition of the coordinates, for mechanisms with other parameters.
    pub(crate) fn into_partition(self) -> CoordinatePartition {
        self.partition.into_owned()
    }

    /// Creates the solver with other parameters: its determinants can be compared with those of the first.
    pub(crate) fn with_partition(mechanism: &'m dyn Mechanism, partition: &'m CoordinatePartition) -> Self {
        Self { mechanism, t: 0.0, partition: Cow::Borrowed(partition) }
    }

    /// Finds the position near a guess, by Newton's method down to rounding errors.
    pub fn solve_loops(&self, mut q: Vec<f64>) -> Option<Position> {
        let CoordinatePartition { dependent, independent, .. } = &*self.partition;
        let mut before = f64::INFINITY;
        let mut constraints = LoopConstraints::zero(q.len(), self.mechanism.description().constraints.len());
        let count = dependent.len();
        let (mut block, mut residuals, mut step) = (Lu::with_size(count), vec![0.0; count], vec![0.0; count]);
        for _ in 0..=ITERATIONS {
            constraints.evaluate(self.mechanism, self.t, &q);
            let residual = largest(&constraints.residuals).1;
            block.factor_of(|r, c| constraints.constraint_jacobian[independent[r]][dependent[c]]);
            if residual == 0.0 || residual > 0.5 * before {
                // An angle counts as at least one, even if it is small at the moment.
                let size = |i: usize| q[i].abs() + f64::from(u8::from(self.is_angle(i)));
                let size = |row: &[f64]| row.iter().enumerate().map(|(i, entry)| entry.abs() * size(i)).sum::<f64>();
                let size = constraints.constraint_jacobian.iter().map(size).fold(0.0, f64::max);
                let is_closed = residual <= CLOSED * size;
                return is_closed.then_some(Position { q, determinant: block.determinant, constraints, block });
            }
            residuals.iter_mut().zip(independent).for_each(|(own, &k)| *own = constraints.residuals[k]);
            block.solve_into(&residuals, &mut step);
            if !step.iter().all(|value| value.is_finite()) {
                return None;
            }
            for (place, value) in dependent.iter().zip(&step) {
                q[*place] -= value;
            }
            before = residual;
        }
        None
    }

    /// The first-order change of all coordinates for a change of the given ones.
    pub fn linear_change(&self, at: &Position, given: impl Fn(usize) -> f64) -> Vec<f64> {
        self.solve(at, given, |_| 0.0)
    }

    /// The rates of all coordinates for those of the given ones.
    pub fn rates(&self, at: &Position, given: impl Fn(usize) -> f64) -> Vec<f64> {
        self.solve(at, given, |k| at.constraints.constraint_rate[k])
    }

    /// The accelerations of all coordinates for those of the given ones and the bias of the constraints.
    pub fn accelerations(&self, at: &Position, given: impl Fn(usize) -> f64, bias: &[f64]) -> Vec<f64> {
        self.solve(at, given, |k| bias[k])
    }

    /// Solves `C_q x + bias = 0` for the dependent part of `x`.
    fn solve(&self, at: &Position, given: impl Fn(usize) -> f64, bias: impl Fn(usize) -> f64) -> Vec<f64> {
        let CoordinatePartition { given: is_given, dependent, independent } = &*self.partition;
        let mut change: Vec<f64> = (0..is_given.len()).map(|i| if is_given[i] { given(i) } else { 0.0 }).collect();
        let row = |&k: &usize| dot(&at.constraints.constraint_jacobian[k], &change) + bias(k);
        let right: Vec<f64> = independent.iter().map(row).collect();
        dependent.iter().zip(at.block.solve(&right)).for_each(|(&i, value)| change[i] = -value);
        change
    }

    /// The derivatives of all coordinates with respect to one given coordinate, with the other given ones fixed.
    pub fn tangent(&self, at: &Position, by: usize) -> Vec<f64> {
        self.linear_change(at, |i| if i == by { 1.0 } else { 0.0 })
    }

    /// Moves continuously to the position with other values of the given coordinates.
    ///
    /// # Errors
    /// The mechanism reaches a limit position first.
    pub fn move_to(&self, from: &Position, to: &[f64]) -> Result<Position, LimitPosition> {
        let n = to.len();
        let mut now = from.clone();
        let (mut done, mut step) = (0.0, 1.0_f64);
        while done < 1.0 {
            let slope = self.linear_change(&now, |i| to[i] - from.q[i]);
            let angles = || (0..n).filter(|&i| self.is_angle(i));
            let fastest = angles().map(|i| slope[i].abs()).fold(0.0, f64::max);
            step = step.min(LONGEST / fastest).max(SHORTEST);
            let next = (done + step).min(1.0);
            let mut guess: Vec<f64> = (0..n).map(|i| now.q[i] + slope[i] * (next - done)).collect();
            // Set exactly, without rounding errors.
            for i in (0..n).filter(|&i| self.partition.given[i]) {
                guess[i] = if next == 1.0 { to[i] } else { from.q[i] + (to[i] - from.q[i]) * next };
            }
            let missed = |position: &Position| {
                let missed = angles().map(|i| (position.q[i] - guess[i]).abs()).fold(0.0, f64::max);
                (missed - ROUNDING).max(0.0) / (fastest * (next - done)).max(f64::MIN_POSITIVE)
            };
            let is_neighbour = |position: &Position| position.is_on_branch_of(&now) && missed(position) <= CONTINUATION;
            match self.solve_loops(guess.clone()).filter(is_neighbour) {
                Some(position) => {
                    let missed = missed(&position);
                    (now, done) = (position, next);
                    // The deviation from the linear extrapolation is of second order.
                    if missed < 0.4 * CONTINUATION {
                        step *= 2.0;
                    }
                }
                None if step <= SHORTEST || step * fastest <= SHORTEST_ANGLE => {
                    return Err(LimitPosition { position: now, target: to.to_vec() });
                }
                None => step *= 0.5,
            }
        }
        Ok(now)
    }

    /// The constraint that cannot be closed slightly beyond a limit position; `None` if another branch begins there.
    pub fn open_beyond(&self, limit: &LimitPosition) -> Option<usize> {
        let LimitPosition { position, target: to } = limit;
        let n = to.len();
        let moves = |i: usize| self.partition.given[i] && to[i] != position.q[i];
        let size = |i: usize| if self.is_angle(i) { 1.0 } else { self.size(position) };
        let step = |i: usize| if moves(i) { BEYOND * size(i) * (to[i] - position.q[i]).signum() } else { 0.0 };
        let beyond = |i: usize| position.q[i] + step(i);
        let start = Start {
            q: (0..n).map(beyond).collect(),
            given: self.partition.given.clone(),
            qd: vec![0.0; n],
            given_rates: vec![false; n],
        };
        assemble_from_guesses(self.mechanism, &start).err().map(|reason| reason.constraint)
    }

    /// The largest length in a position: of the coordinates, and of the lever arms by which angles act on the
    /// constraints.
    pub(crate) fn size(&self, at: &Position) -> f64 {
        let (angles, lengths): (Vec<usize>, Vec<usize>) = (0..at.q.len()).partition(|&i| self.is_angle(i));
        let rows = at.constraints.constraint_jacobian.iter();
        let arms = rows.flat_map(|row| angles.iter().map(|&i| row[i].abs()));
        let size = lengths.iter().map(|&i| at.q[i].abs()).chain(arms).fold(0.0, f64::max);
        if size > 0.0 { size } else { 1.0 }
    }

    /// Whether a coordinate is given.
    pub(crate) fn is_given(&self, coordinate: usize) -> bool {
        self.partition.given[coordinate]
    }

    pub(crate) fn is_angle(&self, coordinate: usize) -> bool {
        self.mechanism.description().is_angle(coordinate)
    }

    /// The multipliers, and the generalized forces on the given coordinates, that hold a position in static
    /// equilibrium.
    pub fn balance(&self, q: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let rest = vec![0.0; q.len()];
        self.inverse_dynamics(&Dynamics::at(self.mechanism, self.t, q, &rest), &rest)
    }

    /// Inverse dynamics: the multipliers, and the generalized forces on the given coordinates that accelerations need
    /// in addition to the loads, so that `Mbar qdd + C_q' lambda = fbar + force`. If constraints are redundant, the
    /// multipliers have the least norm.
    pub fn inverse_dynamics(&self, dynamics: &Dynamics, qdd: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let n = qdd.len();
        let jacobian = &dynamics.constraint_jacobian;
        let rest = |(row, force): (&[f64], &f64)| force - dot(row, qdd);
        let forces: Vec<f64> = dynamics.mass_matrix.iter().zip(&dynamics.generalized_forces).map(rest).collect();
        let right: Vec<f64> = self.partition.dependent.iter().map(|&i| forces[i]).collect();
        let (m, rank) = (jacobian.rows(), self.partition.dependent.len());
        let multipliers = if rank == m {
            Lu::new(Matrix::from_fn(m, m, |r, c| jacobian[c][self.partition.dependent[r]])).solve(&right)
        } else {
            let block = Matrix::from_fn(m, rank, |r, c| jacobian[r][self.partition.dependent[c]]);
            let mut multipliers: Vec<f64> = block.iter().map(|row| dot(row, &right)).collect();
            PivotedLdl::with_rank(&row_products(&block), rank).solve(&mut multipliers);
            multipliers
        };
        let held = |i: usize| (0..m).map(|r| jacobian[r][i] * multipliers[r]).sum::<f64>() - forces[i];
        let forces = (0..n).map(|i| if self.partition.given[i] { held(i) } else { 0.0 }).collect();
        (multipliers, forces)
    }

    /// The outputs at rest with these multipliers.
    pub fn outputs(&self, q: &[f64], multipliers: &[f64]) -> Vec<f64> {
        let mut outputs = vec![0.0; self.mechanism.description().outputs.len()];
        let zero = vec![0.0; q.len()];
        self.mechanism.outputs(0.0, q, &zero, &zero, multipliers, &mut outputs);
        outputs
    }
}

/// The constraints that determine these coordinates at the start; `None` if the numbers differ.
fn independent(mechanism: &dyn Mechanism, dependent: &[usize]) -> Option<Vec<usize>> {
    let (q, _) = assemble_from_guesses(mechanism, &Start::new(mechanism)).ok()?;
    if constraint_rank(mechanism, 0.0, &q) != dependent.len() {
        return None;
    }
    let jacobian = LoopConstraints::at(mechanism, 0.0, &q).constraint_jacobian;
    let block = Matrix::from_fn(jacobian.rows(), dependent.len(), |r, c| jacobian[r][dependent[c]]);
    let factors = PivotedLdl::with_rank(&row_products(&block), dependent.len());
    let mut independent = factors.independent().to_vec();
    independent.sort_unstable();
    (independent.len() == dependent.len()).then_some(independent)
}
