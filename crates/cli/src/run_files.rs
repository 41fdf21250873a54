//! The files of a run: trajectory, units of its columns, figures.

use std::path::{Path, PathBuf};

use qrm_pictures::Recording;
use qrm_sim::columns::columns;
use qrm_sim::run::{Outcome, Status};
use qrm_view::figure::Figure;

use crate::columns::write_units;
use crate::error::{Error, Message};
use crate::output::{check_target, save};
use crate::parquet;
use crate::pictures::figures;
use crate::plots::Plots;
use crate::progress::Progress;
use crate::recorder::Recorder;
use crate::run_report::RunReport;
use crate::setup::Setup;

/// The files to write.
pub(crate) struct RunFiles<'a> {
    pub(crate) folder: &'a Path,
    /// The number of rows of which one is written.
    pub(crate) every: u64,
    pub(crate) has_figures: bool,
    pub(crate) parquet: bool,
}

/// A run whose files are written.
pub(crate) struct FinishedRun {
    pub(crate) outcome: Outcome,
    pub(crate) recording: Recording,
    pub(crate) report: RunReport,
    /// The tables next to `trajectory.csv`.
    pub(crate) tables: Vec<String>,
    pub(crate) problems: Vec<Error>,
}

impl RunFiles<'_> {
    /// Returns an error if a file cannot be written.
    pub(crate) fn check_targets(&self) -> Result<(), Error> {
        let files = ["trajectory.csv", "trajectory.parquet", "trajectory.units.json", "summary.json"];
        files.iter().try_for_each(|file| check_target(&self.folder.join(file)))
    }

    /// Runs a scene and writes the files.
    pub(crate) fn run(&self, setup: &Setup, estimate_error: bool, plots: Plots) -> Result<FinishedRun, Error> {
        let recorder = Recorder::new(self.folder, columns(setup.description), self.every);
        let mut observer = (Progress::new(), (recorder, (Recording::new(setup.description), plots)));
        let outcome = setup.simulate(estimate_error, &mut observer)?;
        let (_, (mut recorder, (recording, plots))) = observer;
        if let Some(error) = recorder.unusable.take() {
            return Err(error);
        }
        let mut report = RunReport::new(setup, &outcome, &recording);
        let mut problems: Vec<Error> = report.problem().into_iter().collect();
        match recorder.finish_files(matches!(outcome.status, Status::Unwritable(_))) {
            Ok(rows) => report.rows = rows,
            Err(e) => problems.push(e),
        }
        // A curve needs two rows.
        if self.has_figures && report.rows > 1 {
            let mut figures = figures(setup, &outcome, &recording);
            figures.extend(plots.figures(&recording));
            problems.extend(self.draw(figures, &mut report));
        }
        let mut tables = Vec::new();
        if report.rows > 0 {
            self.write_tables(&recording).map_or_else(|e| problems.push(e), |paths| tables.extend(paths));
        }
        Ok(FinishedRun { outcome, recording, report, tables, problems })
    }

    /// Writes the units of the columns and, if requested, the trajectory in Parquet; returns the tables.
    fn write_tables(&self, recording: &Recording) -> Result<Vec<String>, Error> {
        let table = self.folder.join("trajectory.csv");
        let columns: Vec<_> = recording.columns().cloned().collect();
        write_units(&table, &columns)?;
        if !self.parquet {
            return Ok(Vec::new());
        }
        let path: PathBuf = self.folder.join("trajectory.parquet");
        parquet::copy(&table, &path, |_| parquet::Kind::Number).map_err(|e| Error::unwritable(&path, &e))?;
        Ok(vec![path.display().to_string()])
    }

    /// Draws the figures of a run and lists them in its report.
    fn draw(&self, figures: Vec<(String, Figure)>, report: &mut RunReport) -> Vec<Error> {
        let mut problems = Vec::new();
        for (name, figure) in figures {
            let file = format!("figures/{name}.svg");
            match figure.svg() {
                Ok(svg) => match save(&self.folder.join(&file), svg.as_bytes()) {
                    Ok(()) => report.figures.push(file),
                    Err(e) => problems.push(e),
                },
                Err(reason) => report.warnings.push(Message::new(format!("{file} cannot be drawn: {reason}"))),
            }
        }
        problems
    }
}
