//! Rounding errors of a kernel in double precision.

use qrm_core::{DoubleDouble, NamedTape};
use qrm_scene::scene::Scene;

use super::evaluation::Evaluation;
use super::sample::Sample;

/// A kernel at a random state.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// The growth factor.
    pub growth_factor: f64,
    /// The largest difference between the accelerations in double precision and those with 32 digits, relative to the
    /// largest acceleration.
    pub error: f64,
}

/// The accuracy of a kernel at random states, half of them near the start. States outside the domain of the formulae
/// are left out.
pub fn accuracy(scene: &Scene, tape: &NamedTape, states: usize) -> Vec<Accuracy> {
    let mut random = fastrand::Rng::with_seed(1);
    let at = |number: usize| {
        let sample = Sample::random(scene, number, &mut random);
        let residuals = vec![0.0; scene.constraints.len()];
        let exact: Evaluation<DoubleDouble> = sample.evaluation(scene, tape, &residuals);
        let rounded: Evaluation<f64> = sample.evaluation(scene, tape, &residuals);
        // A number that is not one stays.
        let larger = |most: f64, x: f64| if x.abs() <= most { most } else { x.abs() };
        let largest = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, larger);
        let [wanted, growth] = ["accelerations", "growth_factor"].map(|name| exact.results(name));
        let size = largest(&mut wanted.iter().map(|x| x.hi()));
        let differences = wanted.iter().zip(rounded.results("accelerations")).map(|(exact, x)| exact.hi() - x);
        let error = largest(&mut differences.into_iter()) / size;
        let growth_factor = largest(&mut growth.iter().map(|x| x.hi()));
        let error = if error.is_nan() { f64::INFINITY } else { error };
        (size.is_finite() && growth_factor.is_finite()).then_some(Accuracy { growth_factor, error })
    };
    (0..states).filter_map(at).collect()
}
