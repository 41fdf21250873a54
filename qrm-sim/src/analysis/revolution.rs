//! A slow motion of a driven coordinate, over a turn or a length: positions, forces of static equilibrium, limit
//! positions.

use crate::position::{CONTINUATION, LimitPosition, LoopSolver, NotAssembled, Position, Start, assemble};
use std::f64::consts::TAU;

use qrm_core::Mechanism;

use crate::maximum::largest_between;
use crate::solve::{Matrix, constraint_rank, dot};

/// Positions in a turn.
const SAMPLES: usize = 720;
/// How far a driven length is moved, against the size of the mechanism.
const REACH: f64 = 4.0;

/// A revolution of the driven coordinate, or the range that it can move in.
#[derive(Clone, Debug)]
pub struct Revolution {
    /// The driven coordinate.
    pub coordinate: usize,
    /// Where the turn begins.
    pub start: f64,
    /// The direction in which the scene starts: 1 or -1.
    pub direction: f64,
    /// The range of the driven coordinate, and what ends it; `None` if the coordinate turns fully.
    pub range: Option<Range>,
    /// The change points, where branches cross, in the order of the turn: the mechanism may leave one on another branch
    /// than the one that is followed here.
    pub change_points: Vec<f64>,
    /// Whether all coordinates come back after a turn, angles up to whole turns.
    pub returns: bool,
    /// The course of each output, without motion.
    pub outputs: Vec<Series>,
    /// The course of the generalized force on the driven coordinate that balances the loads.
    pub balance: Series,
    /// The course of the effective inertia at the driven coordinate.
    pub inertia: Series,
}

/// The values of a quantity over the revolution, or between the limit positions.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Value at the beginning and at the end.
    pub ends: [f64; 2],
    /// Where it turns back, in the order of the turn.
    pub vertices: Vec<Vertex>,
    /// The smallest value of the quantity and where it is, at a vertex or an end; infinite where it has no bound.
    pub smallest: (f64, f64),
    /// The largest value of the quantity and where it is; likewise.
    pub largest: (f64, f64),
}

/// Where a quantity turns back.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// The driven coordinate there.
    pub angle: f64,
    /// The value.
    pub value: f64,
}

impl Series {
    /// Whether the value after the turn is the first one, except for rounding.
    pub fn is_periodic(&self) -> bool {
        let [first, last] = self.ends;
        (last - first).abs() <= 1e-9 * (self.largest.0 - self.smallest.0)
    }
}

/// Between which values a driven coordinate can move, and the constraint that ends its way there.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The smallest value; none if it can be moved by a whole turn, or as far as a length is looked at.
    pub low: Option<(f64, Option<usize>)>,
    /// The largest value, likewise.
    pub high: Option<(f64, Option<usize>)>,
}

/// Why there is no revolution.
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

/// Moves the driven coordinate through a revolution, or a length as far as it goes.
///
/// # Errors
/// No coordinate can be driven so.
pub fn revolution(mechanism: &dyn Mechanism) -> Result<Revolution, NoRevolution> {
    let round = Round::new(mechanism)?;
    let driven = round.driven;
    let description = mechanism.description();
    let mut positions = vec![round.start.clone()];
    let mut change_points = Vec::new();
    let mut visit = |step| match step {
        Step::To(position) => positions.push(position),
        Step::ChangePoint(angle) => change_points.push(angle),
    };
    let followed = round.follow(round.direction, SAMPLES, &mut visit);
    let (range, is_locked, returns) = match followed {
        Ok(end) if description.is_angle(driven) => {
            let is_periodic = |i: usize| {
                let unit = description.coordinates[i].unit;
                let size = if description.is_angle(i) { 1.0 } else { end.q[i].abs().max(round.start.q[i].abs()) };
                wrap_angle(end.q[i] - round.start.q[i], unit).abs() <= 1e-9 * size
            };
            (None, [false; 2], (0..end.q.len()).all(is_periodic))
        }
        ahead => {
            let mut behind = Vec::new();
            let mut visit = |step| match step {
                Step::To(position) => behind.push(position),
                Step::ChangePoint(angle) => change_points.push(angle),
            };
            let back = round.follow(-round.direction, SAMPLES, &mut visit).err();
            behind.extend(back.as_ref().map(|limit| limit.position.clone()));
            behind.reverse();
            let ahead = ahead.err();
            let is_at_start =
                |limit: &LimitPosition| round.is_near(limit.position.q[driven], round.start.q[driven], GAP);
            if [&ahead, &back].into_iter().all(|limit| limit.as_ref().is_some_and(is_at_start)) {
                return Err(NoRevolution::Singular);
            }
            positions.extend(ahead.as_ref().map(|limit| limit.position.clone()));
            positions.splice(0..0, behind);
            let end = |limit: &LimitPosition| (limit.position.q[driven], round.drive.open_beyond(limit));
            let (ahead, back) = (ahead.as_ref().map(end), back.as_ref().map(end));
            let is_locked = [back.is_some(), ahead.is_some()];
            let (low, high) = if round.direction > 0.0 { (back, ahead) } else { (ahead, back) };
            (Some(Range { low, high }), is_locked, false)
        }
    };
    let (count, rounding) = (description.outputs.len(), round.rounding_of_outputs());
    // The positions on both sides tell of the same one.
    change_points.dedup_by(|a, b| round.is_near(*a, *b, NEAR));
    Ok(Revolution {
        coordinate: driven,
        start: round.start.q[driven],
        direction: round.direction,
        outputs: (0..count)
            .map(|i| round.course(&positions, returns, rounding[i], |at| round.outputs(&at.q)[i]))
            .collect(),
        balance: round.between_locks(&positions, is_locked, returns, |at| round.drive.balance(&at.q).1[driven]),
        inertia: round.between_locks(&positions, is_locked, returns, |at| round.inertia(at)),
        range,
        change_points,
        returns,
    })
}

