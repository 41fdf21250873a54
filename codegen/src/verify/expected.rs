//! What each generated function must give at a state, straight from the scene.

use num_dual::{Dual2_64, Dual64};

use super::equations::EquationsOfMotion;
use super::gradients::Gradients;
use super::sample::Sample;
use crate::term::Equations;
use qrm_scene::evaluate::State;
use qrm_scene::scene::{OutputKind, Scene};

/// The numbers that each function must give.
pub(super) type Expected = Vec<(&'static str, Vec<f64>)>;

impl Sample {
    /// What the functions must give; `None` if the state is outside the domain of the formulae.
    pub(super) fn expected(&self, scene: &Scene, equations: &Equations) -> Option<Expected> {
        let gradients = Gradients::new(self, scene);
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let rows = self.com_rows(scene, equations, &plain);
        let EquationsOfMotion { positions, jacobian, mass, forces, residuals, constraint_jacobian } =
            EquationsOfMotion::new(self, &rows, &gradients, &plain);
        let kinetic: f64 = rows.iter().zip(&positions).map(|((_, inertia), x)| 0.5 * inertia * x.v1 * x.v1).sum();
        let constraint_rates = self.constraint_rates(scene);
        let [potential, power] = self.potential_and_power(&gradients, &plain, &rows, equations);
        let power =
            power + constraint_rates.iter().zip(&self.multipliers).map(|(rate, lambda)| rate * lambda).sum::<f64>();
        let second = |values: &[Dual2_64]| values.iter().map(|v| v.v2).collect::<Vec<f64>>();
        let first = |values: &[Dual2_64]| values.iter().map(|v| v.re).collect::<Vec<f64>>();
        let mut expected = vec![
            ("com_positions", first(&positions)),
            ("com_jacobian", jacobian.concat()),
            ("com_bias", second(&positions)),
            ("mass_matrix", mass.clone()),
            ("generalized_forces", forces.clone()),
            ("energy", vec![kinetic, potential]),
            ("power", vec![power]),
            ("outputs", self.outputs(&gradients)),
            ("dynamics.mass_matrix", mass),
            ("dynamics.generalized_forces", forces),
            ("dynamics.constraint_jacobian", constraint_jacobian.clone()),
            ("dynamics.constraint_bias", second(&residuals)),
            ("loop_constraints.residuals", first(&residuals)),
            ("loop_constraints.constraint_jacobian", constraint_jacobian.clone()),
            ("loop_constraints.constraint_rate", constraint_rates.clone()),
        ];
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
        let finite = expected.iter().all(|(_, numbers)| numbers.iter().all(|n| n.is_finite()));
        finite.then_some(expected)
    }

    /// The derivatives of the closures by time alone.
    pub(super) fn constraint_rates(&self, scene: &Scene) -> Vec<f64> {
        let state = self.state_at(scene, Dual64::new(self.t, 1.0));
        scene.constraints.iter().map(|constraint| state.value(&constraint.residual).eps).collect()
    }

    /// The state at a time, coordinates and rates held.
    pub(super) fn state_at(&self, scene: &Scene, time: Dual64) -> State<Dual64> {
        let fixed = |values: &[f64]| values.iter().map(|&value| Dual64::from(value)).collect();
        State::new(scene, &self.parameters, time, fixed(&self.q), fixed(&self.qd))
    }

    /// How closures curve along the rates while time stands still: `(C_q qd)_q qd`.
    pub(super) fn quadratic_velocity_term(&self, scene: &Scene) -> Vec<f64> {
        let moving = |(q, v): (&f64, &f64)| Dual2_64::new(*q, *v, 0.0);
        let q = self.q.iter().zip(&self.qd).map(moving).collect();
        let qd = self.qd.iter().map(|&v| Dual2_64::from(v)).collect();
        let state = State::new(scene, &self.parameters, Dual2_64::from(self.t), q, qd);
        scene.constraints.iter().map(|constraint| state.value(&constraint.residual).v2).collect()
    }

    fn outputs(&self, gradients: &Gradients) -> Vec<f64> {
        let scene = gradients.scene;
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, &self.qdd);
        let output = |kind: &OutputKind| match kind {
            OutputKind::Value(value) => plain.value(value),
            OutputKind::Rate(value) => moving.value(value).v1,
            OutputKind::SecondRate(value) => moving.value(value).v2,
            OutputKind::ReactionForce { constraint, point, along } => {
                let still = self.state_at(scene, Dual64::from(self.t));
                let [x, y] = still.point(*point);
                let [ax, ay] = [0, 1].map(|axis| Dual64::new(0.0, still.value(&along[axis]).re));
                let displaced = still.with_point(*point, [x + ax, y + ay]);
                -self.multipliers[*constraint] * displaced.value(&scene.constraints[*constraint].residual).eps
            }
            OutputKind::LoadPower(load) => {
                let load_forces = self.load_forces(scene, &plain, &scene.loads[*load].kind);
                load_forces.into_iter().map(|(effort, along)| effort * gradients.velocity(along)).sum()
            }
            OutputKind::DrivePower(k) => self.multipliers[*k] * self.constraint_rates(scene)[*k],
            OutputKind::ReactionMoment { constraint, coordinate } => {
                let mut turned = gradients.states[*coordinate].clone();
                for point in 0..scene.points.len() {
                    let held = turned.point(point).map(|c| Dual64::new(c.re, 0.0));
                    turned = turned.with_point(point, held);
                }
                -self.multipliers[*constraint] * turned.value(&scene.constraints[*constraint].residual).eps
            }
        };
        scene.outputs.iter().map(|o| output(&o.kind)).collect()
    }
}
