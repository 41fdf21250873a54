//! Derivatives by the coordinates, by automatic differentiation of the scene.

use num_dual::Dual64;

use super::sample::Sample;
use qrm_scene::evaluate::State;
use qrm_scene::scene::{Scene, Value as Formula};

/// Derivatives by the coordinates at a state, time and rates held.
pub(super) struct Gradients<'s> {
    pub(super) scene: &'s Scene,
    qd: &'s [f64],
    /// The state once for each coordinate by which every value in it carries its derivative.
    pub(super) states: Vec<State<Dual64>>,
}

impl<'s> Gradients<'s> {
    pub(super) fn new(sample: &'s Sample, scene: &'s Scene) -> Self {
        let states = (0..sample.q.len()).map(|i| by_coordinate(sample, scene, i)).collect();
        Self { scene, qd: &sample.qd, states }
    }

    pub(super) fn of(&self, value: &Formula) -> Vec<f64> {
        let mut gradient = vec![0.0; self.states.len()];
        for i in self.scene.coordinates_of(value) {
            gradient[i] = self.states[i].value(value).eps;
        }
        gradient
    }

    /// The rate of a displacement that the coordinates bring.
    pub(super) fn velocity(&self, displacement: &Formula) -> f64 {
        self.of(displacement).iter().zip(self.qd).map(|(s, v)| s * v).sum()
    }
}

/// The state in which every value carries its derivative by one coordinate.
fn by_coordinate(sample: &Sample, scene: &Scene, i: usize) -> State<Dual64> {
    let dual = |(j, &q): (usize, &f64)| Dual64::new(q, f64::from(u8::from(i == j)));
    let q = sample.q.iter().enumerate().map(dual).collect();
    let qd = sample.qd.iter().map(|&v| Dual64::new(v, 0.0)).collect();
    State::new(scene, &sample.parameters, Dual64::from(sample.t), q, qd)
}
