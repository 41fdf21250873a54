//! Positions of a mechanism with its given coordinates held: one after another, until it locks.

use qrm_core::Mechanism;

use crate::run::assemble;
use crate::solve::{Dynamics, LoopConstraints, Lu, Matrix, largest};
use crate::start::Start;

/// A mechanism whose given coordinates are moved from outside, the others following from the constraints.
#[derive(Clone)]
pub struct Drive<'m> {
    /// The mechanism.
    pub mechanism: &'m dyn Mechanism,
    given: Vec<bool>,
    /// The coordinates that follow; as many as there are constraints.
    dependent: Vec<usize>,
}

/// A closed position.
#[derive(Clone, Debug)]
pub struct Position {
    /// The coordinates.
    pub q: Vec<f64>,
    /// The determinant of `C_q` by the coordinates that follow. It is zero where the given ones cannot move the others,
    /// and other units change it by a constant factor.
    pub determinant: f64,
}

/// A limit position: the given coordinates cannot be moved beyond it.
#[derive(Clone, Debug)]
pub struct LimitPosition {
    /// The last position before.
    pub position: Position,
    /// The constraint that cannot be closed beyond; `None` if another branch begins there.
    pub constraint: Option<usize>,
}

/// Most corrections of a position that was guessed from its neighbour: where it takes more, the neighbour is too far
/// away.
const ITERATIONS: usize = 8;
/// A position is closed where its residuals are this small against the terms that they are the differences of.
const CLOSED: f64 = 1e-11;
/// Longest step of an angle: the others must not be taken for what they are a turn later.
const LONGEST: f64 = 0.2;
/// By how much the determinant may change in a step, so that no other branch is reached unnoticed.
const SMOOTH: f64 = 4.0;
/// Steps shorter than this fraction of the way are not tried.
const SHORTEST: f64 = 1e-14;

impl<'m> Drive<'m> {
    /// `None` if the given coordinates do not leave as many as there are constraints.
    pub fn new(mechanism: &'m dyn Mechanism, given: Vec<bool>) -> Option<Self> {
        let dependent: Vec<usize> = (0..given.len()).filter(|&i| !given[i]).collect();
        let count = mechanism.description().constraints.len();
        (dependent.len() == count).then_some(Self { mechanism, given, dependent })
    }

    /// The position near a guess, by Newton's method until rounding errors alone are left.
    pub fn close(&self, mut q: Vec<f64>) -> Option<Position> {
        let mut before = f64::INFINITY;
        let mut constraints = LoopConstraints::zero(q.len(), self.dependent.len());
        for _ in 0..=ITERATIONS {
            constraints.evaluate(self.mechanism, 0.0, &q);
            let residual = largest(&constraints.residuals).1;
            let lu = Lu::new(self.block(&constraints.constraint_jacobian));
            if residual == 0.0 || residual > 0.5 * before {
                // A whole angle counts, however small it is at the moment.
                let size = |i: usize| q[i].abs() + f64::from(u8::from(self.is_angle(i)));
                let size = |row: &[f64]| row.iter().enumerate().map(|(i, entry)| entry.abs() * size(i)).sum::<f64>();
                let size = constraints.constraint_jacobian.iter().map(size).fold(0.0, f64::max);
                return (residual <= CLOSED * size).then_some(Position { q, determinant: lu.determinant });
            }
            let step = lu.solve(&constraints.residuals);
            if !step.iter().all(|value| value.is_finite()) {
                return None;
            }
            for (place, value) in self.dependent.iter().zip(step) {
                q[*place] -= value;
            }
            before = residual;
        }
        None
    }

    /// The coordinates' derivatives by one that is given, the other given ones held.
    pub fn tangent(&self, q: &[f64], by: usize) -> Vec<f64> {
        let jacobian = LoopConstraints::of(self.mechanism, 0.0, q).constraint_jacobian;
        let column: Vec<f64> = jacobian.iter().map(|row| row[by]).collect();
        let follow = Lu::new(self.block(&jacobian)).solve(&column);
        let mut tangent = vec![0.0; q.len()];
        tangent[by] = 1.0;
        for (place, value) in self.dependent.iter().zip(follow) {
            tangent[*place] = -value;
        }
        tangent
    }