/// Whether the driven coordinate can make a full revolution.
pub fn can_revolve(mechanism: &dyn Mechanism) -> bool {
    Round::new(mechanism).is_ok_and(|round| round.follow(round.direction, SAMPLES / 8, &mut |_| ()).is_ok())
}

/// A part of the way around.
enum Step {
    /// The next position.
    To(Position),
    /// Branches cross before the next position, at this angle.
    ChangePoint(f64),
}

/// Values are the same that are this near to each other, against the whole way.
const NEAR: f64 = 2e-5;
/// How well a vertex is located, likewise.
const RESOLUTION: f64 = 1.6e-10;
/// Between positions whose determinants are this small against the largest one, forces are lost in rounding errors.
const SINGULAR: f64 = 1e-3;
/// The step of a difference quotient, against the range of a coordinate.
const DIFFERENCE: f64 = 1e-6;
/// Rounding errors of a sum, against the size of its terms.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// How near a position is to a lock, against the next one.
const NEAR_LOCK: f64 = 1e-3;
/// A quantity that grows by more to there has no bound: forces grow with one over the root of the distance.
const GROWTH: f64 = 5.0;
/// Limit positions this near to each other, likewise, are one change point.
const GAP: f64 = 1.6e-7;

/// A turn to be made.
struct Round<'m> {
    drive: LoopSolver<'m>,
    start: Position,
    driven: usize,
    /// A whole turn, or how far a length is moved.
    span: f64,
    /// 1 or -1.
    direction: f64,
}

