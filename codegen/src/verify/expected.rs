//! The expected results of each generated function at a state, computed directly from the scene.

use num_dual::{Dual, Dual2};

use super::equations::EquationsOfMotion;
use super::gradients::Gradients;
use super::sample::Sample;
use super::tree::EquationsOfTree;
use super::virtual_work::VirtualWork;
use crate::term::Equations;
use qrm_scene::evaluate::{State, constant};
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{OutputKind, Scene};

/// The expected results of each function.
pub(super) type Expected<B> = Vec<(&'static str, Vec<B>)>;

impl<B: Differentiable> Sample<B> {
    /// The expected results of the functions; `None` if the state is outside the domain of the formulae.
    pub(super) fn expected(&self, scene: &Scene, equations: &Equations) -> Option<Expected<B>> {
        let gradients = Gradients::new(self, scene);
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let rows = self.com_rows(scene, equations, &plain);
        let (given, moving) = (self.with_given_forces(scene), self.with_forces_of_motion(scene, &rows));
        let second = |values: &[Dual2<B>]| values.iter().map(|v| v.v2).collect::<Vec<B>>();
        let first = |values: &[Dual2<B>]| values.iter().map(|v| v.re).collect::<Vec<B>>();
        let mut expected = Vec::new();
        let (positions, forces, residuals, constraint_jacobian) = if equations.has_momenta() {
            let found = EquationsOfTree::new(&moving, &rows, &gradients, &plain);
            expected.extend([("com_velocities", found.velocities), ("momenta", found.momenta)]);
            (found.positions, found.forces, Vec::new(), Vec::new())
        } else {
            let found = EquationsOfMotion::new(&moving, &rows, &gradients, &plain);
            let mass = found.mass_matrix(&rows);
            expected.extend([
                ("com_jacobian", found.jacobian.concat()),
                ("mass_matrix", mass.clone()),
                ("dynamics.mass_matrix", mass),
                ("dynamics.generalized_forces", found.forces.clone()),
                ("dynamics.constraint_jacobian", found.constraint_jacobian.clone()),
                ("dynamics.constraint_bias", second(&found.residuals)),
            ]);
            (found.positions, found.forces, found.residuals, found.constraint_jacobian)
        };
        let kinetic: B = rows.iter().zip(&positions).map(|((_, inertia), x)| *inertia * x.v1 * x.v1 * 0.5).sum();
        let constraint_rates = self.constraint_rates(scene);
        let [potential, power] = given.potential_and_power(&gradients, &plain, &rows, equations);
        let power =
            power + constraint_rates.iter().zip(&self.multipliers).map(|(rate, lambda)| *rate * *lambda).sum::<B>();
        expected.extend([
            ("com_positions", first(&positions)),
            ("com_bias", second(&positions)),
            ("generalized_forces", forces),
            ("energy", vec![kinetic, potential]),
            ("power", vec![power]),
            ("outputs", given.outputs(&gradients)),
            ("loop_constraints.residuals", first(&residuals)),
            ("loop_constraints.constraint_jacobian", constraint_jacobian.clone()),
            ("loop_constraints.constraint_rate", constraint_rates.clone()),
        ]);
        if !residuals.is_empty() {
            expected.extend([
                ("constraints", first(&residuals)),
                ("constraint_jacobian", constraint_jacobian),
                ("constraint_bias", second(&residuals)),
            ]);
        }
        if scene.is_driven() {
            expected.push(("constraint_rate", constraint_rates));
        }
        if equations.linearization.is_some() {
            expected.extend(self.linearization(scene, equations));
        }
        let finite = expected.iter().all(|(_, numbers)| numbers.iter().all(|n| n.re().is_finite()));
        finite.then_some(expected)
    }

    /// The partial derivatives of the constraints with respect to time.
    pub(super) fn constraint_rates(&self, scene: &Scene) -> Vec<B> {
        let state = self.state_at(scene, Dual::new(self.t, B::from(1.0)));
        scene.constraints.iter().map(|constraint| state.value(&constraint.residual).eps).collect()
    }

    /// The state at another time, with the same coordinates and rates.
    pub(super) fn state_at(&self, scene: &Scene, time: Dual<B>) -> State<Dual<B>> {
        let fixed = |values: &[B]| values.iter().map(|&value| Dual::new(value, B::from(0.0))).collect();
        State::new(scene, &self.parameters, time, fixed(&self.q), fixed(&self.qd))
    }

    /// The curvature of the constraints along the rates at fixed time: `(C_q qd)_q qd`.
    pub(super) fn quadratic_velocity_term(&self, scene: &Scene) -> Vec<B> {
        let zero = B::from(0.0);
        let q = self.q.iter().zip(&self.qd).map(|(q, v)| Dual2::new(*q, *v, zero)).collect();
        let qd = self.qd.iter().map(|&v| Dual2::new(v, zero, zero)).collect();
        let state = State::new(scene, &self.parameters, Dual2::new(self.t, zero, zero), q, qd);
        scene.constraints.iter().map(|constraint| state.value(&constraint.residual).v2).collect()
    }

    /// The outputs for the accelerations, multipliers and normal forces of the sample, in their units.
    fn outputs(&self, gradients: &Gradients<B>) -> Vec<B> {
        let scene = gradients.scene;
        let scale = |i: usize| {
            let own = match scene.outputs[i].kind {
                OutputKind::Norm { components: [component, _], .. } => component,
                _ => i,
            };
            scene.outputs[own].scale.as_ref().map_or(B::from(1.0), |scale| constant(scale, &[]))
        };
        self.outputs_in_si(gradients).into_iter().enumerate().map(|(i, output)| output * scale(i)).collect()
    }

    /// The outputs for the accelerations, multipliers and normal forces of the sample, in SI units.
    pub(super) fn outputs_in_si(&self, gradients: &Gradients<B>) -> Vec<B> {
        let zero = B::from(0.0);
        let scene = gradients.scene;
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, &self.qdd);
        let virtual_work = VirtualWork::new(scene, self, &plain, &moving);
        let output = |kind: &OutputKind, before: &[B]| match kind {
            OutputKind::Value(value) => plain.value(value),
            OutputKind::Rate(value) => moving.value(value).v1,
            OutputKind::SecondRate(value) => moving.value(value).v2,
            OutputKind::ReactionForce { constraint, point, along } => {
                let still = self.state_at(scene, Dual::new(self.t, zero));
                let [x, y] = still.point(*point);
                let [ax, ay] = [0, 1].map(|axis| Dual::new(zero, still.value(&along[axis]).re));
                let displaced = still.with_point(*point, [x + ax, y + ay]);
                -self.multipliers[*constraint] * displaced.value(&scene.constraints[*constraint].residual).eps
            }
            OutputKind::LoadPower(load) => {
                let load_forces = self.load_forces(scene, &plain, &scene.loads[*load].kind);
                load_forces.into_iter().map(|(effort, along)| effort * gradients.velocity(along)).sum()
            }
            OutputKind::DrivePower(k) => self.multipliers[*k] * self.constraint_rates(scene)[*k],
            OutputKind::Norm { components, .. } => {
                components.map(|i| before[i] * before[i]).into_iter().sum::<B>().sqrt()
            }
            OutputKind::FreeBody { displacements, multipliers, loads } => {
                let multipliers = multipliers.iter().map(|(k, factor)| plain.value(factor) * self.multipliers[*k]);
                let force = |load: usize| -> B {
                    let forces = self.load_forces(scene, &plain, &scene.loads[load].kind).into_iter();
                    forces.map(|(effort, _)| effort).sum()
                };
                let loads = loads.iter().map(|(load, factor)| plain.value(factor) * force(*load));
                virtual_work.work(displacements) + multipliers.chain(loads).sum::<B>()
            }
            OutputKind::ShakingForce(along) => virtual_work.along_ground(along),
            OutputKind::ShakingMoment(point) => virtual_work.about_ground(*point),
            OutputKind::ReactionMoment { constraint, coordinate } => {
                let mut turned = gradients.states()[*coordinate].clone();
                for point in 0..scene.points.len() {
                    let held = turned.point(point).map(|c| Dual::new(c.re, zero));
                    turned = turned.with_point(point, held);
                }
                -self.multipliers[*constraint] * turned.value(&scene.constraints[*constraint].residual).eps
            }
        };
        scene.outputs.iter().fold(Vec::new(), |mut values, own| {
            values.push(output(&own.kind, &values));
            values
        })
    }
}