    /// The position in which the given coordinates have other values, reached without a jump.
    ///
    /// # Errors
    /// The mechanism reaches a limit position before.
    pub fn move_to(&self, from: &Position, to: &[f64]) -> Result<Position, LimitPosition> {
        let n = to.len();
        let mut now = from.clone();
        let (mut done, mut step) = (0.0, 1.0_f64);
        while done < 1.0 {
            let mut slope = vec![0.0; n];
            for i in (0..n).filter(|&i| self.given[i]) {
                let tangent = self.tangent(&now.q, i);
                (0..n).for_each(|j| slope[j] += tangent[j] * (to[i] - from.q[i]));
            }
            let angles = || (0..n).filter(|&i| self.is_angle(i));
            let fastest = angles().map(|i| slope[i].abs()).fold(0.0, f64::max);
            step = step.min(LONGEST / fastest).max(SHORTEST);
            let next = (done + step).min(1.0);
            let mut guess: Vec<f64> = (0..n).map(|i| now.q[i] + slope[i] * (next - done)).collect();
            // The given coordinates take their values to the last digit.
            for i in (0..n).filter(|&i| self.given[i]) {
                guess[i] = if next == 1.0 { to[i] } else { from.q[i] + (to[i] - from.q[i]) * next };
            }
            let is_neighbour = |position: &Position| {
                let change = position.determinant / now.determinant;
                let missed = angles().map(|i| (position.q[i] - guess[i]).abs()).fold(0.0, f64::max);
                change < SMOOTH && change > 1.0 / SMOOTH && missed <= 0.5 * LONGEST
            };
            match self.close(guess.clone()).filter(is_neighbour) {
                Some(position) => {
                    (now, done) = (position, next);
                    step *= 2.0;
                }
                None if step <= SHORTEST => {
                    let constraint = self.open_beyond(&now, to);
                    return Err(LimitPosition { position: now, constraint });
                }
                None => step *= 0.5,
            }
        }
        Ok(now)
    }

    /// The constraint that cannot be met a little farther on the way.
    fn open_beyond(&self, position: &Position, to: &[f64]) -> Option<usize> {
        let n = to.len();
        let moves = |i: usize| self.given[i] && to[i] != position.q[i];
        let beyond = |i: usize| position.q[i] + if moves(i) { 1e-2 * (to[i] - position.q[i]).signum() } else { 0.0 };
        let start = Start {
            q: (0..n).map(beyond).collect(),
            given: self.given.clone(),
            qd: vec![0.0; n],
            given_rates: vec![false; n],
        };
        assemble(self.mechanism, &start).err().map(|reason| reason.constraint)
    }

    fn block(&self, jacobian: &Matrix) -> Matrix {
        let m = self.dependent.len();
        Matrix::from_fn(m, m, |r, c| jacobian[r][self.dependent[c]])
    }

    fn is_angle(&self, coordinate: usize) -> bool {
        self.mechanism.description().is_angle(coordinate)
    }

    /// Multipliers, and the generalized forces on the given coordinates, that hold a position in static equilibrium:
    /// with them `C_q' lambda = fbar + force`.
    pub fn balance(&self, q: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (n, m) = (q.len(), self.dependent.len());
        let dynamics = Dynamics::of(self.mechanism, 0.0, q, &vec![0.0; n]);
        let (jacobian, forces) = (&dynamics.constraint_jacobian, &dynamics.generalized_forces);
        let transposed = Matrix::from_fn(m, m, |r, c| jacobian[c][self.dependent[r]]);
        let right: Vec<f64> = self.dependent.iter().map(|&i| forces[i]).collect();
        let multipliers = Lu::new(transposed).solve(&right);
        let held = |i: usize| (0..m).map(|r| jacobian[r][i] * multipliers[r]).sum::<f64>() - forces[i];
        let forces = (0..n).map(|i| if self.given[i] { held(i) } else { 0.0 }).collect();
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
