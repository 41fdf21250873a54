//! Takes the rows of a run to the disk and to the summary, and shows that it goes on.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use qrm_mechanism::Description;

use crate::extremes::Tracker;
use crate::observer::{Observer, Row};
use crate::summary::{ExtremesEntry, Named};
use crate::trajectory::{CHECKS, Trajectory, columns, numbers};

/// How long a run goes on in silence before it shows its progress.
const SILENCE: Duration = Duration::from_millis(300);

/// Set when the user wants the run to end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// An observer that writes `trajectory.csv` and notes extremes.
pub(super) struct Recorder {
    folder: PathBuf,
    description: Description,
    every: u64,
    trajectory: Option<Trajectory>,
    trackers: Vec<Tracker>,
    /// The last row, if it was not written.
    skipped: Vec<f64>,
    begun: Instant,
    bar: Option<ProgressBar>,
    /// Why nothing can be written at all.
    pub(super) unusable: Option<String>,
}

impl Recorder {
    pub(super) fn new(folder: &Path, description: Description, every: u64) -> Self {
        // A second handler in one process is refused; the first one does.
        let _ = ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed));
        Self {
            folder: folder.to_owned(),
            trackers: vec![Tracker::default(); columns(&description).len() - CHECKS],
            description,
            every,
            trajectory: None,
            skipped: Vec::new(),
            begun: Instant::now(),
            bar: None,
            unusable: None,
        }
    }

    /// Rows written; after a failed write the whole rows that are left.
    pub(super) fn rows(&mut self, failed: bool) -> u64 {
        match self.trajectory.take() {
            Some(trajectory) if failed => trajectory.cut(&self.folder.join("trajectory.csv")).unwrap_or(0),
            Some(trajectory) => trajectory.rows,
            None => 0,
        }
    }

    /// Extremes of every column that the motion makes vary.
    pub(super) fn extremes(&self) -> Named<ExtremesEntry> {
        let columns = columns(&self.description).into_iter().zip(&self.trackers).skip(1);
        let entry = |(name, tracker): (String, &Tracker)| {
            let e = tracker.finish()?;
            let (min, min_time) = e.minimum;
            let (max, max_time) = e.maximum;
            Some((name, ExtremesEntry { min, min_time, max, max_time }))
        };
        Named(columns.filter_map(entry).collect())
    }

    /// Makes the folder, and removes the summary of an earlier run: it would not belong to the new rows.
    fn prepare(&self) -> io::Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        match std::fs::remove_file(self.folder.join("summary.json")) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
            _ => Ok(()),
        }
    }

    /// The file is made with the first row: a run that cannot start leaves an earlier trajectory alone.
    fn trajectory(&mut self) -> io::Result<&mut Trajectory> {
        if self.trajectory.is_none() {
            let path = self.folder.join("trajectory.csv");
            let created = self.prepare().and_then(|()| Trajectory::create(&path, &self.description));
            match created {
                Ok(trajectory) => self.trajectory = Some(trajectory),
                Err(e) => {
                    let help = "choose another folder with --out DIR";
                    self.unusable = Some(format!("error: cannot write {}: {e}\n  = help: {help}", path.display()));
                    return Err(e);
                }
            }
        }
        self.trajectory.as_mut().ok_or_else(|| io::Error::other("no trajectory"))
    }
}

impl Observer for Recorder {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        for (tracker, number) in self.trackers.iter_mut().zip(numbers(row)) {
            tracker.row(row.t, number);
        }
        self.skipped.clear();
        if row.index.is_multiple_of(self.every) {
            return self.trajectory()?.row(numbers(row));
        }
        self.skipped.extend(numbers(row));
        Ok(())
    }

    fn goes_on(&mut self, t: f64, end_time: f64) -> io::Result<bool> {
        if self.bar.is_none() && self.begun.elapsed() > SILENCE && io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{bar:40} t = {msg} s, {eta} left").map_err(io::Error::other)?;
            self.bar = Some(ProgressBar::new(10_000).with_style(style));
        }
        if let Some(bar) = &self.bar {
            bar.set_position((1e4 * t / end_time) as u64);
            bar.set_message(format!("{t:.3} of {end_time:.3}"));
        }
        if let Some(trajectory) = &mut self.trajectory {
            trajectory.settle()?;
        }
        Ok(!INTERRUPTED.load(Ordering::Relaxed))
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

impl Drop for Recorder {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
