//! Modes and linear models.

use super::options::RunOptions;
use super::scene::LoadedScene;
use crate::commands::{linearize, modes};
use crate::error::Error;

impl LoadedScene {
    /// Finds equilibria and modes: the contents of `modes.json`. `at` has values of given coordinates, such as
    /// `phi=30deg`.
    ///
    /// # Errors
    /// An option is invalid, or there is no equilibrium.
    pub fn modes(&self, options: &RunOptions, at: &[String], others: bool) -> Result<String, Error> {
        modes::json(&self.setup(options)?, at, others)
    }

    /// Makes a linear model about an equilibrium: the contents of `linear.json`.
    ///
    /// # Errors
    /// An option is invalid, or there is no equilibrium.
    pub fn linearize(
        &self,
        options: &RunOptions,
        at: &[String],
        inputs: &[String],
        outputs: &[String],
    ) -> Result<String, Error> {
        linearize::json(&self.setup(options)?, at, inputs, outputs)
    }
}
