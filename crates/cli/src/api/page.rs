//! Pages that show the mechanism moving.

use super::options::RunOptions;
use super::scene::LoadedScene;
use crate::commands::{animate, page};
use crate::error::Error;

impl LoadedScene {
    /// Creates a page that simulates the scene in any browser, with a slider for each parameter: `qrm page`.
    ///
    /// # Errors
    /// A part of the page cannot be created.
    pub fn page(&self) -> Result<String, Error> {
        page::page(&self.found(), &self.path().display().to_string())
    }

    /// Creates a page that plays a run: `qrm animate`.
    ///
    /// # Errors
    /// The run cannot begin, fails, or cannot be drawn.
    pub fn animation(&self, options: &RunOptions) -> Result<String, Error> {
        let setup = self.setup(options)?;
        let (motion, report) = animate::animation(&setup)?;
        report.problem().map_or_else(|| Ok(qrm_view::animation::page(&motion)), Err)
    }
}
