//! Random states for the comparison of generated functions.

use super::evaluation::{Evaluation, Number};
use super::size::SMALLEST;
use qrm_core::NamedTape;
use qrm_core::named_tape::Argument;
use qrm_scene::evaluate::constant;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{Scene, Start};

/// A random state and random parameters.
#[derive(Clone, Debug)]
pub(super) struct Sample<B = f64> {
    pub(super) parameters: Vec<f64>,
    pub(super) t: B,
    pub(super) q: Vec<B>,
    pub(super) qd: Vec<B>,
    pub(super) qdd: Vec<B>,
    pub(super) multipliers: Vec<B>,
    /// The sizes of the outputs that are normal forces of friction, at the indices of the outputs.
    pub(super) normal_forces: Vec<B>,
}

impl Sample {
    /// Creates random numbers. Every second sample has coordinates and rates near the scene's start, closer each time,
    /// for formulae that have a value nowhere else.
    pub(super) fn random(scene: &Scene, number: usize, random: &mut fastrand::Rng) -> Self {
        let near_start = number.is_multiple_of(2);
        let (n, m) = (scene.coordinates.len(), scene.constraints.len());
        let parameter = |random: &mut fastrand::Rng, p: &qrm_scene::scene::Parameter| {
            if p.left_out {
                0.0
            } else if p.value == 0.0 {
                between(random, 0.1, 1.0)
            } else {
                p.value * if near_start { between(random, 0.97, 1.03) } else { between(random, 0.8, 1.25) }
            }
        };
        let scene_values: Vec<f64> = scene.parameters.iter().map(|p| p.value).collect();
        let start = |start: &Start| match start {
            Start::Given(value) | Start::Guess(value) if near_start => constant(value, &scene_values),
            _ => 0.0,
        };
        let mut around =
            |value: f64, spread: f64| value * between(random, 0.97, 1.03) + between(random, -spread, spread);
        let spread = if near_start { [0.2, 0.02, 2e-3, 2e-4][number / 2 % 4] } else { 3.2 };
        let q = scene.coordinates.iter().map(|c| around(start(&c.position), spread)).collect();
        let qd = scene.coordinates.iter().map(|c| around(start(&c.rate), 5.0)).collect();
        Self {
            q,
            qd,
            parameters: scene.parameters.iter().map(|p| parameter(random, p)).collect(),
            t: between(random, 0.0, 2.0),
            qdd: (0..n).map(|_| between(random, -5.0, 5.0)).collect(),
            multipliers: (0..m).map(|_| between(random, -5.0, 5.0)).collect(),
            normal_forces: vec![0.0; scene.outputs.len()],
        }
    }

    /// The accepted error of vanishing numbers whose largest companion is `largest`, since numbers in the text of a
    /// module have 16 digits; zero if they do not vanish but exceed rounding errors of 32 digits.
    pub(super) fn error_of_zeros(&self, largest: f64) -> f64 {
        let largest_of = |numbers: &[f64]| numbers.iter().fold(1.0, |most: f64, number| most.max(number.abs()));
        let size = (largest_of(&self.parameters) * largest_of(&self.q) * largest_of(&self.qd)).powi(2);
        if largest <= SMALLEST * size { 1e-14 * size } else { 0.0 }
    }

    /// Creates random numbers near one, including parameters, independent of the scene's values: no term is negligible.
    pub(super) fn random_of_order_one(scene: &Scene, random: &mut fastrand::Rng) -> Self {
        let mut sample = Self::random(scene, 1, random);
        for (value, parameter) in sample.parameters.iter_mut().zip(&scene.parameters) {
            *value = if parameter.left_out { 0.0 } else { between(random, 0.5, 2.0) };
        }
        sample
    }

    /// Creates a sample that differs in the last digits.
    pub(super) fn nearby(&self) -> Self {
        let moved = |values: &[f64]| -> Vec<f64> {
            values
                .iter()
                .zip([1.0, -1.0, 0.7, -0.6, 0.9].into_iter().cycle())
                .map(|(v, s)| v * (1.0 + 1e-15 * s))
                .collect()
        };
        Self {
            parameters: moved(&self.parameters),
            t: self.t,
            q: moved(&self.q),
            qd: moved(&self.qd),
            qdd: moved(&self.qdd),
            multipliers: moved(&self.multipliers),
            normal_forces: self.normal_forces.clone(),
        }
    }

    /// Converts the sample to another number type.
    pub(super) fn on<B: Differentiable>(&self) -> Sample<B> {
        let all = |values: &[f64]| values.iter().map(|&value| B::from(value)).collect();
        Sample {
            parameters: self.parameters.clone(),
            t: B::from(self.t),
            q: all(&self.q),
            qd: all(&self.qd),
            qdd: all(&self.qdd),
            multipliers: all(&self.multipliers),
            normal_forces: all(&self.normal_forces),
        }
    }

    /// Evaluates all values of a tape, for given residuals of the constraints.
    pub(super) fn evaluation<'t, N: Number>(
        &self,
        scene: &Scene,
        tape: &'t NamedTape,
        residuals: &[f64],
    ) -> Evaluation<'t, N> {
        let on = |values: &[f64]| -> Vec<N> { values.iter().map(|&value| N::from_f64(value)).collect() };
        let kept = scene.parameters.iter().zip(&self.parameters).filter(|(p, _)| !p.left_out);
        let kept: Vec<N> = kept.map(|(_, &value)| N::from_f64(value)).collect();
        let arguments = [
            (Argument::Time, on(&[self.t])),
            (Argument::Coordinates, on(&self.q)),
            (Argument::Rates, on(&self.qd)),
            (Argument::Accelerations, on(&self.qdd)),
            (Argument::Multipliers, on(&self.multipliers)),
            (Argument::Residuals, on(residuals)),
        ];
        Evaluation::new(tape, &kept, &arguments.each_ref().map(|(argument, values)| (*argument, &values[..])))
    }
}

/// A random number in an interval.
fn between(random: &mut fastrand::Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.f64()
}
