//! Templates of the steps of a motion, identical for all mechanisms except for names.

use super::Writer;
use crate::constants::substitute;

/// The state at the start of a motion.
const INITIAL_STATE: &str = include_str!("templates/initial_state.m");
/// The mass matrix from the momenta of a large tree.
const MASS_MATRIX: &str = include_str!("templates/mass_matrix.m");
/// The equations of motion of a large tree.
const DYNAMICS: &str = include_str!("templates/dynamics.m");
/// The state for given coordinates and rates.
const STATE: &str = include_str!("templates/state.m");
/// The step of the Runge-Kutta method of order 4.
const RK4_STEP: &str = include_str!("templates/rk4_step.m");
/// The motion from the scene's start.
const MOTION: &str = include_str!("templates/motion.m");

impl Writer<'_> {
    /// The names of the templates' files, with their texts.
    pub(super) fn templates(&self) -> Vec<(&'static str, String)> {
        let steps = [("state", STATE), ("initial_state", INITIAL_STATE), ("rk4_step", RK4_STEP), ("motion", MOTION)];
        let of_tree = [("mass_matrix", MASS_MATRIX), ("dynamics", DYNAMICS)];
        let of_tree = of_tree.into_iter().filter(|_| self.program.function("momenta").is_some());
        steps.into_iter().chain(of_tree).map(|(name, template)| (name, self.named(template))).collect()
    }

    /// Fills in the constants of the projection and the names of the program.
    fn named(&self, template: &str) -> String {
        let name = &self.program.name;
        substitute(template)
            .replace("COORDINATES", &self.program.coordinates.len().to_string())
            .replace("SCENE", &name.to_uppercase())
            .replace("scene_", &format!("{name}_"))
    }
}
