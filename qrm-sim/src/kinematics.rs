//! Positions of a mechanism with its given coordinates held: one after another, until it locks.

use qrm_mechanism::{Mechanism, Start};

use crate::assembly::assemble;
use crate::linear::lu::Lu;
use crate::linear::{Matrix, Vector, dot, largest};

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
    /// How far it is from locking: the determinant of `C_q` by the coordinates that follow, each row of length one. It
    /// changes its sign where the mechanism can go over into another branch.
    pub margin: f64,
}

/// Where the given coordinates cannot be moved on.
#[derive(Clone, Copy, Debug)]
pub struct Lock<const N: usize> {
    /// The last position before.
    pub position: Position<N>,
    /// The constraint that cannot be closed beyond; `None` if another branch begins there.
    pub constraint: Option<usize>,
}

/// Largest residual of a closed position.
const CLOSED: f64 = 1e-13;
/// Most corrections of a position that was guessed from its neighbour.
const ITERATIONS: usize = 30;
/// Steps shorter than this fraction of the way are not tried.
const SHORTEST: f64 = 1e-13;

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

    /// The position near a guess.
    pub fn close(&self, mut q: Vector<N>) -> Option<Position<N>> {
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let closure = self.mechanism.closure(&q);
            let residual = largest(&closure.constraints).1;
            let lu = Lu::new(&self.block(&closure.constraint_jacobian));
            let step = lu.solve(&closure.constraints);
            // Rounding errors may keep a residual from the tolerance; then it no longer shrinks.
            if residual <= CLOSED || residual <= 1e-11 && residual > 0.5 * before {
                return Some(Position { q, margin: self.margin(&closure.constraint_jacobian, &lu) });
            }
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
        let jacobian = self.mechanism.closure(q).constraint_jacobian;
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
            let next = (done + step).min(1.0);
            let mut guess = now.q;
            let mut reach: f64 = 0.0;
            for i in (0..N).filter(|&i| self.given[i]) {
                let change = (to[i] - from.q[i]) * (next - done);
                reach = reach.max(change.abs());
                let tangent = self.tangent(&now.q, i);
                (0..N).for_each(|j| guess[j] += tangent[j] * change);
            }
            // The given coordinates go where they are wanted, to the last digit.
            for i in (0..N).filter(|&i| self.given[i]) {
                guess[i] = if next == 1.0 { to[i] } else { from.q[i] + (to[i] - from.q[i]) * next };
            }
            match self.close(guess).filter(|position| self.is_neighbour(&now, position, &guess)) {
                Some(position) => {
                    (now, done) = (position, next);
                    step *= 2.0;
                }
                None if step < SHORTEST => return Err(Lock { position: now, constraint: self.open_beyond(&now, to) }),
                None => step *= 0.5,
            }
        }
        Ok(now)
    }

    /// Whether a position belongs to the same branch: it is near its guess, and no singular one lies between.
    fn is_neighbour(&self, before: &Position<N>, position: &Position<N>, guess: &Vector<N>) -> bool {
        let moved = (0..N).map(|i| (position.q[i] - before.q[i]).abs()).fold(0.0, f64::max);
        let missed = (0..N).map(|i| (position.q[i] - guess[i]).abs()).fold(0.0, f64::max);
        before.margin * position.margin > 0.0 && missed <= 0.2 * moved
    }

    /// The constraint that cannot be closed a little farther on the way.
    fn open_beyond(&self, position: &Position<N>, to: &Vector<N>) -> Option<usize> {
        let beyond =
            |i: usize| position.q[i] + if self.given[i] { 1e-2 * (to[i] - position.q[i]).signum() } else { 0.0 };
        let (q, given) = (std::array::from_fn(beyond), self.given);
        let start = Start { q, given, qd: [0.0; N], given_rates: [false; N] };
        assemble(self.mechanism, &start).err().map(|reason| reason.constraint)
    }

    fn block(&self, jacobian: &Matrix<M, N>) -> Matrix<M, M> {
        std::array::from_fn(|r| std::array::from_fn(|c| jacobian[r][self.free[c]]))
    }

    fn margin(&self, jacobian: &Matrix<M, N>, lu: &Lu<M>) -> f64 {
        let length = |row: &Vector<N>| dot(row, row).sqrt();
        jacobian.iter().map(length).fold(lu.determinant, |margin, length| margin / length)
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
}
