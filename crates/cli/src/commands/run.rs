//! `qrm run`

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use qrm_core::Model;
use qrm_sim::columns::columns;
use qrm_sim::run::Status;
use qrm_view::figure::Figure;

use crate::columns::write_units;
use crate::error::{Error, Message};
use crate::options::{MethodOptions, OutFolder, PlotOptions, SceneOptions, StartOptions};
use crate::output::{check_target, print, save, save_json};
use crate::parquet;
use crate::pictures::figures;
use crate::plots::Plots;
use crate::progress::Progress;
use crate::recorder::Recorder;
use crate::run_report::RunReport;
use crate::setup::Setup;
use qrm_pictures::Recording;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    start: StartOptions,
    #[command(flatten)]
    method: MethodOptions,
    /// Write every Nth row only; the last row is always written
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Skip the runs with other steps that estimate the error
    #[arg(long)]
    no_error_estimate: bool,
    /// Draw no figures
    #[arg(long, conflicts_with = "plot")]
    no_figures: bool,
    #[command(flatten)]
    plots: PlotOptions,
    /// Write trajectory.parquet too (programs with the feature `parquet`)
    #[arg(long)]
    parquet: bool,
    #[command(flatten)]
    out: OutFolder,
}

/// Runs a scene and writes its files.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let begun = Instant::now();
    if options.parquet {
        parquet::require()?;
    }
    let setup = Setup::from_found(options.scene.name.find(models)?, &options.scene, &options.method)?
        .starting_from(&options.start)?;
    let plots = Plots::new(&setup, &options.plots)?;
    let out = options.out.folder(&setup.path);
    for file in ["trajectory.csv", "trajectory.parquet", "trajectory.units.json", "summary.json"] {
        check_target(&out.join(file))?;
    }
    let recorder = Recorder::new(&out, columns(setup.description), options.every);
    let mut observer = (Progress::new(), (recorder, (Recording::new(setup.description), plots)));
    let outcome = setup.simulate(!options.no_error_estimate, &mut observer)?;
    let (_, (mut recorder, (recording, plots))) = observer;
    if let Some(error) = recorder.unusable.take() {
        return Err(error);
    }
    let mut report = RunReport::new(&setup, &outcome, &recording);
    let mut problems: Vec<Error> = report.problem().into_iter().collect();
    match recorder.finish_files(matches!(outcome.status, Status::Unwritable(_))) {
        Ok(rows) => report.rows = rows,
        Err(e) => problems.push(e),
    }
    // A curve needs two rows.
    if !options.no_figures && report.rows > 1 {
        let mut figures = figures(&setup, &outcome, &recording);
        figures.extend(plots.figures(&recording));
        problems.extend(draw(figures, &out, &mut report));
    }
    let mut tables = Vec::new();
    if report.rows > 0 {
        let written = write_tables(options, &recording, &out);
        written.map_or_else(|e| problems.push(e), |paths| tables.extend(paths));
    }
    report.other_time = Some(begun.elapsed().saturating_sub(outcome.integration));
    let saved = save_json(&out.join("summary.json"), &report);
    print(&report.text(&out, &tables, saved.is_ok()));
    problems.extend(saved.err());
    Error::all(problems)
}

/// Writes the units of the columns and, if requested, the trajectory in Parquet; returns the tables.
fn write_tables(options: &Options, recording: &Recording, out: &Path) -> Result<Vec<String>, Error> {
    let table = out.join("trajectory.csv");
    let columns: Vec<_> = recording.columns().cloned().collect();
    write_units(&table, &columns)?;
    if !options.parquet {
        return Ok(Vec::new());
    }
    let path: PathBuf = out.join("trajectory.parquet");
    parquet::copy(&table, &path, |_| parquet::Kind::Number).map_err(|e| Error::unwritable(&path, &e))?;
    Ok(vec![path.display().to_string()])
}

/// Draws the figures of a run and lists them in its report.
fn draw(figures: Vec<(String, Figure)>, out: &Path, report: &mut RunReport) -> Vec<Error> {
    let mut problems = Vec::new();
    for (name, figure) in figures {
        let file = format!("figures/{name}.svg");
        match figure.svg() {
            Ok(svg) => match save(&out.join(&file), svg.as_bytes()) {
                Ok(()) => report.figures.push(file),
                Err(e) => problems.push(e),
            },
            Err(reason) => report.warnings.push(Message::new(format!("{file} cannot be drawn: {reason}"))),
        }
    }
    problems
}
