//! Steps of a motion: the same for all mechanisms but for names and sizes.

use super::Writer;
use crate::language::program::Part;

/// What others see of the steps.
const HEADER: &str = include_str!("rk4.h");
/// The steps of the Runge-Kutta method of order 4, with the projection.
const SOURCE: &str = include_str!("rk4.c");

impl Writer<'_> {
    /// The declarations of the steps.
    pub(super) fn step_header(&self) -> String {
        self.named(HEADER)
    }

    /// The functions of the steps.
    pub(super) fn step_source(&self) -> String {
        self.named(SOURCE)
    }

    fn named(&self, text: &str) -> String {
        let name = &self.program.name;
        text.replace("struct scene ", &format!("{} ", self.structure(Part::Mechanism)))
            .replace("scene_", &format!("{name}_"))
            .replace("SCENE_", &format!("{}_", name.to_uppercase()))
    }
}
