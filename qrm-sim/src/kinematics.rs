//! Positions of a mechanism with its given coordinates held: one after another, until it locks.

use qrm_core::{Mechanism, Start};

use crate::assembly::assemble;
use crate::linear::lu::Lu;
use crate::linear::{Matrix, Vector, largest};

/// A mechanism whose given coordinates are moved from outside, the others following from the constraints.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'m, X, const N: usize, const M: usize> {
    /// The mechanism.
    pub mechanism: &'m X,
    given: [bool; N],
    /// The coordinates that follow; as many as there are constraints.
    free: [usize; M],
}

/// A closed position.
#[derive(Clone, Copy, Debug)]
pub struct Position<const N: usize> {
    /// The coordinates.
    pub q: Vector<N>,
    /// The determinant of `C_q` by the coordinates that follow. It is zero where the given ones cannot move the others, and
    /// other units change it by a constant factor.
    pub determinant: f64,
}

/// Where the given coordinates cannot be moved on.
#[derive(Clone, Copy, Debug)]
pub struct Lock<const N: usize> {
    /// The last position before.
    pub position: Position<N>,
    /// The constraint that cannot be closed beyond; `None` if another branch begins there.
    pub constraint: Option<usize>,
}

/// Most corrections of a position that was guessed from its neighbour: where it takes more, the neighbour is too far away.
const ITERATIONS: usize = 8;
/// A position is closed where its residuals are this small against the terms that they are the differences of.
const CLOSED: f64 = 1e-11;
/// Longest step of an angle: the others must not be taken for what they are a turn later.
const LONGEST: f64 = 0.2;
/// By how much the determinant may change in a step, so that no other branch is reached unnoticed.
const SMOOTH: f64 = 4.0;
/// Steps shorter than this fraction of the way are not tried.
const SHORTEST: f64 = 1e-14;

impl<'m, X: Mechanism<N, M>, const N: usize, const M: usize> Drive<'m, X, N, M> {
    /// `None` if what is given does not leave as many coordinates as there are constraints.
    pub fn new(mechanism: &'m X, given: [bool; N]) -> Option<Self> {
        let mut free = [0; M];
        let mut places = (0..N).filter(|&i| !given[i]);
        for place in &mut free {
            *place = places.next()?;
        }
        places.next().is_none().then_some(Self { mechanism, given, free })
    }

    /// The position near a guess, by Newton's method until rounding errors alone are left.
    pub fn close(&self, mut q: Vector<N>) -> Option<Position<N>> {
        let mut before = f64::INFINITY;
        for _ in 0..=ITERATIONS {
            let closure = self.mechanism.closure(0.0, &q);
            let residual = largest(&closure.constraints).1;
            let lu = Lu::new(&self.block(&closure.constraint_jacobian));
            if residual == 0.0 || residual > 0.5 * before {
                // A whole angle counts, however small it is at the moment.
                let size = |i: usize| q[i].abs() + f64::from(u8::from(is_angle::<X, N, M>(i)));
                let size = |row: &Vector<N>| (0..N).map(|i| row[i].abs() * size(i)).sum::<f64>();
                let size = closure.constraint_jacobian.iter().map(size).fold(0.0, f64::max);
                return (residual <= CLOSED * size).then_some(Position { q, determinant: lu.determinant });
            }
            let step = lu.solve(&closure.constraints);
            if !step.iter().all(|value| value.is_finite()) {
                return None;
            }
            for (place, value) in self.free.iter().zip(step) {
                q[*place] -= value;
            }
            before = residual;
        }
        None
    }

    /// The coordinates' derivatives by one that is given, the other given ones held.
    pub fn tangent(&self, q: &Vector<N>, by: usize) -> Vector<N> {
        let jacobian = self.mechanism.closure(0.0, q).constraint_jacobian;
        let follow = Lu::new(&self.block(&jacobian)).solve(&std::array::from_fn(|r| jacobian[r][by]));
        let mut tangent = [0.0; N];
        tangent[by] = 1.0;
        for (place, value) in self.free.iter().zip(follow) {
            tangent[*place] = -value;
        }
        tangent
    }

