//! A steady motion and its period as a run.

use qrm_pictures::Recording;
use qrm_sim::columns::columns;

use super::options::RunOptions;
use super::run::{Run, Table};
use super::scene::LoadedScene;
use crate::commands::steady::{SearchOptions, SteadyReport, method_options};
use crate::error::Error;
use crate::run_report::RunReport;
use crate::setup::Setup;

/// The options of a search for a steady motion.
#[derive(Clone, Debug)]
pub struct SteadyOptions {
    /// The options of the run, without those of its end.
    pub run: RunOptions,
    /// The period of loads and drives, in s.
    pub period: Option<String>,
    /// The coordinate that tells cycles.
    pub phase: Option<String>,
    /// The number of cycles in a period.
    pub cycles: u32,
    /// The number of periods before the search.
    pub settle: u32,
    /// The number of rows in a period.
    pub rows: u32,
    /// A parameter and a condition that it is to meet.
    pub solve: Option<(String, String)>,
}

impl LoadedScene {
    /// Finds a steady motion: `qrm steady`. Returns the text of `steady.json`, and a run over the period.
    ///
    /// # Errors
    /// No steady motion exists, or the search does not find it.
    pub fn steady(&self, options: &SteadyOptions) -> Result<(String, Run), Error> {
        let (scene, start, how) = options.run.parsed()?;
        let how = method_options(&how)?;
        let mut setup = Setup::from_found(self.found(), &scene, &how)?.starting_from(&start)?;
        let SteadyOptions { period, phase, cycles, settle, rows, solve, .. } = options.clone();
        let (solve, condition) = solve.unzip();
        let found = SearchOptions { period, phase, cycles, settle, solve, condition, rows }.find(&mut setup)?;
        let mut observer = (Table::new(1), Recording::new(setup.description));
        let outcome = setup.simulate(true, &mut observer)?;
        let (table, recording) = observer;
        let steady = serde_json::to_string(&SteadyReport::new(&setup, found, &recording, &outcome))?;
        Ok((steady, Run::new(columns(setup.description), table, RunReport::new(&setup, &outcome, &recording))?))
    }
}
