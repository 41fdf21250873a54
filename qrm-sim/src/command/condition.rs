//! A stop condition from the command line, evaluated as it stands.

use std::cell::RefCell;

use qrm_codegen::evaluate::evaluate_in;
use qrm_codegen::resolve::read_condition;
use qrm_codegen::scene::{Quantity, Scene, Value};

use super::Failure;

/// A condition on the names of a scene.
pub(super) struct Condition {
    scene: Scene,
    parameters: Vec<f64>,
    difference: Value,
    sign: f64,
    room: RefCell<Vec<f64>>,
}

impl Condition {
    pub(super) fn new(scene: &Scene, text: &str, parameters: Vec<f64>) -> Result<Self, Failure> {
        let condition = read_condition(scene, text).map_err(|report| Failure::Use(report.to_string()))?;
        Ok(Self {
            scene: scene.clone(),
            parameters,
            sign: condition.comparison.sign(),
            difference: condition.difference,
            room: RefCell::default(),
        })
    }

    /// Rises through zero when the condition becomes true.
    pub(super) fn value(&self, t: f64, q: &[f64], qd: &[f64]) -> f64 {
        let mut room = self.room.take();
        let value = evaluate_in(&mut room, &self.difference, &mut |quantity| self.quantity(*quantity, t, q, qd));
        self.room.replace(room);
        self.sign * value
    }

    fn quantity(&self, quantity: Quantity, t: f64, q: &[f64], qd: &[f64]) -> f64 {
        match quantity {
            Quantity::Parameter(i) => self.parameters[i],
            Quantity::Coordinate(i) => q[i],
            Quantity::Rate(i) => qd[i],
            Quantity::Time => t,
            Quantity::Pi => std::f64::consts::PI,
            Quantity::Point(point, axis) => {
                let position = &self.scene.points[point].position[axis];
                evaluate_in(&mut Vec::new(), position, &mut |inner| self.quantity(*inner, t, q, qd))
            }
            // `read_condition` lets none through.
            Quantity::PointRate(..) | Quantity::Stretch | Quantity::StretchRate | Quantity::Unknown => f64::NAN,
        }
    }
}
