//! Motors: loads whose torque or force falls linearly with the speed.

use num_dual::Dual2_64;
use qrm_scene::evaluate::State;
use qrm_scene::expression::Node;
use qrm_scene::scene::{LoadKind, Quantity, Value};

use crate::setup::Setup;

/// A load of the form `stall*(1 - rate/no_load)`.
struct Motor<'s> {
    name: &'s str,
    /// The torque or force.
    law: &'s Value,
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
    pub(super) fn of(setup: &'s Setup) -> Self {
        let motor = |load: &'s qrm_scene::scene::Load| {
            let (law, along) = match &load.kind {
                LoadKind::Torque { torque, angle, .. } => (torque, angle),
                LoadKind::Spring { force: Some(force), along, .. } => (force, along),
                _ => return None,
            };
            falls_linearly(law).then_some(Motor { name: &load.name, law, along })
        };
        let motors = setup.scene.loads.iter().filter_map(motor).collect();
        Self { setup, parameters: setup.parameters(), motors }
    }

    /// The names of the motors, in backquotes.
    pub(super) fn names(&self) -> Vec<String> {
        self.motors.iter().map(|motor| format!("`{}`", motor.name)).collect()
    }

    /// The work of the motors' torques at standstill, at time zero, for a displacement `dq` of the coordinates.
    pub(super) fn work(&self, q: &[f64], dq: &[f64]) -> f64 {
        if self.motors.is_empty() {
            return 0.0;
        }
        // A released drive adds a coordinate behind those of the scene.
        let count = self.setup.scene.coordinates.len();
        let (q, dq, rest) = (&q[..count], &dq[..count], vec![0.0; count]);
        let scene = &self.setup.scene;
        let moved = State::along(scene, &self.parameters, 0.0, q, dq, &rest);
        let still = State::plain(scene, &self.parameters, 0.0, q, &rest);
        let work = |motor: &Motor| {
            let along: Dual2_64 = moved.value(motor.along);
            still.law(motor.law, [along.re, 0.0]) * along.v1
        };
        self.motors.iter().map(work).sum()
    }
}

/// Whether a formula is `stall*(1 - rate/no_load)`.
fn falls_linearly(law: &Value) -> bool {
    let nodes = law.nodes();
    let Some(Node::Multiply(_, factor)) = nodes.last() else { return false };
    let Node::Subtract(one, slip) = &nodes[*factor] else { return false };
    let Node::Divide(rate, _) = &nodes[*slip] else { return false };
    matches!(&nodes[*one], Node::Number(number) if number.value == 1.0)
        && matches!(nodes[*rate], Node::Name(Quantity::StretchRate | Quantity::Rate(_)))
}
