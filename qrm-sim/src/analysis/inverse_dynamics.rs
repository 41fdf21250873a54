//! The forces and torques needed for a prescribed motion.

use qrm_core::Mechanism;

use crate::position::{CONTINUATION, LoopSolver, NotAssembled, Position, Start, assemble_from_guesses};
use crate::solve::Dynamics;

/// A mechanism at one time of a prescribed motion.
#[derive(Clone, Debug)]
pub struct PrescribedState {
    /// The time.
    pub t: f64,
    /// The coordinates.
    pub q: Vec<f64>,
    /// The rates of the coordinates.
    pub qd: Vec<f64>,
    /// The accelerations of the coordinates.
    pub qdd: Vec<f64>,
    /// The multipliers.
    pub multipliers: Vec<f64>,
    /// The forces and torques needed in addition to the loads, along the given coordinates; zero along the others.
    pub forces: Vec<f64>,
    /// The outputs.
    pub outputs: Vec<f64>,
}

/// The reason why a motion is not possible.
#[derive(Clone, Debug)]
pub enum NotPossible {
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
    /// The given coordinates do not determine the others at the start.
    Singular,
    /// Friction depends on joint forces, which forces along the given coordinates would change.
    Friction,
    /// After this time the mechanism locks, or reaches a position at which the given coordinates do not determine the
    /// others.
    LimitPosition {
        /// The last time that was reached.
        t: f64,
        /// The coordinates there.
        q: Vec<f64>,
    },
    /// After this time the given coordinates come so near a dead point that they do not determine the forces.
    DeadPoint {
        /// The last time that was reached.
        t: f64,
        /// The coordinates there.
        q: Vec<f64>,
    },
    /// The prescribed motion, or a force that it needs, is not finite at this time.
    NotFinite {
        /// The time.
        t: f64,
    },
    /// After this time the motion changes too much before the next time.
    TooFast {
        /// The time.
        t: f64,
    },
    /// A prescribed coordinate jumps after this time.
    Discontinuous {
        /// The coordinate.
        coordinate: usize,
        /// The time.
        t: f64,
    },
}

/// A mechanism whose given coordinates are prescribed functions of time, while the others follow.
#[derive(Clone)]
pub struct PrescribedMotion<'m> {
    drive: LoopSolver<'m>,
    position: Position,
    last: PrescribedState,
    /// The last state at a distance from singular positions, and the largest determinant so far.
    regular: (Position, PrescribedState),
    largest_determinant: f64,
}

/// Value, rate and acceleration of a given coordinate.
pub type Prescribed<'f> = &'f dyn Fn(usize, f64) -> [f64; 3];

/// The largest number of steps between two requested times.
const MAX_STEPS: u32 = 100_000;
/// The smallest fraction of the path between two times that is tried as a step.
const SHORTEST: f64 = 1e-9;

impl<'m> PrescribedMotion<'m> {
    /// Creates the motion at its first time, on the branch of the start; the given coordinates have their prescribed
    /// values.
    ///
    /// # Errors
    /// The mechanism cannot be assembled or moved, or its friction depends on undetermined forces.
    pub fn new(
        mechanism: &'m dyn Mechanism,
        start: &Start,
        t: f64,
        prescribed: Prescribed,
    ) -> Result<Self, NotPossible> {
        if !mechanism.description().friction.is_empty() && start.given.contains(&true) {
            return Err(NotPossible::Friction);
        }
        let mut drive = LoopSolver::new(mechanism, start.given.clone()).ok_or(NotPossible::Singular)?;
        let mut start = start.clone();
        for i in (0..start.q.len()).filter(|&i| start.given[i]) {
            let motion = prescribed(i, t);
            if !motion.iter().all(|value| value.is_finite()) {
                return Err(NotPossible::NotFinite { t });
            }
            start.q[i] = motion[0];
        }
        let (q, _) = assemble_from_guesses(mechanism, &start).map_err(NotPossible::NotAssembled)?;
        drive.t = t;
        let position = drive.solve_loops(q).ok_or(NotPossible::Singular)?;
        let last = state(&drive, &position, prescribed).ok_or(NotPossible::NotFinite { t })?;
        let regular = (position.clone(), last.clone());
        let largest_determinant = position.determinant.abs();
        Ok(Self { drive, position, last, regular, largest_determinant })
    }

    /// The state at the last time.
    pub fn state(&self) -> &PrescribedState {
        &self.last
    }

    /// The coordinates that are angles.
    pub(super) fn angles(&self) -> impl Iterator<Item = usize> {
        (0..self.last.q.len()).filter(|&i| self.drive.is_angle(i))
    }

    /// Moves to a later time.
    ///
    /// # Errors
    /// The mechanism locks before that time.
    pub fn advance(&mut self, t: f64, prescribed: Prescribed) -> Result<&PrescribedState, NotPossible> {
        let from = self.last.t;
        let mut step = t - from;
        let mut count = 0;
        while self.last.t < t {
            count += 1;
            if count > MAX_STEPS {
                return Err(NotPossible::TooFast { t: from });
            }
            let next = if self.last.t + step >= t { t } else { self.last.t + step };
            match self.neighbour(next, prescribed) {
                Some(position) => {
                    self.take(next, position, prescribed)?;
                    step *= 2.0;
                }
                None if step <= SHORTEST * (t - from) => {
                    if let Some((next, position)) = self.across(t, prescribed) {
                        self.take(next, position, prescribed)?;
                        step = t - next;
                        continue;
                    }
                    let jumps = |i: &usize| {
                        self.drive.is_given(*i) && Self::jumps(&self.last, *i, prescribed(*i, next)[0], next)
                    };
                    if let Some(coordinate) = (0..self.last.q.len()).find(jumps) {
                        return Err(NotPossible::Discontinuous { coordinate, t: self.last.t });
                    }
                    return Err(NotPossible::LimitPosition { t: self.last.t, q: self.last.q.clone() });
                }
                None => step *= 0.5,
            }
        }
        // At the same time the prescribed motion may continue with another acceleration.
        if t == from {
            self.last = state(&self.drive, &self.position, prescribed).ok_or(NotPossible::NotFinite { t })?;
        }
        Ok(&self.last)
    }

