//! A stop condition from the command line, for each design with its own parameters.

use qrm_scene::evaluate::{evaluate_in, parameter_values};
use qrm_scene::resolve::read_condition;
use qrm_scene::scene::{Quantity, Scene, Value};

use super::super::Failure;
use crate::scenes::Replace;

/// A condition on the names of a scene.
pub(super) struct Stop {
    scene: Scene,
    difference: Value,
    sign: f64,
}

/// The same for some designs.
pub(super) struct Stops<'s> {
    stop: &'s Stop,
    parameters: Vec<Vec<f64>>,
}

impl Stop {
    pub(super) fn new(scene: &Scene, text: &str) -> Result<Self, Failure> {
        let condition = read_condition(scene, text).map_err(|report| Failure::Use(report.to_string()))?;
        Ok(Self { scene: scene.clone(), sign: condition.comparison.sign(), difference: condition.difference })
    }

    pub(super) fn of_designs(&self, designs: &[Replace]) -> Stops<'_> {
        let parameters = designs.iter().map(|replace| parameter_values(&self.scene, replace)).collect();
        Stops { stop: self, parameters }
    }
}

impl Stops<'_> {
    /// Rises through zero when the condition of a design becomes true.
    pub(super) fn value(&self, design: usize, t: f64, q: &[f64], qd: &[f64]) -> f64 {
        let quantity = |quantity: &Quantity| self.quantity(*quantity, design, t, q, qd);
        self.stop.sign * evaluate_in(&mut Vec::new(), &self.stop.difference, &mut |name| quantity(name))
    }

    fn quantity(&self, quantity: Quantity, design: usize, t: f64, q: &[f64], qd: &[f64]) -> f64 {
        match quantity {
            Quantity::Parameter(i) => self.parameters[design][i],
            Quantity::Coordinate(i) => q[i],
            Quantity::Rate(i) => qd[i],
            Quantity::Time => t,
            Quantity::Pi => std::f64::consts::PI,
            Quantity::Point(point, axis) => {
                let position = &self.stop.scene.points[point].position[axis];
                evaluate_in(&mut Vec::new(), position, &mut |inner| self.quantity(*inner, design, t, q, qd))
            }
            // `read_condition` lets none through.
            Quantity::PointRate(..) | Quantity::Stretch | Quantity::StretchRate | Quantity::Unknown => f64::NAN,
        }
    }
}
