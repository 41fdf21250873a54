//! A stop condition from the command line, evaluated as it stands.

use std::cell::RefCell;

use qrm_scene::evaluate::evaluate_in;
use qrm_scene::function::Differentiable;
use qrm_scene::resolve::read_condition;
use qrm_scene::scene::{Quantity, Scene, Value};

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
        let value = self.value_in(&mut room, &self.parameters, t, q, qd);
        self.room.replace(room);
        value
    }

    /// The same with numbers of any kind.
    pub(super) fn value_in<D: Differentiable>(
        &self,
        room: &mut Vec<D>,
        parameters: &[D],
        t: D,
        q: &[D],
        qd: &[D],
    ) -> D {
        let known = (parameters, t, q, qd);
        evaluate_in(room, &self.difference, &mut |quantity| self.quantity(*quantity, known)) * D::from(self.sign)
    }

    fn quantity<D: Differentiable>(&self, quantity: Quantity, known: (&[D], D, &[D], &[D])) -> D {
        let (parameters, t, q, qd) = known;
        match quantity {
            Quantity::Parameter(i) => parameters[i],
            Quantity::Coordinate(i) => q[i],
            Quantity::Rate(i) => qd[i],
            Quantity::Time => t,
            Quantity::Pi => D::from(std::f64::consts::PI),
            Quantity::Point(point, axis) => {
                let position = &self.scene.points[point].position[axis];
                evaluate_in(&mut Vec::new(), position, &mut |inner| self.quantity(*inner, known))
            }
            // `read_condition` lets none through.
            Quantity::PointRate(..) | Quantity::Stretch | Quantity::StretchRate | Quantity::Unknown => {
                D::from(f64::NAN)
            }
        }
    }
}
