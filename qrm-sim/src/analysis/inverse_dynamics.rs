//! The forces and torques needed for a prescribed motion.

use qrm_core::Mechanism;

use super::singular_interval::{Placed, SingularInterval};
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
    /// The estimated error of the numbers, relative to the largest of their kind, where they are interpolated across a
    /// singular position.
    pub error: f64,
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
    /// After this time the motion changes too much before the next row.
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
    largest_determinant: f64,
    ahead: Ahead,
}

/// The singular position ahead of a motion, and whether the motion passes it.
#[derive(Clone, Debug)]
enum Ahead {
    /// No singular position is near.
    Regular,
    /// The given coordinates come to a singular position beyond which they cannot go, or turn before it.
    Limit,
    /// The motion goes on beyond a singular position, but its forces there are not smooth.
    DeadPoint,
    /// The motion goes on smoothly beyond a singular position.
    Smooth(Box<SingularInterval>),
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
        let largest_determinant = position.determinant.abs();
        Ok(Self { drive, position, last, largest_determinant, ahead: Ahead::Regular })
    }

    /// The state at the last time.
    pub fn state(&self) -> &PrescribedState {
        &self.last
    }

    /// The coordinates that are angles.
    pub(super) fn angles(&self) -> impl Iterator<Item = usize> {
        (0..self.last.q.len()).filter(|&i| self.drive.is_angle(i))
    }

    /// Moves to a later time. At the time of the last state, the prescribed motion may go on with another acceleration.
    ///
    /// # Errors
    /// The mechanism locks before that time.
    pub fn advance(&mut self, t: f64, prescribed: Prescribed) -> Result<&PrescribedState, NotPossible> {
        let from = self.last.t;
        if t == from {
            return self.go_on_otherwise(prescribed);
        }
        let mut step = t - from;
        let mut count = 0;
        while self.last.t < t {
            if let Ahead::Smooth(interval) = &self.ahead {
                if interval.contains(t) {
                    self.last = interval.state(self.drive.mechanism, t).ok_or(NotPossible::NotFinite { t })?;
                    return Ok(&self.last);
                }
                let behind = interval.after();
                if self.last.t < behind.1.t && behind.1.t <= t {
                    (self.position, self.last) = behind.clone();
                    self.drive.t = self.last.t;
                    self.ahead = Ahead::Regular;
                    step = t - self.last.t;
                    continue;
                }
            }
            count += 1;
            if count > MAX_STEPS {
                return Err(NotPossible::TooFast { t: from });
            }
            let next = if self.last.t + step >= t { t } else { self.last.t + step };
            match self.neighbour(next, prescribed) {
                Some(position) => {
                    let before = (self.last.t, self.position.determinant);
                    self.take(next, position, prescribed)?;
                    self.look_ahead(before, prescribed);
                    step *= 2.0;
                }
                None if step <= SHORTEST * (t - from) => return Err(self.stopped(next, prescribed)),
                None => step *= 0.5,
            }
        }
        Ok(&self.last)
    }

    /// Goes on from the last time with a prescribed motion that may have another acceleration.
    fn go_on_otherwise(&mut self, prescribed: Prescribed) -> Result<&PrescribedState, NotPossible> {
        let t = self.last.t;
        if let Ahead::Smooth(interval) = &self.ahead
            && interval.contains(t)
        {
            // The polynomials hold for the prescribed motion that they were made of.
            let given = |i: &usize| self.drive.is_given(*i);
            if (0..self.last.q.len()).filter(given).any(|i| !interval.agrees(i, t, |t| prescribed(i, t))) {
                return Err(NotPossible::DeadPoint { t, q: self.last.q.clone() });
            }
            return Ok(&self.last);
        }
        self.ahead = Ahead::Regular;
        self.last = state(&self.drive, &self.position, prescribed).ok_or(NotPossible::NotFinite { t })?;
        Ok(&self.last)
    }

    /// Takes the position at a later time.
    fn take(&mut self, t: f64, position: Position, prescribed: Prescribed) -> Result<(), NotPossible> {
        self.drive.t = t;
        self.position = position;
        self.last = state(&self.drive, &self.position, prescribed).ok_or(NotPossible::NotFinite { t })?;
        self.largest_determinant = self.largest_determinant.max(self.position.determinant.abs());
        Ok(())
    }

    /// Looks for a singular position ahead, where the determinant is small; `before` are an earlier time and the
    /// determinant there.
    fn look_ahead(&mut self, before: (f64, f64), prescribed: Prescribed) {
        let determinant = self.position.determinant;
        let regular = REGULAR * self.largest_determinant;
        if determinant.abs() > regular {
            self.ahead = Ahead::Regular;
        } else if matches!(self.ahead, Ahead::Regular) && determinant.abs() < before.1.abs() {
            let left = (self.last.t - before.0) * determinant / (before.1 - determinant);
            let middle = self.last.t + left;
            let distance = left * regular / determinant.abs();
            self.ahead = self.across(middle, distance, prescribed);
        }
    }

    /// The motion across a singular position, from a distance in time before it.
    ///
    /// Where branches cross, the given coordinates do not tell which one goes on, but the smooth motion does.
    fn across(&self, middle: f64, distance: f64, prescribed: Prescribed) -> Ahead {
        let placed = |t: f64, position: Position| {
            let mut drive = self.drive.clone();
            drive.t = t;
            state(&drive, &position, prescribed).map(|state| (position, state))
        };
        let follow = |from: &Placed, t: f64| {
            let (mut at, mut step) = (from.clone(), t - from.1.t);
            while at.1.t != t {
                let next = if (t - at.1.t).abs() <= step.abs() { t } else { at.1.t + step };
                let near = Self::near(&self.drive, &at.1, next, prescribed);
                match near.filter(|position| position.is_on_branch_of(&at.0)) {
                    Some(position) => at = placed(next, position)?,
                    None if step.abs() <= SHORTEST * distance => return None,
                    None => step *= 0.5,
                }
            }
            Some(at)
        };
        let here = (self.position.clone(), self.last.clone());
        let mut best = Ahead::Limit;
        let mut middle = middle;
        for distance in DISTANCES.map(|part| part * distance) {
            let Some(before) = follow(&here, middle - distance) else { break };
            let beyond = Self::near(&self.drive, &before.1, middle + distance, prescribed);
            let beyond = beyond.filter(|position| position.determinant * before.0.determinant < 0.0);
            let Some(after) = beyond.and_then(|position| placed(middle + distance, position)) else { continue };
            // The zero of the determinant, by the secant.
            let [one, other] = [&before, &after].map(|placed| placed.0.determinant);
            middle += distance * (one + other) / (one - other);
            let ends = [(&before, -distance), (&after, distance)].map(|(from, left)| follow(from, middle + left));
            let [Some(before), Some(after)] = ends else { continue };
            match (&best, SingularInterval::new(self.drive.mechanism, middle, [&before, &after], follow)) {
                (Ahead::Smooth(best), Some(other)) if best.error <= other.error => {}
                (_, Some(other)) => best = Ahead::Smooth(Box::new(other)),
                (Ahead::Limit, None) => best = Ahead::DeadPoint,
                (_, None) => {}
            }
        }
        best
    }

    /// The reason why there is no next position.
    fn stopped(&self, next: f64, prescribed: Prescribed) -> NotPossible {
        let (t, q) = (self.last.t, self.last.q.clone());
        let jumps = |i: &usize| self.drive.is_given(*i) && Self::jumps(&self.last, *i, prescribed(*i, next)[0], next);
        if let Some(coordinate) = (0..q.len()).find(jumps) {
            return NotPossible::Discontinuous { coordinate, t };
        }
        match self.ahead {
            Ahead::DeadPoint => NotPossible::DeadPoint { t, q },
            _ => NotPossible::LimitPosition { t, q },
        }
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

/// The smallest determinant at which rounding errors are small, relative to the largest one.
const REGULAR: f64 = 0.1;
/// Half-widths of the singular interval that are tried, relative to that at whose ends the determinant is `REGULAR` of
/// its largest value.
const DISTANCES: [f64; 3] = [1.0, 0.5, 0.25];
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
    with_outputs(
        drive.mechanism,
        PrescribedState { t, q, qd, qdd, multipliers, forces, outputs: Vec::new(), error: 0.0 },
    )
}

/// The state with its outputs; `None` if a number is not finite.
pub(super) fn with_outputs(mechanism: &dyn Mechanism, mut state: PrescribedState) -> Option<PrescribedState> {
    let PrescribedState { t, q, qd, qdd, multipliers, forces, outputs, .. } = &mut state;
    outputs.resize(mechanism.description().outputs.len(), 0.0);
    mechanism.outputs(*t, q, qd, qdd, multipliers, outputs);
    let all = [qd, qdd, multipliers, forces, outputs];
    let is_finite = all.into_iter().flatten().all(|value| value.is_finite());
    is_finite.then_some(state)
}
