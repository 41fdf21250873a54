//! Derivatives with respect to the coordinates, by automatic differentiation of the scene.

use std::cell::OnceCell;

use num_dual::Dual;

use super::sample::Sample;
use qrm_scene::evaluate::State;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{Scene, Value as Formula};

/// Derivatives with respect to the coordinates at a state, with time and rates fixed.
pub(super) struct Gradients<'s, B> {
    pub(super) scene: &'s Scene,
    sample: &'s Sample<B>,
    states: OnceCell<Vec<State<Dual<B>>>>,
    /// The state whose values carry their derivatives along the rates.
    moving: State<Dual<B>>,
}

impl<'s, B: Differentiable> Gradients<'s, B> {
    pub(super) fn new(sample: &'s Sample<B>, scene: &'s Scene) -> Self {
        Self { scene, sample, states: OnceCell::new(), moving: along(sample, scene, &sample.qd) }
    }

    /// One state for each coordinate; every value in it carries its derivative with respect to that coordinate.
    pub(super) fn states(&self) -> &[State<Dual<B>>] {
        let [zero, one] = [0.0, 1.0].map(B::from);
        let n = self.sample.q.len();
        let unit = |i: usize| -> Vec<B> { (0..n).map(|j| if i == j { one } else { zero }).collect() };
        self.states.get_or_init(|| (0..n).map(|i| along(self.sample, self.scene, &unit(i))).collect())
    }

    pub(super) fn gradient(&self, value: &Formula) -> Vec<B> {
        let mut gradient = vec![B::from(0.0); self.sample.q.len()];
        for i in self.scene.coordinates_of([value]) {
            gradient[i] = self.states()[i].value(value).eps;
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
        self.states().iter().map(lever).collect()
    }

    /// The rate of a displacement due to the coordinates.
    pub(super) fn velocity(&self, displacement: &Formula) -> B {
        self.moving.value(displacement).eps
    }
}

/// The state whose values carry their derivatives along changes of the coordinates.
fn along<B: Differentiable>(sample: &Sample<B>, scene: &Scene, changes: &[B]) -> State<Dual<B>> {
    let q = sample.q.iter().zip(changes).map(|(q, change)| Dual::new(*q, *change)).collect();
    let zero = B::from(0.0);
    let qd = sample.qd.iter().map(|&v| Dual::new(v, zero)).collect();
    State::new(scene, &sample.parameters, Dual::new(sample.t, zero), q, qd)
}
