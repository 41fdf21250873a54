//! How far states are from others.

use qrm_scene::scene::Scene;
use qrm_sim::analysis::StateAt;

/// The largest difference of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Errors {
    /// Of a coordinate.
    pub(crate) position: f64,
    /// Of a rate.
    pub(crate) rate: f64,
    /// Of a reaction that the scene asks for.
    pub(crate) force: f64,
}

impl Errors {
    /// Compares states at the same times; what is not known is not a number, and not compared.
    pub(crate) fn between(scene: &Scene, states: &[StateAt], others: &[StateAt]) -> Self {
        let forces: Vec<usize> =
            scene.outputs.iter().enumerate().filter(|(_, output)| output.kind.is_reaction()).map(|(i, _)| i).collect();
        let mut errors = Self::default();
        for (a, b) in states.iter().zip(others) {
            errors.position = errors.position.max(largest(a.q.iter().zip(&b.q)));
            errors.rate = errors.rate.max(largest(a.qd.iter().zip(&b.qd)));
            errors.force = errors.force.max(largest(forces.iter().map(|&i| (&a.outputs[i], &b.outputs[i]))));
        }
        errors
    }

    /// The errors multiplied by a factor.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { position: factor * self.position, rate: factor * self.rate, force: factor * self.force }
    }

    /// The larger of each kind.
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            position: self.position.max(other.position),
            rate: self.rate.max(other.rate),
            force: self.force.max(other.force),
        }
    }
}

fn largest<'n>(pairs: impl Iterator<Item = (&'n f64, &'n f64)>) -> f64 {
    // `max` passes over what is not a number.
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
