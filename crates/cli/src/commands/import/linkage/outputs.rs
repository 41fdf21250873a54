//! Outputs and loads that models of several formats have.

use super::super::names::Names;
use super::super::plane::{Plane, Vector};
use super::{ImportedLinkage, Load};

impl ImportedLinkage {
    /// Adds the force of each joint as an output, if the linkage has masses.
    pub(in super::super) fn add_joint_forces(&mut self, names: &mut Names) {
        if self.links.iter().all(|link| link.mass.is_none()) {
            return;
        }
        for joint in self.joints.iter().filter(|joint| joint.has_force()) {
            let name = names.unique(&format!("F_{}", joint.name), "force");
            self.outputs.push((name, format!("{{ joint = \"{}\" }}", joint.name)));
        }
    }

    /// Adds the force or torque of the drive of a joint as an output.
    pub(in super::super) fn add_drive_force(&mut self, joint: usize, names: &mut Names) {
        let joint = &self.joints[joint].name;
        let name = names.unique(&format!("T_{joint}"), "drive");
        self.outputs.push((name, format!("{{ drive = \"{joint}\" }}")));
    }

    /// Adds both coordinates of a point as outputs.
    pub(in super::super) fn trace_point(&mut self, point: &str, names: &mut Names) {
        for axis in ["x", "y"] {
            let name = names.unique(&format!("{axis}_{point}"), "place");
            self.outputs.push((name, format!("{{ value = '{point}.{axis}', unit = \"m\" }}")));
        }
    }

    /// Adds gravity as the first load, by its part in the plane.
    pub(in super::super) fn add_gravity(&mut self, gravity: Vector, plane: &Plane) {
        let flat = plane.project(gravity);
        if flat != [0.0; 2] {
            self.loads.insert(0, Load::Gravity(flat));
        }
        if gravity != [0.0; 3] && !plane.contains(gravity) {
            self.left_out.push("gravity across the plane, which joints carry".to_owned());
        }
    }
}
