//! What each generated function must give at a state, straight from the scene.

use num_dual::{Dual2_64, Dual64};

use super::between;
use super::interpret::Value;
use crate::term::Equations;
use qrm_scene::evaluate::{State, constant};
use qrm_scene::scene::{OutputKind, Scene, Start, Value as Formula};

/// The numbers that each function must give.
pub(super) type Expected = Vec<(&'static str, Vec<f64>)>;

/// A random state and random parameters.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub(super) parameters: Vec<f64>,
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) qd: Vec<f64>,
    pub(super) qdd: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
}

impl Sample {
    /// Random numbers; every second time coordinates and rates near the scene's start, and nearer each time, for
    /// formulae that have a value nowhere else.
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
        }
    }

    /// The same numbers but for their last digits.
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
        }
    }

    /// The arguments of a generated function.
    pub(super) fn arguments(&self, scene: &Scene, function: &str, model: Value) -> Vec<Value> {
        let t = Value::Number(self.t);
        let (q, qd, multipliers) = (Value::list(&self.q), Value::list(&self.qd), Value::list(&self.multipliers));
        match (function.split('.').next().unwrap_or(function), scene.is_driven()) {
            ("constraint_bias", true) => vec![model, t, q, qd],
            ("constraints" | "constraint_jacobian" | "constraint_rate" | "loop_constraints", true) => vec![model, t, q],
            ("power", true) => vec![model, t, q, qd, multipliers],
            ("com_bias" | "constraint_bias" | "energy", _) => vec![model, q, qd],
            ("generalized_forces" | "power" | "dynamics", _) => vec![model, t, q, qd],
            ("outputs" | "linearization", _) => vec![model, t, q, qd, Value::list(&self.qdd), multipliers],
            _ => vec![model, q],
        }
    }

    /// What the functions must give; `None` if the state is outside the domain of the formulae.
    pub(super) fn expected(&self, scene: &Scene, equations: &Equations) -> Option<Expected> {
        let moving = State::along(scene, &self.parameters, self.t, &self.q, &self.qd, &vec![0.0; self.q.len()]);
        let plain = State::plain(scene, &self.parameters, self.t, &self.q, &self.qd);
        let x: Vec<(&Formula, f64)> = equations
            .rows
            .iter()
            .filter_map(|row| {
                let body = &scene.bodies[row.body];
                let (position, inertia) = match row.axis {
                    2 => (body.angle.as_ref(), &body.inertia),
                    axis => (body.com.as_ref().map(|com| &com[axis]), &body.mass),
                };
                Some((position?, plain.value(inertia.as_ref()?)))
            })
            .collect();
        let c: Vec<&Formula> = scene.constraints.iter().map(|c| &c.residual).collect();

        let positions: Vec<Dual2_64> = x.iter().map(|(row, _)| moving.value(row)).collect();
        let gradients = Gradients::new(self, scene);
        let jacobian: Vec<Vec<f64>> = x.iter().map(|(row, _)| gradients.of(row)).collect();
        let residuals: Vec<Dual2_64> = c.iter().map(|row| moving.value(row)).collect();
        let constraint_jacobian: Vec<f64> = c.iter().flat_map(|row| gradients.of(row)).collect();
        let n = self.q.len();
        let mut mass = vec![0.0; n * n];
        let mut forces = self.generalized(&gradients, &plain);
        for (((_, inertia), row), bias) in x.iter().zip(&jacobian).zip(&positions) {
            // Most rows move with few coordinates of a large mechanism.
            for i in (0..n).filter(|&i| row[i] != 0.0) {
                forces[i] -= inertia * row[i] * bias.v2;
                for j in 0..n {
                    mass[i * n + j] += inertia * row[i] * row[j];
                }
            }
        }
        let kinetic: f64 = x.iter().zip(&positions).map(|((_, inertia), x)| 0.5 * inertia * x.v1 * x.v1).sum();
        let constraint_rates = self.constraint_rates(scene);
        let [potential, power] = self.potential_and_power(&gradients, &plain, &x, equations);
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
        if !c.is_empty() {
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

    /// The state in which every value carries its derivative by one coordinate.
    fn by_coordinate(&self, scene: &Scene, i: usize) -> State<Dual64> {
        let dual = |(j, &q): (usize, &f64)| Dual64::new(q, f64::from(u8::from(i == j)));
        let q = self.q.iter().enumerate().map(dual).collect();
        let qd = self.qd.iter().map(|&v| Dual64::new(v, 0.0)).collect();
        State::new(scene, &self.parameters, Dual64::from(self.t), q, qd)
    }

    /// The derivatives of the closures by time alone.
    pub(super) fn constraint_rates(&self, scene: &Scene) -> Vec<f64> {
        let state = self.held(scene, Dual64::new(self.t, 1.0));
        scene.constraints.iter().map(|constraint| state.value(&constraint.residual).eps).collect()
    }

    /// The state at a time, coordinates and rates held.
    pub(super) fn held(&self, scene: &Scene, time: Dual64) -> State<Dual64> {
        let held = |values: &[f64]| values.iter().map(|&value| Dual64::from(value)).collect();
        State::new(scene, &self.parameters, time, held(&self.q), held(&self.qd))
    }

    /// How closures curve along the rates while time stands still: `(C_q qd)_q qd`.
    pub(super) fn curvature(&self, scene: &Scene) -> Vec<f64> {
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
                let still = self.held(scene, Dual64::from(self.t));
                let [x, y] = still.point(*point);
                let [ax, ay] = [0, 1].map(|axis| Dual64::new(0.0, still.value(&along[axis]).re));
                let displaced = still.with_point(*point, [x + ax, y + ay]);
                -self.multipliers[*constraint] * displaced.value(&scene.constraints[*constraint].residual).eps
            }
            OutputKind::LoadPower(load) => {
                let efforts = self.efforts(scene, &plain, &scene.loads[*load].kind);
                efforts.into_iter().map(|(effort, along)| effort * gradients.velocity(along)).sum()
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

/// Derivatives by the coordinates at a state, time and rates held.
pub(super) struct Gradients<'s> {
    pub(super) scene: &'s Scene,
    qd: &'s [f64],
    /// The state once for each coordinate by which every value in it carries its derivative.
    states: Vec<State<Dual64>>,
}

impl<'s> Gradients<'s> {
    fn new(sample: &'s Sample, scene: &'s Scene) -> Self {
        let states = (0..sample.q.len()).map(|i| sample.by_coordinate(scene, i)).collect();
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
