//! The lengths that allow a full turn.

use qrm_scene::scene::{Quantity, Scene, Value};
use qrm_sim::analysis::{MechanismWithoutDrive, can_revolve};

use crate::setup::Setup;

/// The range in which a length allows a full turn, with the limits that were found.
pub(super) struct ParameterRange {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) value: f64,
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
}

/// The search range, as a multiple of the present value, upward and downward.
const REACH: f64 = 20.0;
/// The ratio of consecutive trials.
const FACTOR: f64 = 1.25;
/// Relative accuracy of a limit.
const ACCURACY: f64 = 1e-10;

/// Finds the limits of every parameter in the constraints, with the other parameters fixed: between them the turn is
/// possible, whether it is possible now or not. The constraint of a released drive is ignored.
pub(super) fn parameter_ranges(setup: &Setup, drive: Option<usize>, turns: bool) -> Vec<ParameterRange> {
    let used = parameters_of_constraints(&setup.scene, drive);
    let values = setup.model.parameter_values(&setup.replace());
    let described = setup.description.parameters.iter().zip(values);
    let relevant = described.filter(|(p, value)| *value != 0.0 && used.iter().any(|name| name == p.name));
    let released = drive.and_then(|drive| MechanismWithoutDrive::new(setup.mechanism(), drive).ok());
    let limits = relevant.map(|(parameter, value)| {
        let replace = setup.replace();
        let turns_with = |trial: f64| {
            let replace = |name: &str| if name == parameter.name { Some(trial) } else { replace(name) };
            let mechanism = setup.model.mechanism(&replace);
            match &released {
                None => can_revolve(&*mechanism),
                Some(own) => own.with(mechanism).is_ok_and(|mechanism| can_revolve(&mechanism)),
            }
        };
        let [down, up] = [1.0 / FACTOR, FACTOR].map(|factor| limit(&turns_with, value, factor, turns));
        // If the mechanism cannot turn now, the first longer length with which it can is the lower limit.
        let (low, high) = if (value > 0.0) == turns { (down, up) } else { (up, down) };
        ParameterRange { name: parameter.name, unit: parameter.unit, value, low, high }
    });
    limits.collect()
}

/// The value at which a full turn becomes possible or impossible, searched from the present value by a factor.
fn limit(turns_with: &dyn Fn(f64) -> bool, value: f64, factor: f64, turns: bool) -> Option<f64> {
    let (mut same, mut other) = (value, value * factor);
    while turns_with(other) == turns {
        if (other / value).max(value / other) > REACH {
            return None;
        }
        (same, other) = (other, other * factor);
    }
    while (same - other).abs() > ACCURACY * same.abs() {
        let middle = 0.5 * (same + other);
        if turns_with(middle) == turns { same = middle } else { other = middle }
    }
    Some(if turns { same } else { other })
}

/// The names of parameters in the constraints, also through points and other parameters.
fn parameters_of_constraints(scene: &Scene, drive: Option<usize>) -> Vec<String> {
    let constraints = scene.constraints.iter().enumerate().filter(|(i, _)| Some(*i) != drive);
    let mut pending: Vec<&Value> = constraints.map(|(_, constraint)| &constraint.residual).collect();
    let mut points = vec![false; scene.points.len()];
    let mut found = vec![false; scene.parameters.len()];
    while let Some(value) = pending.pop() {
        for name in value.names() {
            match *name {
                Quantity::Parameter(i) if !found[i] => {
                    found[i] = true;
                    pending.push(&scene.parameters[i].formula);
                }
                Quantity::Point(i, _) if !points[i] => {
                    points[i] = true;
                    pending.extend(&scene.points[i].position);
                }
                _ => {}
            }
        }
    }
    scene.parameters.iter().zip(found).filter(|(_, found)| *found).map(|(p, _)| p.name.clone()).collect()
}
