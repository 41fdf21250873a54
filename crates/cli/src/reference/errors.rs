//! Differences between states.

use qrm_scene::scene::Scene;
use qrm_sim::analysis::StateAt;
use qrm_sim::columns::Kind;

/// The largest difference of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Errors {
    /// The largest difference of a coordinate.
    pub(crate) position: f64,
    /// The largest difference of a rate.
    pub(crate) rate: f64,
    /// The largest difference of a reaction output.
    pub(crate) force: f64,
    /// The largest difference of the requested column.
    pub(crate) asked: Option<f64>,
}

impl Errors {
    /// Compares states at the same times, also in one column; values that are not numbers are unknown and skipped.
    pub(crate) fn between(scene: &Scene, of: Option<Kind>, states: &[StateAt], others: &[StateAt]) -> Self {
        let forces: Vec<usize> =
            scene.outputs.iter().enumerate().filter(|(_, output)| output.kind.is_reaction()).map(|(i, _)| i).collect();
        let mut errors = Self { asked: of.map(|_| 0.0), ..Self::default() };
        for (a, b) in states.iter().zip(others) {
            errors.position = errors.position.max(largest(a.q.iter().zip(&b.q)));
            errors.rate = errors.rate.max(largest(a.qd.iter().zip(&b.qd)));
            errors.force = errors.force.max(largest(forces.iter().map(|&i| (&a.outputs[i], &b.outputs[i]))));
            let asked = of.map(|kind| (a.value(kind) - b.value(kind)).abs());
            errors.asked = errors.asked.zip(asked).map(|(most, asked)| most.max(asked));
        }
        errors
    }

    /// The error by which methods are compared: that of the requested column, or of the coordinates.
    pub(crate) fn judged(self) -> f64 {
        self.asked.unwrap_or(self.position)
    }

    /// The errors multiplied by a factor.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self {
            position: factor * self.position,
            rate: factor * self.rate,
            force: factor * self.force,
            asked: self.asked.map(|asked| factor * asked),
        }
    }

    /// The larger error of each kind.
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            position: self.position.max(other.position),
            rate: self.rate.max(other.rate),
            force: self.force.max(other.force),
            asked: self.asked.zip(other.asked).map(|(own, other)| own.max(other)),
        }
    }
}

fn largest<'n>(pairs: impl Iterator<Item = (&'n f64, &'n f64)>) -> f64 {
    // `max` skips values that are not numbers.
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
