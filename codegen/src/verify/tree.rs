//! The equations of motion of a large tree at a state, evaluated directly from the scene without matrices.

use super::adjoint::Adjoint;
use super::gradients::Gradients;
use super::sample::Sample;
use crate::term::Equations;
use num_dual::Dual2;
use qrm_scene::evaluate::State;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{Scene, Value as Formula};

/// The parts of the equations of motion of a tree at a state.
pub(super) struct EquationsOfTree<B> {
    /// The rows of x with two derivatives with respect to time.
    pub(super) positions: Vec<Dual2<B>>,
    /// `T qd`
    pub(super) velocities: Vec<B>,
    /// `T' M T qd`
    pub(super) momenta: Vec<B>,
    /// `Q + T' (F - M bias)`
    pub(super) forces: Vec<B>,
}

impl<B: Differentiable> EquationsOfTree<B> {
    pub(super) fn new(sample: &Sample<B>, rows: &[(&Formula, B)], gradients: &Gradients<B>, plain: &State<B>) -> Self {
        let scene = gradients.scene;
        let still = vec![B::from(0.0); sample.q.len()];
        let moving = State::along(scene, &sample.parameters, sample.t, &sample.q, &sample.qd, &still);
        let positions: Vec<Dual2<B>> = rows.iter().map(|(row, _)| moving.value(row)).collect();
        let velocities: Vec<B> = rows.iter().map(|(row, _)| gradients.velocity(row)).collect();
        let mut momenta = Adjoint::new(scene, plain, false);
        for ((row, inertia), velocity) in rows.iter().zip(&velocities) {
            momenta.add(row, *inertia * *velocity);
        }
        let inertial = rows.iter().zip(&positions).map(|((row, inertia), x)| (-*inertia * x.v2, *row));
        let mut forces = Adjoint::new(scene, plain, false);
        for (effort, displacement) in inertial.chain(sample.all_load_forces(scene, plain)) {
            forces.add(displacement, effort);
        }
        Self { positions, velocities, momenta: momenta.sums(), forces: forces.sums() }
    }
}

impl<B: Differentiable> Sample<B> {
    /// For each coordinate what remains of `Mbar qdd - fbar` for given accelerations, and the sum of the absolute
    /// values of its terms.
    pub(super) fn balance(&self, scene: &Scene, equations: &Equations, accelerations: &[B]) -> Vec<(B, B)> {
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, accelerations);
        let rows = self.com_rows(scene, equations, &plain).into_iter();
        let inertial = rows.map(|(row, inertia)| (inertia * moving.value(row).v2, row));
        let loads = self.all_load_forces(scene, &plain).map(|(effort, displacement)| (-effort, displacement));
        let [mut rest, mut sizes] = [false, true].map(|takes_sizes| Adjoint::new(scene, &plain, takes_sizes));
        for (effort, displacement) in inertial.chain(loads) {
            rest.add(displacement, effort);
            sizes.add(displacement, effort);
        }
        rest.sums().into_iter().zip(sizes.sums()).collect()
    }

    /// The forces and torques of all loads, each with the displacement along which it acts.
    fn all_load_forces<'s>(&self, scene: &'s Scene, plain: &State<B>) -> impl Iterator<Item = (B, &'s Formula)> {
        scene.loads.iter().flat_map(|load| self.load_forces(scene, plain, &load.kind))
    }
}
