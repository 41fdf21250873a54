//! Takes the rows of a run to the disk.

use std::io;
use std::path::{Path, PathBuf};

use qrm_core::Description;

use crate::observer::{Observer, Row};
use crate::summary::Summary;
use crate::trajectory::{Trajectory, numbers};

/// An observer that writes `trajectory.csv`.
pub(super) struct Recorder {
    folder: PathBuf,
    description: Description,
    every: u64,
    trajectory: Option<Trajectory>,
    /// The last row, if it was not written.
    skipped: Vec<f64>,
    /// Why nothing can be written at all.
    pub(super) unusable: Option<String>,
}

impl Recorder {
    pub(super) fn new(folder: &Path, description: Description, every: u64) -> Self {
        Self { folder: folder.to_owned(), description, every, trajectory: None, skipped: Vec::new(), unusable: None }
    }

    /// Rows written; after a failed write the whole rows that are left.
    pub(super) fn rows(&mut self, failed: bool) -> u64 {
        match self.trajectory.take() {
            Some(trajectory) if failed => trajectory.cut(&self.folder.join("trajectory.csv")).unwrap_or(0),
            Some(trajectory) => trajectory.rows,
            None => 0,
        }
    }

    /// Makes the folder, and removes what else an earlier run left there: it would not belong to the new rows.
    fn prepare(&self) -> io::Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        let others = ["summary.json", "trajectory.units.json", "trajectory.parquet"].map(str::to_owned);
        for file in Summary::figures_of(&self.folder).into_iter().chain(others) {
            match std::fs::remove_file(self.folder.join(file)) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
                _ => {}
            }
        }
        Ok(())
    }

    /// The file is made with the first row: a run that cannot start leaves an earlier trajectory alone.
    fn trajectory(&mut self) -> io::Result<&mut Trajectory> {
        if self.trajectory.is_none() {
            let path = self.folder.join("trajectory.csv");
            let created = self.prepare().and_then(|()| Trajectory::create(&path, &self.description));
            match created {
                Ok(trajectory) => self.trajectory = Some(trajectory),
                Err(e) => {
                    self.unusable = Some(super::unwritable(&path, &e));
                    return Err(e);
                }
            }
        }
        self.trajectory.as_mut().ok_or_else(|| io::Error::other("no trajectory"))
    }
}

impl Observer for Recorder {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.skipped.clear();
        if row.index.is_multiple_of(self.every) {
            return self.trajectory()?.row(numbers(row));
        }
        self.skipped.extend(numbers(row));
        Ok(())
    }

    fn goes_on(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        if let Some(trajectory) = &mut self.trajectory {
            trajectory.settle()?;
        }
        Ok(true)
    }

    fn finish(&mut self) -> io::Result<()> {
        let Some(trajectory) = &mut self.trajectory else { return Ok(()) };
        // The last row is written even if it is not its turn.
        if !self.skipped.is_empty() {
            trajectory.row(self.skipped.drain(..))?;
        }
        trajectory.flush()
    }
}
