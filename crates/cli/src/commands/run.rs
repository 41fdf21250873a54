//! `qrm run`

use std::time::Instant;

use clap::Args;
use qrm_core::Model;

use crate::error::Error;
use crate::options::{MethodOptions, OutFolder, PlotOptions, SceneOptions, StartOptions};
use crate::output::{print, save_json};
use crate::parquet;
use crate::plots::Plots;
use crate::run_files::{FinishedRun, RunFiles};
use crate::setup::Setup;

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
    let files =
        RunFiles { folder: &out, every: options.every, has_figures: !options.no_figures, parquet: options.parquet };
    files.check_targets()?;
    let finished = files.run(&setup, !options.no_error_estimate, plots)?;
    let FinishedRun { outcome, mut report, tables, mut problems, .. } = finished;
    report.other_time = Some(begun.elapsed().saturating_sub(outcome.integration));
    let saved = save_json(&out.join("summary.json"), &report);
    print(&report.text(&out, &tables, saved.is_ok()));
    problems.extend(saved.err());
    Error::all(problems)
}