    /// The position in which the given coordinates have other values, reached without a jump.
    ///
    /// # Errors
    /// The way there ends earlier.
    pub fn go(&self, from: &Position<N>, to: &Vector<N>) -> Result<Position<N>, Lock<N>> {
        let mut now = *from;
        let (mut done, mut step) = (0.0, 1.0_f64);
        while done < 1.0 {
            let mut slope = [0.0; N];
            for i in (0..N).filter(|&i| self.given[i]) {
                let tangent = self.tangent(&now.q, i);
                (0..N).for_each(|j| slope[j] += tangent[j] * (to[i] - from.q[i]));
            }
            let angles = || (0..N).filter(|&i| is_angle::<X, N, M>(i));
            let fastest = angles().map(|i| slope[i].abs()).fold(0.0, f64::max);
            step = step.min(LONGEST / fastest).max(SHORTEST);
            let next = (done + step).min(1.0);
            let mut guess: Vector<N> = std::array::from_fn(|i| now.q[i] + slope[i] * (next - done));
            // The given coordinates go where they are wanted, to the last digit.
            for i in (0..N).filter(|&i| self.given[i]) {
                guess[i] = if next == 1.0 { to[i] } else { from.q[i] + (to[i] - from.q[i]) * next };
            }
            let is_neighbour = |position: &Position<N>| {
                let change = position.determinant / now.determinant;
                let missed = angles().map(|i| (position.q[i] - guess[i]).abs()).fold(0.0, f64::max);
                change < SMOOTH && change > 1.0 / SMOOTH && missed <= 0.5 * LONGEST
            };
            match self.close(guess).filter(is_neighbour) {
                Some(position) => {
                    (now, done) = (position, next);
                    step *= 2.0;
                }
                None if step <= SHORTEST => {
                    return Err(Lock { position: now, constraint: self.open_beyond(&now, to) });
                }
                None => step *= 0.5,
            }
        }
        Ok(now)
    }

    /// The constraint that cannot be closed a little farther on the way.
    fn open_beyond(&self, position: &Position<N>, to: &Vector<N>) -> Option<usize> {
        let moves = |i: usize| self.given[i] && to[i] != position.q[i];
        let beyond = |i: usize| position.q[i] + if moves(i) { 1e-2 * (to[i] - position.q[i]).signum() } else { 0.0 };
        let (q, given) = (std::array::from_fn(beyond), self.given);
        let start = Start { q, given, qd: [0.0; N], given_rates: [false; N] };
        assemble(self.mechanism, &start).err().map(|reason| reason.constraint)
    }

    fn block(&self, jacobian: &Matrix<M, N>) -> Matrix<M, M> {
        std::array::from_fn(|r| std::array::from_fn(|c| jacobian[r][self.free[c]]))
    }

    /// Multipliers, and the generalized forces on the given coordinates, that hold a position at rest: with them
    /// `C_q' lambda = fbar + force`.
    pub fn balance(&self, q: &Vector<N>) -> (Vector<M>, Vector<N>) {
        let dynamics = self.mechanism.dynamics(0.0, q, &[0.0; N]);
        let (jacobian, forces) = (dynamics.constraint_jacobian, dynamics.generalized_forces);
        let block = self.block(&jacobian);
        let transposed: Matrix<M, M> = std::array::from_fn(|r| std::array::from_fn(|c| block[c][r]));
        let multipliers = Lu::new(&transposed).solve(&std::array::from_fn(|r| forces[self.free[r]]));
        let held = |i: usize| (0..M).map(|r| jacobian[r][i] * multipliers[r]).sum::<f64>() - forces[i];
        (multipliers, std::array::from_fn(|i| if self.given[i] { held(i) } else { 0.0 }))
    }

    /// The outputs at rest with these multipliers.
    pub fn outputs(&self, q: &Vector<N>, multipliers: &Vector<M>) -> Vec<f64> {
        let mut outputs = vec![0.0; X::DESCRIPTION.outputs.len()];
        self.mechanism.outputs(0.0, q, &[0.0; N], &[0.0; N], multipliers, &mut outputs);
        outputs
    }
}

/// Whether a coordinate is an angle.
pub(crate) fn is_angle<X: Mechanism<N, M>, const N: usize, const M: usize>(coordinate: usize) -> bool {
    X::DESCRIPTION.coordinates[coordinate].unit == "rad"
}
