//! Actuators of a mechanism: given coordinates, or drives of the scene.

use qrm_core::Mechanism;
use qrm_sim::analysis::PrescribedState;
use qrm_sim::solve::LoopConstraints;

use crate::setup::Setup;

/// The forces and torques of all drives.
pub(super) struct Actuators {
    /// All actuators.
    pub(super) all: Vec<Actuator>,
}

/// A force or torque.
pub(super) struct Actuator {
    /// The name of its column.
    pub(super) name: String,
    /// The unit, N m or N.
    pub(super) unit: &'static str,
    source: Source,
}

enum Source {
    Coordinate(usize),
    Constraint(usize),
}

impl Actuators {
    pub(super) fn new(setup: &Setup, given: &[bool]) -> Self {
        let scene = &setup.scene;
        let kind = |is_angle: bool| if is_angle { ("torque", "N m") } else { ("force", "N") };
        let coordinate = |i: usize| {
            let (what, unit) = kind(scene.coordinates[i].unit == "rad");
            Actuator { name: format!("{what}_{}", scene.coordinates[i].name), unit, source: Source::Coordinate(i) }
        };
        // A drive acts along its residual, for any form of residual.
        let drive = |k: usize| {
            let (what, unit) = match scene.constraints[k].unit.as_str() {
                "rad" => kind(true),
                "m" => kind(false),
                _ => ("drive", ""),
            };
            Actuator { name: format!("{what}_{}", scene.constraints[k].name), unit, source: Source::Constraint(k) }
        };
        let coordinates = (0..given.len()).filter(|&i| given[i]).map(coordinate);
        let drives = scene.drives().into_iter().map(drive);
        Self { all: coordinates.chain(drives).collect() }
    }

    /// The forces and torques at a state.
    pub(super) fn forces(&self, state: &PrescribedState) -> Vec<f64> {
        let force = |own: &Actuator| match own.source {
            Source::Coordinate(i) => state.forces[i],
            // The force of a constraint acts towards smaller residuals.
            Source::Constraint(k) => -state.multipliers[k],
        };
        self.all.iter().map(force).collect()
    }

    /// The power supplied to the mechanism: force times rate, and `lambda' C_t` of drives.
    pub(super) fn power(&self, mechanism: &dyn Mechanism, state: &PrescribedState) -> f64 {
        let along = |own: &Actuator| match own.source {
            Source::Coordinate(i) => state.forces[i] * state.qd[i],
            Source::Constraint(_) => 0.0,
        };
        let constraints = LoopConstraints::at(mechanism, state.t, &state.q);
        let of_drives = state.multipliers.iter().zip(&constraints.constraint_rate).map(|(lambda, rate)| lambda * rate);
        self.all.iter().map(along).sum::<f64>() + of_drives.sum::<f64>()
    }
}