    /// Takes the position at a later time.
    fn take(&mut self, t: f64, position: Position, prescribed: Prescribed) -> Result<(), NotPossible> {
        self.drive.t = t;
        self.position = position;
        self.last = state(&self.drive, &self.position, prescribed).ok_or(NotPossible::NotFinite { t })?;
        let determinant = self.position.determinant.abs();
        self.largest_determinant = self.largest_determinant.max(determinant);
        if determinant > REGULAR * self.largest_determinant {
            self.regular = (self.position.clone(), self.last.clone());
        }
        Ok(())
    }

    /// A time behind the singular position ahead, at most `t`, and the position there; `None` if the motion from before
    /// it does not go on smoothly.
    ///
    /// Where branches cross, the given coordinates do not tell which one goes on, but the smooth motion does.
    fn across(&self, t: f64, prescribed: Prescribed) -> Option<(f64, Position)> {
        let (from, last) = &self.regular;
        let next = (2.0 * self.last.t - last.t).min(t);
        let position = Self::near(&self.drive, last, next, prescribed)?;
        let is_crossed = next > self.last.t && position.determinant * from.determinant < 0.0;
        is_crossed.then_some((next, position))
    }

    /// The reason why forces between the last time and the next ones cannot be resolved.
    pub(super) fn unresolved(&self, t: f64) -> NotPossible {
        if self.position.determinant.abs() < REGULAR * self.largest_determinant {
            return NotPossible::DeadPoint { t: self.last.t, q: self.last.q.clone() };
        }
        NotPossible::TooFast { t }
    }

    /// Whether a later value of a coordinate is far from the extrapolation by its rate and acceleration.
    fn jumps(last: &PrescribedState, i: usize, value: f64, t: f64) -> bool {
        let PrescribedState { q, qd, qdd, .. } = last;
        let h = t - last.t;
        let moved = h * (qd[i] + 0.5 * h * qdd[i]);
        // Written so that a value that is not finite counts as a jump.
        !((value - q[i] - moved).abs() <= CONTINUATION * moved.abs() + ROUNDING * (1.0 + q[i].abs()))
    }

    /// The position a little later on the same branch, if it is near the extrapolated one.
    fn neighbour(&self, t: f64, prescribed: Prescribed) -> Option<Position> {
        let position = Self::near(&self.drive, &self.last, t, prescribed)?;
        position.is_on_branch_of(&self.position).then_some(position)
    }

    /// The position a little after a state, if it is near the extrapolated one.
    fn near(drive: &LoopSolver, last: &PrescribedState, t: f64, prescribed: Prescribed) -> Option<Position> {
        let PrescribedState { q, qd, qdd, .. } = last;
        let h = t - last.t;
        let mut drive = drive.clone();
        drive.t = t;
        let guess = |i: usize| {
            if drive.is_given(i) { prescribed(i, t)[0] } else { q[i] + h * (qd[i] + 0.5 * h * qdd[i]) }
        };
        if (0..q.len()).any(|i| drive.is_given(i) && Self::jumps(last, i, guess(i), t)) {
            return None;
        }
        let guess: Vec<f64> = (0..q.len()).map(guess).collect();
        let position = drive.solve_loops(guess.clone())?;
        let angles = || (0..q.len()).filter(|&i| drive.is_angle(i));
        let moved = angles().map(|i| (guess[i] - q[i]).abs()).fold(0.0, f64::max);
        let missed = angles().map(|i| (position.q[i] - guess[i]).abs()).fold(0.0, f64::max);
        (moved <= LONGEST && missed <= CONTINUATION * moved + ROUNDING).then_some(position)
    }
}

/// The smallest determinant at a distance from singular positions, relative to the largest one.
const REGULAR: f64 = 0.02;
/// The longest step of an angle, so that the other angles are not confused with those a turn later.
const LONGEST: f64 = 0.5;
/// The largest effect of rounding errors on an angle.
const ROUNDING: f64 = 1e-9;

/// Rates, accelerations and forces at a position; `None` if they are not finite.
fn state(drive: &LoopSolver, position: &Position, prescribed: Prescribed) -> Option<PrescribedState> {
    let (t, q) = (drive.t, position.q.clone());
    let qd = drive.rates(position, |i| prescribed(i, t)[1]);
    let dynamics = Dynamics::at(drive.mechanism, t, &q, &qd);
    let qdd = drive.accelerations(position, |i| prescribed(i, t)[2], &dynamics.constraint_bias);
    let (multipliers, forces) = drive.inverse_dynamics(&dynamics, &qdd);
    let mut outputs = vec![0.0; drive.mechanism.description().outputs.len()];
    drive.mechanism.outputs(t, &q, &qd, &qdd, &multipliers, &mut outputs);
    let all = [&qd, &qdd, &multipliers, &forces, &outputs];
    let is_finite = all.into_iter().flatten().all(|value| value.is_finite());
    is_finite.then_some(PrescribedState { t, q, qd, qdd, multipliers, forces, outputs })
}
