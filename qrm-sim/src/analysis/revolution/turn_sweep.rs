//! A turn of a driven coordinate, or a length, from position to position.

use std::f64::consts::TAU;

use qrm_core::Mechanism;

use super::series::Vertex;
use crate::maximum::largest_between;
use crate::position::{CONTINUATION, LimitPosition, LoopSolver, NotAssembled, Position, Start, assemble};
use crate::solve::constraint_rank;

/// The range of a driven length, relative to the size of the mechanism.
const REACH: f64 = 4.0;
/// The distance below which values are equal, relative to the whole range.
pub(super) const NEAR: f64 = 2e-5;
/// The resolution of a vertex, relative to the whole range.
const RESOLUTION: f64 = 1.6e-10;
/// Limit positions closer than this, relative to the whole range, are one change point.
pub(super) const GAP: f64 = 1.6e-7;

/// A turn of the driven coordinate.
pub(super) struct TurnSweep<'m> {
    pub(super) drive: LoopSolver<'m>,
    pub(super) start: Position,
    pub(super) driven: usize,
    /// A whole turn, or the range of a length.
    span: f64,
    /// 1 or -1.
    pub(super) direction: f64,
}

impl<'m> TurnSweep<'m> {
    pub(super) fn new(mechanism: &'m dyn Mechanism) -> Result<Self, NoRevolution> {
        if mechanism.is_driven() {
            return Err(NoRevolution::Driven);
        }
        let start = Start::new(mechanism);
        let (q, qd) = assemble(mechanism, Start::new(mechanism)).map_err(NoRevolution::NotAssembled)?;
        let degrees_of_freedom = q.len() - constraint_rank(mechanism, 0.0, &q);
        if degrees_of_freedom != 1 {
            return Err(NoRevolution::DegreesOfFreedom(degrees_of_freedom));
        }
        let Some(driven) = start.given.iter().position(|given| *given) else {
            return Err(NoRevolution::NothingGiven);
        };
        let drive = LoopSolver::new(mechanism, start.given.clone()).ok_or(NoRevolution::Singular)?;
        let direction = if qd[driven] < 0.0 { -1.0 } else { 1.0 };
        let start =
            drive.solve_loops(q).filter(|position| position.determinant != 0.0).ok_or(NoRevolution::Singular)?;
        let span = if drive.is_angle(driven) { TAU } else { REACH * drive.size(&start) };
        Ok(Self { drive, start, driven, span, direction })
    }

    /// Whether two values of the driven coordinate agree up to a fraction of the whole range.
    pub(super) fn is_near(&self, one: f64, other: f64, part: f64) -> bool {
        (one - other).abs() < part * self.span
    }

    /// Moves through the whole range in one direction; returns the end.
    pub(super) fn follow(
        &self,
        direction: f64,
        samples: usize,
        visit: &mut dyn FnMut(Step),
    ) -> Result<Position, LimitPosition> {
        let mut last = [self.start.clone(), self.start.clone(), self.start.clone()];
        // One more step, so that a smallest determinant at the start also lies between two others.
        for i in 1..=samples + 1 {
            let angle = self.start.q[self.driven] + direction * self.span * i as f64 / samples as f64;
            let next = match self.at(&last[2], angle) {
                Ok(next) => next,
                // The turn is complete.
                Err(_) if i > samples => return Ok(last[2].clone()),
                Err(limit) => {
                    let next = self.beyond_change_point(&last, angle, &limit).ok_or_else(|| limit.clone())?;
                    visit(Step::ChangePoint(limit.position.q[self.driven]));
                    next
                }
            };
            last.rotate_left(1);
            last[2] = next;
            let [before, at, after] = [0, 1, 2].map(|k| last[k].determinant.abs());
            if i > 1
                && at <= before
                && at <= after
                && at < before.max(after)
                && let Err(limit) = self.check_no_lock(&last[0], &last[2])
            {
                let angle = limit.position.q[self.driven];
                if !self.crosses(&last[0], &last[2], angle) {
                    return Err(limit);
                }
                visit(Step::ChangePoint(angle));
            }
            if i <= samples {
                visit(Step::To(Box::new(last[2].clone())));
            }
        }
        Ok(last[1].clone())
    }

    /// A position at or behind an angle, on the branch of the positions before a singular one; `None` if that is a
    /// limit position, where the branch ends.
    fn beyond_change_point(&self, before: &[Position; 3], angle: f64, limit: &LimitPosition) -> Option<Position> {
        let singular = limit.position.q[self.driven];
        let spacing = angle - before[2].q[self.driven];
        // Near the singular position the direction of the branch is lost in rounding errors.
        let is_apart = |position: &&Position| (singular - position.q[self.driven]) / spacing >= 0.5;
        let from = before.iter().rev().find(is_apart)?;
        let change = self.drive.linear_change(from, |_| 2.0 * (singular - from.q[self.driven]));
        let guess = from.q.iter().zip(&change).map(|(q, change)| q + change).collect();
        let beyond = self.drive.solve_loops(guess).filter(|to| self.crosses(from, to, singular))?;
        let is_behind = (angle - singular) / spacing >= 0.1;
        self.at(&beyond, if is_behind { angle } else { singular + 0.5 * spacing }).ok()
    }

    /// Whether a branch continues from one position to another through a singular one in between: its direction must
    /// match, and there must be no gap.
    fn crosses(&self, from: &Position, to: &Position, singular: f64) -> bool {
        let change = self.drive.linear_change(from, |i| to.q[i] - from.q[i]);
        let largest = change.iter().fold(0.0, |most: f64, change| most.max(change.abs()));
        let missed = from.q.iter().zip(&to.q).zip(&change).map(|((from, to), change)| (to - from - change).abs());
        let is_continued = missed.fold(0.0, f64::max) <= CONTINUATION * largest;
        // A gap may be shorter than the distance between two positions.
        let back = || self.at(to, from.q[self.driven]).and_then(|_| self.check_no_lock(to, from));
        is_continued && back().err().is_none_or(|limit| self.is_near(limit.position.q[self.driven], singular, GAP))
    }

    /// Returns an error if the mechanism locks between two positions, around the smallest determinant.
    fn check_no_lock(&self, from: &Position, to: &Position) -> Result<(), LimitPosition> {
        self.vertex(from, to, |position| -position.determinant.abs()).map(|_| ())
    }

    pub(super) fn at(&self, from: &Position, angle: f64) -> Result<Position, LimitPosition> {
        let mut target = from.q.clone();
        target[self.driven] = angle;
        self.drive.move_to(from, &target)
    }

    /// Locates the largest value of a quantity between two positions, by golden section search.
    pub(super) fn vertex(
        &self,
        from: &Position,
        to: &Position,
        value: impl Fn(&Position) -> f64,
    ) -> Result<Vertex, LimitPosition> {
        let at = |angle: f64| self.at(from, angle).map(|position| value(&position));
        let ends = [from.q[self.driven], to.q[self.driven]];
        let (angle, value) = largest_between(ends, RESOLUTION * self.span, at)?;
        Ok(Vertex { angle, value })
    }
}

/// A step of the revolution.
pub(super) enum Step {
    /// The next position.
    To(Box<Position>),
    /// Branches cross before the next position, at this angle.
    ChangePoint(f64),
}

/// The reason why there is no revolution.
#[derive(Clone, Debug, PartialEq)]
pub enum NoRevolution {
    /// The mechanism has this number of degrees of freedom instead of one.
    DegreesOfFreedom(usize),
    /// The scene gives no coordinate at its start.
    NothingGiven,
    /// Constraints depend on time.
    Driven,
    /// The start is a singular position.
    Singular,
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
}