impl<'m> Round<'m> {
    fn new(mechanism: &'m dyn Mechanism) -> Result<Self, NoRevolution> {
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

    /// Whether two values of the driven coordinate are the same, up to a part of the whole way.
    fn is_near(&self, one: f64, other: f64, part: f64) -> bool {
        (one - other).abs() < part * self.span
    }

    /// Goes the whole way, in one direction or the other, and says where that ends.
    fn follow(&self, direction: f64, samples: usize, visit: &mut dyn FnMut(Step)) -> Result<Position, LimitPosition> {
        let mut last = [self.start.clone(), self.start.clone(), self.start.clone()];
        // One step more, so that a smallest determinant at the start is between two others as well.
        for i in 1..=samples + 1 {
            let angle = self.start.q[self.driven] + direction * self.span * i as f64 / samples as f64;
            let next = match self.at(&last[2], angle) {
                Ok(next) => next,
                // The turn is made already.
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
                && let Err(limit) = self.lock_between(&last[0], &last[2])
            {
                let angle = limit.position.q[self.driven];
                if !self.crosses(&last[0], &last[2], angle) {
                    return Err(limit);
                }
                visit(Step::ChangePoint(angle));
            }
            if i <= samples {
                visit(Step::To(last[2].clone()));
            }
        }
        Ok(last[1].clone())
    }

    /// A position at or behind an angle, on the branch of the positions before a singular one; `None` if that is a
    /// limit position, behind which the branch does not go on.
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

    /// Whether a branch goes on from one position to another through a singular one in between: by its direction, and
    /// without a gap.
    fn crosses(&self, from: &Position, to: &Position, singular: f64) -> bool {
        let change = self.drive.linear_change(from, |i| to.q[i] - from.q[i]);
        let largest = change.iter().fold(0.0, |most: f64, change| most.max(change.abs()));
        let missed = from.q.iter().zip(&to.q).zip(&change).map(|((from, to), change)| (to - from - change).abs());
        let is_continued = missed.fold(0.0, f64::max) <= CONTINUATION * largest;
        // A gap may be shorter than the way between two positions.
        let back = || self.at(to, from.q[self.driven]).and_then(|_| self.lock_between(to, from));
        is_continued && back().err().is_none_or(|limit| self.is_near(limit.position.q[self.driven], singular, GAP))
    }

    /// An error if the mechanism locks between two positions, around the smallest determinant.
    fn lock_between(&self, from: &Position, to: &Position) -> Result<(), LimitPosition> {
        self.vertex(from, to, |position| -position.determinant.abs()).map(|_| ())
    }

    fn at(&self, from: &Position, angle: f64) -> Result<Position, LimitPosition> {
        let mut target = from.q.clone();
        target[self.driven] = angle;
        self.drive.move_to(from, &target)
    }

    /// Where a quantity is largest between two positions, by golden sections.
    fn vertex(
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

    /// How a quantity with these `rounding` errors goes over positions that follow each other.
    fn course(&self, positions: &[Position], returns: bool, rounding: f64, value: impl Fn(&Position) -> f64) -> Series {
        let values: Vec<f64> = positions.iter().map(&value).collect();
        let (Some(&first), Some(&last)) = (values.first(), values.last()) else { return Series::default() };
        let (low, high) = values.iter().fold((first, first), |(low, high), v| (low.min(*v), high.max(*v)));
        if high - low <= rounding {
            let constant = if first.abs() <= rounding { 0.0 } else { first };
            let at = (constant, positions[0].q[self.driven]);
            return Series { ends: [constant; 2], vertices: Vec::new(), smallest: at, largest: at };
        }
        let mut course = Series { ends: [first, last], ..Series::default() };
        let is_cycle = returns && (last - first).abs() <= 1e-9 * (high - low);
        let count = positions.len();
        let regular = positions.iter().fold(0.0, |most: f64, position| most.max(position.determinant.abs()));
        for i in 0..count {
            // The end of a cycle is its beginning.
            let (before, after) = match (i, is_cycle) {
                (0, true) => (count - 2, 1),
                (0, false) => continue,
                (i, _) if i + 1 == count => continue,
                (i, _) => (i - 1, i + 1),
            };
            let [v0, v, v1] = [values[before], values[i], values[after]];
            // Changes at the size of rounding errors are none.
            let noise = rounding.max(1e-12 * (high - low).max(v.abs() * 1e-2));
            let sign = if v >= v0 && v >= v1 { 1.0 } else { -1.0 };
            if !(sign * (v - v0) >= 0.0 && sign * (v - v1) >= 0.0 && (v - v0).abs().max((v - v1).abs()) > noise) {
                continue;
            }
            let three = [before, i, after].map(|k| &positions[k]);
            let found = match i {
                _ if three.iter().any(|position| position.determinant.abs() < SINGULAR * regular) => None,
                0 => self.around_start(&positions[1], |position| sign * value(position)).ok(),
                _ => self.vertex(&positions[before], &positions[after], |position| sign * value(position)).ok(),
            };
            let vertex = found.map_or_else(
                || parabola(three.map(|position| position.q[self.driven]), [v0, v, v1]),
                |vertex| Vertex { value: sign * vertex.value, ..vertex },
            );
            // A vertex that lies on a sample is found from both sides.
            if course.vertices.last().is_none_or(|before| !self.is_near(before.angle, vertex.angle, NEAR)) {
                course.vertices.push(vertex);
            }
        }
        let ends = [(first, 0), (last, count - 1)].map(|(value, i)| (value, positions[i].q[self.driven]));
        let all = || course.vertices.iter().map(|vertex| (vertex.value, vertex.angle)).chain(ends);
        course.smallest = all().fold(ends[0], |least, one| if one.0 < least.0 { one } else { least });
        course.largest = all().fold(ends[0], |most, one| if one.0 > most.0 { one } else { most });
        course
    }

    /// The course of a quantity that may grow without bound towards locks, and is infinite there.
    fn between_locks(
        &self,
        positions: &[Position],
        is_locked: [bool; 2],
        returns: bool,
        value: impl Fn(&Position) -> f64,
    ) -> Series {
        let [begin, end] = is_locked.map(usize::from);
        let inner = &positions[begin..positions.len() - end];
        let mut course = self.course(inner, returns, 0.0, &value);
        let ends = [(positions.first(), inner.first()), (positions.last(), inner.last())];
        for ((lock, next), _) in ends.into_iter().zip(is_locked).filter(|(_, is_locked)| *is_locked) {
            let (Some(lock), Some(next)) = (lock, next) else { continue };
            let lock = lock.q[self.driven];
            let Ok(near) = self.at(next, lock + NEAR_LOCK * (next.q[self.driven] - lock)) else { continue };
            let (near, next) = (value(&near), value(next));
            if near.abs() > GROWTH * next.abs() {
                let infinite = if near > 0.0 { &mut course.largest } else { &mut course.smallest };
                *infinite = (near.signum() * f64::INFINITY, lock);
            }
        }
        course
    }

    /// A vertex near the start of a cycle.
    fn around_start(&self, next: &Position, value: impl Fn(&Position) -> f64) -> Result<Vertex, LimitPosition> {
        let step = next.q[self.driven] - self.start.q[self.driven];
        let before = self.at(&self.start, self.start.q[self.driven] - step)?;
        self.vertex(&before, next, value)
    }

    /// The effective inertia at the driven coordinate: `t' Mbar t` with its tangent t.
    fn inertia(&self, position: &Position) -> f64 {
        let tangent = self.drive.tangent(position, self.driven);
        let mut mass_matrix = Matrix::zero(tangent.len(), tangent.len());
        self.drive.mechanism.mass_matrix(&position.q, mass_matrix.entries_mut());
        let momentum: Vec<f64> = mass_matrix.iter().map(|row| dot(row, &tangent)).collect();
        dot(&tangent, &momentum)
    }

    fn outputs(&self, q: &[f64]) -> Vec<f64> {
        let (multipliers, _) = self.drive.balance(q);
        self.drive.outputs(q, &multipliers)
    }

    /// The sizes of rounding errors in the outputs: those of terms that grow with the coordinates and may cancel.
    fn rounding_of_outputs(&self) -> Vec<f64> {
        let q = &self.start.q;
        let here = self.outputs(q);
        let mut sizes: Vec<f64> = here.iter().map(|value| value.abs()).collect();
        for i in 0..q.len() {
            // An angle goes through a turn, whatever it is at the start.
            let range = q[i].abs() + if self.drive.is_angle(i) { TAU } else { 0.0 };
            let mut beside = q.clone();
            beside[i] += DIFFERENCE * range;
            let change = self.outputs(&beside).into_iter().zip(&here).map(|(there, here)| (there - here).abs());
            sizes.iter_mut().zip(change).for_each(|(size, change)| *size += change / DIFFERENCE);
        }
        sizes.iter().map(|size| ROUNDING * size).collect()
    }
}

/// The vertex of the parabola through three points, if it is between them; the middle one otherwise.
fn parabola([a0, a, a1]: [f64; 3], [v0, v, v1]: [f64; 3]) -> Vertex {
    let [left, right] = [(v0 - v) / (a0 - a), (v1 - v) / (a1 - a)];
    let curvature = (right - left) / (a1 - a0);
    let slope = left - curvature * (a0 - a);
    let shift = -0.5 * slope / curvature;
    if (a0 - a).min(a1 - a) < shift && shift < (a0 - a).max(a1 - a) {
        Vertex { angle: a + shift, value: v + 0.5 * slope * shift }
    } else {
        Vertex { angle: a, value: v }
    }
}

/// A difference of two values in a unit; of angles without whole turns.
pub fn wrap_angle(difference: f64, unit: &str) -> f64 {
    if unit == "rad" { difference - TAU * (difference / TAU).round() } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_are_no_difference() {
        for (difference, wrapped) in [(7.0, 7.0 - TAU), (-4.0, TAU - 4.0), (3.0, 3.0), (-3.0, -3.0)] {
            assert!((wrap_angle(difference, "rad") - wrapped).abs() < 1e-15);
            assert_eq!(wrap_angle(difference, "m"), difference);
        }
    }
}
