//! Derivatives with respect to the coordinates, by automatic differentiation of the scene.

use num_dual::Dual;

use super::sample::Sample;
use qrm_scene::evaluate::State;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{Scene, Value as Formula};

/// Derivatives with respect to the coordinates at a state, with time and rates fixed.
pub(super) struct Gradients<'s, B> {
    pub(super) scene: &'s Scene,
    qd: &'s [B],
    /// One state for each coordinate; every value in it carries its derivative with respect to that coordinate.
    pub(super) states: Vec<State<Dual<B>>>,
}

impl<'s, B: Differentiable> Gradients<'s, B> {
    pub(super) fn new(sample: &'s Sample<B>, scene: &'s Scene) -> Self {
        let states = (0..sample.q.len()).map(|i| by_coordinate(sample, scene, i)).collect();
        Self { scene, qd: &sample.qd, states }
    }

    pub(super) fn gradient(&self, value: &Formula) -> Vec<B> {
        let mut gradient = vec![B::from(0.0); self.states.len()];
        for i in self.scene.coordinates_of(value) {
            gradient[i] = self.states[i].value(value).eps;
        }
        gradient
    }

    /// The largest derivative of any point with respect to each coordinate.
    pub(super) fn levers(&self) -> Vec<B> {
        let larger = |most: B, moved: B| if moved.re() > most.re() { moved } else { most };
        let lever = |state: &State<Dual<B>>| {
            let moved = (0..self.scene.points.len()).flat_map(|point| state.point(point)).map(|place| place.eps.abs());
            moved.fold(B::from(0.0), larger)
        };
        self.states.iter().map(lever).collect()
    }

    /// The rate of a displacement due to the coordinates.
    pub(super) fn velocity(&self, displacement: &Formula) -> B {
        self.gradient(displacement).iter().zip(self.qd).map(|(s, v)| *s * *v).sum()
    }
}

/// The state whose values carry their derivatives with respect to one coordinate.
fn by_coordinate<B: Differentiable>(sample: &Sample<B>, scene: &Scene, i: usize) -> State<Dual<B>> {
    let [zero, one] = [0.0, 1.0].map(B::from);
    let dual = |(j, &q): (usize, &B)| Dual::new(q, if i == j { one } else { zero });
    let q = sample.q.iter().enumerate().map(dual).collect();
    let qd = sample.qd.iter().map(|&v| Dual::new(v, zero)).collect();
    State::new(scene, &sample.parameters, Dual::new(sample.t, zero), q, qd)
}
