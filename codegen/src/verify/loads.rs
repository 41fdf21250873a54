//! What the loads of a scene do at a state, straight from the scene.

use num_dual::Dual64;

use super::gradients::Gradients;
use super::sample::Sample;
use crate::term::Equations;
use qrm_scene::evaluate::State;
use qrm_scene::scene::{LoadKind, Quantity, Scene, Value as Formula};

impl Sample {
    /// The forces and torques of a load, each with the displacement that it works along.
    pub(super) fn load_forces<'s>(
        &self,
        scene: &'s Scene,
        plain: &State<f64>,
        load: &'s LoadKind,
    ) -> Vec<(f64, &'s Formula)> {
        match load {
            LoadKind::Force { force, at } => force.iter().zip(at).map(|(force, at)| (plain.value(force), at)).collect(),
            LoadKind::Torque { torque, angle } => vec![(plain.value(torque), angle)],
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

    /// The largest number that comes up in any load: what is left of it where terms cancel has rounding errors of that
    /// size.
    pub(super) fn largest_in_loads(&self, scene: &Scene) -> f64 {
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, &vec![0.0; self.q.len()]);
        let largest = |load: &LoadKind| match load {
            LoadKind::Force { force, .. } => {
                force.iter().map(|force| plain.largest_inside(force, [0.0; 2])).fold(0.0, f64::max)
            }
            LoadKind::Torque { torque, .. } => plain.largest_inside(torque, [0.0; 2]),
            LoadKind::Gravity(_) => 0.0,
            LoadKind::Spring { along, potential, force, friction, .. } => {
                let along = moving.value(along);
                let laws = potential.iter().chain(force).chain(friction.iter().map(|(size, _)| size));
                laws.map(|law| plain.largest_inside(law, [along.re, along.v1])).fold(0.0, f64::max)
            }
        };
        scene.loads.iter().map(|load| largest(&load.kind)).fold(0.0, f64::max)
    }

    /// What a spring has from its potential, and the rest of what acts along it.
    fn spring(&self, scene: &Scene, plain: &State<f64>, load: &LoadKind) -> [f64; 2] {
        let LoadKind::Spring { along, stiffness, rest, damping, potential, force, friction } = load else {
            return [0.0; 2];
        };
        let optional = |value: &Option<Formula>| value.as_ref().map_or(0.0, |v| plain.value(v));
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, &vec![0.0; self.q.len()]);
        let along = moving.value(along);
        let slope = potential.as_ref().map_or(0.0, |potential| {
            self.state_at(scene, Dual64::from(self.t))
                .law(potential, [Dual64::new(along.re, 1.0), Dual64::from(f64::NAN)])
                .eps
        });
        let law = |value: &Formula| plain.law(value, [along.re, along.v1]);
        let friction = friction.as_ref().map_or(0.0, |(size, slip)| law(size) * (along.v1 / plain.value(slip)).tanh());
        let loss = force.as_ref().map_or(0.0, law) - friction - optional(damping) * along.v1;
        [-optional(stiffness) * (along.re - optional(rest)) - slope, loss]
    }

    /// The generalized forces of the loads: effort times derivative of displacement.
    pub(super) fn generalized_forces(&self, gradients: &Gradients, plain: &State<f64>) -> Vec<f64> {
        let scene = gradients.scene;
        let mut forces = vec![0.0; self.q.len()];
        for (effort, displacement) in scene.loads.iter().flat_map(|load| self.load_forces(scene, plain, &load.kind)) {
            for (force, derivative) in forces.iter_mut().zip(gradients.of(displacement)) {
                *force += effort * derivative;
            }
        }
        forces
    }

    /// The potential of the loads that have one, and the power of the others.
    pub(super) fn potential_and_power(
        &self,
        gradients: &Gradients,
        plain: &State<f64>,
        x: &[(&Formula, f64)],
        equations: &Equations,
    ) -> [f64; 2] {
        let scene = gradients.scene;
        let (mut potential, mut power) = (0.0, 0.0);
        for load in &scene.loads {
            let is_constant = match &load.kind {
                LoadKind::Force { force: [x, y], .. } => vec![is_constant(x), is_constant(y)],
                LoadKind::Torque { torque, .. } => vec![is_constant(torque)],
                LoadKind::Gravity(field) => {
                    for ((at, mass), row) in x.iter().zip(&equations.rows).filter(|(_, row)| row.axis < 2) {
                        potential -= mass * plain.value(&field[row.axis]) * plain.value(at);
                    }
                    continue;
                }
                LoadKind::Spring { along, stiffness, rest, potential: own, .. } if !scene.depends_on_time(along) => {
                    let optional = |value: &Option<Formula>| value.as_ref().map_or(0.0, |v| plain.value(v));
                    let extension = plain.value(along) - optional(rest);
                    potential += 0.5 * optional(stiffness) * extension * extension;
                    potential += own.as_ref().map_or(0.0, |own| plain.law(own, [plain.value(along), f64::NAN]));
                    power += self.spring(scene, plain, &load.kind)[1] * gradients.velocity(along);
                    continue;
                }
                LoadKind::Spring { .. } => vec![false],
            };
            for ((effort, displacement), is_constant) in
                self.load_forces(scene, plain, &load.kind).into_iter().zip(is_constant)
            {
                if is_constant && !scene.depends_on_time(displacement) {
                    potential -= effort * plain.value(displacement);
                } else {
                    power += effort * gradients.velocity(displacement);
                }
            }
        }
        [potential, power]
    }
}

/// Whether a force keeps its size.
fn is_constant(value: &Formula) -> bool {
    value.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi))
}
