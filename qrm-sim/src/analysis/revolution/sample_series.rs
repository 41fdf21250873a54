//! The course of a quantity over the positions of a turn.

use std::f64::consts::TAU;

use super::series::{Series, Vertex, parabola};
use super::turn_sweep::{NEAR, TurnSweep};
use crate::position::{LimitPosition, Position};
use crate::solve::{Matrix, dot};

/// The smallest determinant, relative to the largest one, between positions whose forces are not lost in rounding
/// errors.
const SINGULAR: f64 = 1e-3;
/// The step of a difference quotient, relative to the range of a coordinate.
const DIFFERENCE: f64 = 1e-6;
/// The rounding errors of a sum, relative to its terms.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// The distance of a position from a lock, relative to that of the next position.
const NEAR_LOCK: f64 = 1e-3;
/// A quantity that grows by more than this towards a lock is unbounded: forces grow with one over the root of the
/// distance.
const GROWTH: f64 = 5.0;

impl TurnSweep<'_> {
    /// The course of a quantity with these `rounding` errors over consecutive positions.
    pub(super) fn sample_series(
        &self,
        positions: &[Position],
        returns: bool,
        rounding: f64,
        value: impl Fn(&Position) -> f64,
    ) -> Series {
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
            // Changes of the size of rounding errors are ignored.
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
            // A vertex at a sample is found from both sides.
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

    /// The course of a quantity between locks; it may grow without bound towards them.
    pub(super) fn sample_between_locks(
        &self,
        positions: &[Position],
        is_locked: [bool; 2],
        returns: bool,
        value: impl Fn(&Position) -> f64,
    ) -> Series {
        let [begin, end] = is_locked.map(usize::from);
        let inner = &positions[begin..positions.len() - end];
        let mut course = self.sample_series(inner, returns, 0.0, &value);
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
    pub(super) fn inertia(&self, position: &Position) -> f64 {
        let tangent = self.drive.tangent(position, self.driven);
        let mut mass_matrix = Matrix::zero(tangent.len(), tangent.len());
        self.drive.mechanism.mass_matrix(&position.q, mass_matrix.entries_mut());
        let momentum: Vec<f64> = mass_matrix.iter().map(|row| dot(row, &tangent)).collect();
        dot(&tangent, &momentum)
    }

    pub(super) fn outputs(&self, q: &[f64]) -> Vec<f64> {
        let (multipliers, _) = self.drive.balance(q);
        self.drive.outputs(q, &multipliers)
    }

    /// The rounding errors of the outputs: those of terms that grow with the coordinates and may cancel.
    pub(super) fn rounding_of_outputs(&self) -> Vec<f64> {
        let q = &self.start.q;
        let here = self.outputs(q);
        let mut sizes: Vec<f64> = here.iter().map(|value| value.abs()).collect();
        for i in 0..q.len() {
            // An angle passes through a whole turn, from any start.
            let range = q[i].abs() + if self.drive.is_angle(i) { TAU } else { 0.0 };
            let mut beside = q.clone();
            beside[i] += DIFFERENCE * range;
            let change = self.outputs(&beside).into_iter().zip(&here).map(|(there, here)| (there - here).abs());
            sizes.iter_mut().zip(change).for_each(|(size, change)| *size += change / DIFFERENCE);
        }
        sizes.iter().map(|size| ROUNDING * size).collect()
    }
}
