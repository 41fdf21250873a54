//! The forces and torques of a scene's loads at a state, computed directly from the scene.

use num_dual::Dual;

use super::gradients::Gradients;
use super::sample::Sample;
use crate::term::Equations;
use qrm_scene::evaluate::State;
use qrm_scene::function::{Differentiable, Function};
use qrm_scene::scene::{Friction, LoadKind, Quantity, Scene, Value as Formula};

impl<B: Differentiable> Sample<B> {
    /// The forces and torques of a load, each with the displacement along which it acts.
    pub(super) fn load_forces<'s>(
        &self,
        scene: &'s Scene,
        plain: &State<B>,
        load: &'s LoadKind,
    ) -> Vec<(B, &'s Formula)> {
        match load {
            LoadKind::Force { force, at, .. } => {
                force.iter().zip(at).map(|(force, at)| (plain.value(force), at)).collect()
            }
            LoadKind::Torque { torque, angle, .. } => vec![(plain.value(torque), angle)],
            LoadKind::Gravity(field) => {
                let weighty = scene.bodies.iter().filter_map(|body| body.mass.as_ref().zip(body.com.as_ref()));
                let each = weighty.flat_map(|(mass, com)| {
                    field.iter().zip(com).map(move |(g, at)| (plain.value(mass) * plain.value(g), at))
                });
                each.collect()
            }
            LoadKind::Spring { along, .. } => {
                let [elastic, loss] = self.spring(scene, plain, load);
                vec![(elastic + loss, along)]
            }
        }
    }

    /// The force of a spring in two parts: that of its stiffness and potential, and the rest.
    fn spring(&self, scene: &Scene, plain: &State<B>, load: &LoadKind) -> [B; 2] {
        let zero = B::from(0.0);
        let LoadKind::Spring { along, stiffness, rest, damping, potential, force, friction } = load else {
            return [zero; 2];
        };
        let optional = |value: &Option<Formula>| value.as_ref().map_or(zero, |v| plain.value(v));
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, &vec![zero; self.q.len()]);
        let along = moving.value(along);
        let slope = potential.as_ref().map_or(zero, |potential| {
            let stretch = Dual::new(along.re, B::from(1.0));
            self.state_at(scene, Dual::new(self.t, zero)).law(potential, [stretch, Dual::from(f64::NAN)]).eps
        });
        let law = |value: &Formula| plain.law(value, [along.re, along.v1]);
        let sliding = |slip: &Formula| Function::Tanh.evaluate(&[along.v1 / plain.value(slip)]);
        let friction = friction.as_ref().map_or(zero, |Friction { size, slip, normal, .. }| {
            law(size) * normal.map_or(B::from(1.0), |k| self.normal_forces[k]) * sliding(slip)
        });
        let loss = force.as_ref().map_or(zero, law) - friction - optional(damping) * along.v1;
        [-optional(stiffness) * (along.re - optional(rest)) - slope, loss]
    }

    /// The generalized forces of the loads: effort times derivative of displacement.
    pub(super) fn generalized_forces(&self, gradients: &Gradients<B>, plain: &State<B>) -> Vec<B> {
        let scene = gradients.scene;
        let mut forces = vec![B::from(0.0); self.q.len()];
        for (effort, displacement) in scene.loads.iter().flat_map(|load| self.load_forces(scene, plain, &load.kind)) {
            for (force, derivative) in forces.iter_mut().zip(gradients.gradient(displacement)) {
                *force += effort * derivative;
            }
        }
        forces
    }

    /// The sums of the absolute values of the terms of the generalized forces, to which rounding errors are relative.
    pub(super) fn force_sizes(&self, scene: &Scene, equations: &Equations) -> Vec<B> {
        let gradients = Gradients::new(self, scene);
        let zero = B::from(0.0);
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, &vec![zero; self.q.len()]);
        let rows = self.com_rows(scene, equations, &plain).into_iter();
        let inertial = rows.map(|(row, inertia)| (inertia * moving.value(row).v2, row));
        let loads = scene.loads.iter().flat_map(|load| self.load_forces(scene, &plain, &load.kind));
        let levers = gradients.levers();
        let mut sizes = vec![zero; self.q.len()];
        for (effort, displacement) in inertial.chain(loads) {
            for ((size, derivative), lever) in sizes.iter_mut().zip(gradients.gradient(displacement)).zip(&levers) {
                // Terms also cancel inside derivatives: a spring from a pivot to its own link does no work.
                *size += effort.abs() * (derivative.abs() + *lever);
            }
        }
        sizes
    }

    /// The potential of the loads that have one, and the power of the other loads.
    pub(super) fn potential_and_power(
        &self,
        gradients: &Gradients<B>,
        plain: &State<B>,
        x: &[(&Formula, B)],
        equations: &Equations,
    ) -> [B; 2] {
        let scene = gradients.scene;
        let zero = B::from(0.0);
        let (mut potential, mut power) = (zero, zero);
        for load in &scene.loads {
            let is_constant = match &load.kind {
                LoadKind::Force { force: [x, y], .. } => vec![is_constant(x), is_constant(y)],
                LoadKind::Torque { torque, .. } => vec![is_constant(torque)],
                LoadKind::Gravity(field) => {
                    for ((at, mass), row) in x.iter().zip(&equations.rows).filter(|(_, row)| row.axis < 2) {
                        potential -= *mass * plain.value(&field[row.axis]) * plain.value(at);
                    }
                    continue;
                }
                LoadKind::Spring { along, stiffness, rest, potential: own, .. } if !scene.depends_on_time([along]) => {
                    let optional = |value: &Option<Formula>| value.as_ref().map_or(zero, |v| plain.value(v));
                    let extension = plain.value(along) - optional(rest);
                    potential += optional(stiffness) * extension * extension * 0.5;
                    potential +=
                        own.as_ref().map_or(zero, |own| plain.law(own, [plain.value(along), B::from(f64::NAN)]));
                    power += self.spring(scene, plain, &load.kind)[1] * gradients.velocity(along);
                    continue;
                }
                LoadKind::Spring { .. } => vec![false],
            };
            for ((effort, displacement), is_constant) in
                self.load_forces(scene, plain, &load.kind).into_iter().zip(is_constant)
            {
                if is_constant && !scene.depends_on_time([displacement]) {
                    potential -= effort * plain.value(displacement);
                } else {
                    power += effort * gradients.velocity(displacement);
                }
            }
        }
        [potential, power]
    }
}

/// Whether a force is constant.
fn is_constant(value: &Formula) -> bool {
    value.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi))
}
