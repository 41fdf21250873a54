//! Writes the rows of a run to disk.

use std::io;
use std::path::{Path, PathBuf};

use qrm_sim::columns::Column;
use qrm_sim::run::{Observer, Row};

use crate::error::Error;
use crate::run_report::RunReport;
use crate::trajectory::Trajectory;

/// An observer that writes `trajectory.csv`.
pub(crate) struct Recorder {
    folder: PathBuf,
    columns: Vec<Column>,
    every: u64,
    trajectory: Option<Trajectory>,
    /// Whether the last row was not written.
    is_behind: bool,
    /// The error if nothing can be written.
    pub(crate) unusable: Option<Error>,
}

impl Recorder {
    pub(crate) fn new(folder: &Path, columns: Vec<Column>, every: u64) -> Self {
        Self { folder: folder.to_owned(), columns, every, trajectory: None, is_behind: false, unusable: None }
    }

    /// Moves the rows to their final file, and returns their number; after a failed write, the number of complete rows.
    ///
    /// Other files of an earlier run are removed, since they do not belong to the new rows.
    pub(crate) fn finish_files(&mut self, failed: bool) -> Result<u64, Error> {
        let Some(trajectory) = self.trajectory.take() else { return Ok(0) };
        let others = ["summary.json", "trajectory.units.json", "trajectory.parquet"].map(str::to_owned);
        for file in RunReport::figures_in(&self.folder).into_iter().chain(others) {
            let path = self.folder.join(file);
            match std::fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(Error::unwritable(&path, &e)),
                _ => {}
            }
        }
        trajectory.finish(failed).map_err(|e| Error::unwritable(&self.path(), &e))
    }

    fn path(&self) -> PathBuf {
        self.folder.join("trajectory.csv")
    }

    /// Creates the file at the first row: a run that cannot start leaves an earlier trajectory unchanged.
    fn open(&mut self) -> io::Result<()> {
        if self.trajectory.is_none() {
            let path = self.path();
            let created = Trajectory::create(&path, &self.columns);
            self.trajectory = Some(created.inspect_err(|e| self.unusable = Some(Error::unwritable(&path, e)))?);
        }
        Ok(())
    }
}

impl Observer for Recorder {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.is_behind = !row.index.is_multiple_of(self.every);
        if !self.is_behind {
            self.open()?;
            return self.trajectory.as_mut().map_or(Ok(()), |trajectory| trajectory.row(row.columns.iter().copied()));
        }
        Ok(())
    }

    fn keep_running(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        if let Some(trajectory) = &mut self.trajectory {
            trajectory.flush_if_due()?;
        }
        Ok(true)
    }

    fn finish(&mut self, last: &[f64]) -> io::Result<()> {
        let Some(trajectory) = &mut self.trajectory else { return Ok(()) };
        // The last row is always written.
        if self.is_behind && !last.is_empty() {
            trajectory.row(last.iter().copied())?;
        }
        trajectory.flush()
    }
}
