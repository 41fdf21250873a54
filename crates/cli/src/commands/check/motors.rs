//! Motors: loads whose torque or force falls linearly with the speed.

use num_dual::Dual2_64;
use qrm_scene::evaluate::{State, evaluate_in};
use qrm_scene::expression::{Node, NodeId};
use qrm_scene::scene::{Load, LoadKind, Quantity, Value};

use crate::setup::Setup;

/// A load with a term of the form `stall*(1 - rate/no_load)`.
struct Motor<'s> {
    name: &'s str,
    /// The torque or force.
    law: &'s Value,
    /// The terms of this form.
    terms: Vec<NodeId>,
    /// The angle or length that it works on.
    along: &'s Value,
}

/// The motors of a scene.
pub(super) struct Motors<'s> {
    setup: &'s Setup,
    parameters: Vec<f64>,
    motors: Vec<Motor<'s>>,
}

impl<'s> Motors<'s> {
    /// Finds the motors of a scene.
    pub(super) fn new(setup: &'s Setup) -> Self {
        let motor = |load: &'s Load| {
            let (law, along) = match &load.kind {
                LoadKind::Torque { torque, angle, .. } => (torque, angle),
                LoadKind::Spring { force: Some(force), along, .. } => (force, along),
                _ => return None,
            };
            let terms = falling_terms(law, along);
            (!terms.is_empty()).then_some(Motor { name: &load.name, law, terms, along })
        };
        let motors = setup.scene.loads.iter().filter_map(motor).collect();
        Self { setup, parameters: setup.parameters(), motors }
    }

    /// The words that leave the motors out of all loads; empty without motors.
    pub(super) fn left_out(&self) -> String {
        let names: Vec<String> = self.motors.iter().map(|motor| format!("`{}`", motor.name)).collect();
        if names.is_empty() { String::new() } else { format!(" other than {}", names.join(", ")) }
    }

    /// The work of the motors' torques at standstill, at time zero, for a displacement `dq` of the coordinates.
    pub(super) fn work(&self, q: &[f64], dq: &[f64]) -> f64 {
        if self.motors.is_empty() {
            return 0.0;
        }
        let scene = &self.setup.scene;
        // A released drive adds a coordinate behind those of the scene.
        let count = scene.coordinates.len();
        let (q, dq, rest) = (&q[..count], &dq[..count], vec![0.0; count]);
        let moved = State::along(scene, &self.parameters, 0.0, q, dq, &rest);
        let still = State::plain(scene, &self.parameters, 0.0, q, &rest);
        let work = |motor: &Motor| {
            let along: Dual2_64 = moved.value(motor.along);
            let mut values = Vec::new();
            evaluate_in(&mut values, motor.law, &mut |quantity: &Quantity| match quantity {
                Quantity::Stretch => along.re,
                Quantity::StretchRate => 0.0,
                other => still.quantity(*other),
            });
            motor.terms.iter().map(|term| values[*term]).sum::<f64>() * along.v1
        };
        self.motors.iter().map(work).sum()
    }
}

/// The terms `stall*(1 - rate/no_load)` of a sum, with the rate of the angle or length that the load acts along.
fn falling_terms(law: &Value, along: &Value) -> Vec<NodeId> {
    let nodes = law.nodes();
    let is_own_rate = |id: NodeId| match (&nodes[id], along.nodes()) {
        (Node::Name(Quantity::StretchRate), _) => true,
        (Node::Name(Quantity::Rate(i)), [Node::Name(Quantity::Coordinate(j))]) => i == j,
        _ => false,
    };
    let is_one = |id: NodeId| matches!(&nodes[id], Node::Number(number) if number.value == 1.0);
    let falls = |id: NodeId| match &nodes[id] {
        Node::Subtract(one, slip) if is_one(*one) => {
            matches!(&nodes[*slip], Node::Divide(rate, _) if is_own_rate(*rate))
        }
        _ => false,
    };
    let (mut found, mut pending) = (Vec::new(), vec![nodes.len() - 1]);
    while let Some(id) = pending.pop() {
        match &nodes[id] {
            Node::Add(a, b) => pending.extend([*a, *b]),
            Node::Subtract(a, _) => pending.push(*a),
            Node::Multiply(a, b) if falls(*a) || falls(*b) => found.push(id),
            _ => {}
        }
    }
    found
}
