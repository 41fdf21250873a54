//! A stop condition from the command line, evaluated as it stands.

use std::cell::RefCell;

use qrm_scene::evaluate::evaluate_in;
use qrm_scene::function::Differentiable;
use qrm_scene::resolve::read_condition;
use qrm_scene::scene::{Quantity, Scene, Value};

use crate::error::Error;

/// A condition on the names of a scene.
pub(crate) struct Condition {
    scene: Scene,
    difference: Value,
    sign: f64,
}

thread_local! {
    /// Room for the intermediate values of doubles, which are evaluated in every step.
    static ROOM: RefCell<Vec<f64>> = RefCell::default();
}

impl Condition {
    pub(crate) fn new(scene: &Scene, text: &str) -> Result<Self, Error> {
        let condition = read_condition(scene, text)?;
        Ok(Self { scene: scene.clone(), sign: condition.comparison.sign(), difference: condition.difference })
    }

    /// The function that rises through zero when the condition becomes true.
    pub(crate) fn value(&self, parameters: &[f64], t: f64, q: &[f64], qd: &[f64]) -> f64 {
        let mut room = ROOM.take();
        let value = self.value_in(&mut room, parameters, t, q, qd);
        ROOM.replace(room);
        value
    }

    /// The function of [`value`](Self::value), on numbers of any kind.
    pub(crate) fn value_in<D: Differentiable>(
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
