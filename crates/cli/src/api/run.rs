//! A run whose rows are kept in memory.

use std::io;

use qrm_pictures::Recording;
use qrm_sim::columns::{Column, columns};
use qrm_sim::run::{Observer, Row};

use super::options::RunOptions;
use super::scene::LoadedScene;
use crate::error::Error;
use crate::memory::has_room;
use crate::progress::interrupted;
use crate::run_report::RunReport;

/// The result of a run that began.
#[derive(Debug)]
pub struct Run {
    /// The columns of its rows.
    pub columns: Vec<Column>,
    /// The numbers, row by row.
    pub values: Vec<f64>,
    /// The text of `summary.json`.
    pub summary: String,
    /// The warnings about the run, with their hints.
    pub warnings: Vec<String>,
    /// The reason why it failed or cannot be trusted.
    pub problem: Option<Error>,
}

impl LoadedScene {
    /// Runs the scene: `qrm run`.
    ///
    /// # Errors
    /// The run cannot begin. A run that began is returned, with its problem if there is one.
    pub fn run(&self, options: &RunOptions, every: u64, estimate_error: bool) -> Result<Run, Error> {
        let setup = self.setup(options)?;
        // Warnings about joints that open need the multipliers over time.
        let has_one_sided = setup.scene.constraints.iter().any(|joint| joint.one_sided.is_some());
        let recording = if has_one_sided { Recording::new } else { Recording::for_extremes };
        let mut observer = (Table::new(every), recording(setup.description));
        let outcome = setup.simulate(estimate_error, &mut observer)?;
        let (table, recording) = observer;
        Run::new(columns(setup.description), table, RunReport::new(&setup, &outcome, &recording))
    }
}

impl Run {
    /// The run whose rows are kept in a table.
    pub(super) fn new(columns: Vec<Column>, table: Table, mut report: RunReport) -> Result<Self, Error> {
        report.rows = (table.values.len() / columns.len()) as u64;
        Ok(Self {
            columns,
            values: table.values,
            summary: serde_json::to_string(&report)?,
            warnings: report.warnings.iter().map(ToString::to_string).collect(),
            problem: report.problem(),
        })
    }
}

/// The initial capacity in rows.
const ROWS: usize = 2048;

/// An observer that keeps rows.
pub(super) struct Table {
    values: Vec<f64>,
    every: u64,
    /// Whether the last row was not kept.
    is_behind: bool,
}

impl Table {
    pub(super) fn new(every: u64) -> Self {
        Self { values: Vec::new(), every: every.max(1), is_behind: false }
    }

    fn push(&mut self, row: &[f64]) -> io::Result<()> {
        let values = &mut self.values;
        if values.capacity() - values.len() < row.len() {
            let more = values.len().max(ROWS * row.len());
            if !has_room(size_of::<f64>() * more) {
                return Err(io::ErrorKind::OutOfMemory.into());
            }
            values.try_reserve(more)?;
        }
        values.extend_from_slice(row);
        Ok(())
    }
}

impl Observer for Table {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.is_behind = !row.index.is_multiple_of(self.every);
        if !self.is_behind {
            self.push(row.columns)?;
        }
        Ok(())
    }

    fn keep_running(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(!interrupted())
    }

    fn finish(&mut self, last: &[f64]) -> io::Result<()> {
        // The last row is always kept.
        if self.is_behind {
            self.push(last)?;
        }
        Ok(())
    }
}
