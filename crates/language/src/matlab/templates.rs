//! Templates of the steps of a motion, identical for all mechanisms except for names.

use super::Writer;
use crate::constants::substitute;

/// The state at the start of a motion.
const INITIAL_STATE: &str = include_str!("templates/initial_state.m");
/// The state for given coordinates and rates.
const STATE: &str = include_str!("templates/state.m");
/// The step of the Runge-Kutta method of order 4.
const RK4_STEP: &str = include_str!("templates/rk4_step.m");
/// The motion from the scene's start.
const MOTION: &str = include_str!("templates/motion.m");

impl Writer<'_> {
    /// The names of the templates' files, with their texts.
    pub(super) fn templates(&self) -> [(&'static str, String); 4] {
        [("state", STATE), ("initial_state", INITIAL_STATE), ("rk4_step", RK4_STEP), ("motion", MOTION)]
            .map(|(name, template)| (name, self.named(template)))
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
