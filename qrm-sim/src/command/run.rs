//! `qrm run`

use std::path::Path;

use super::arguments::RunArguments;
use super::progress::Progress;
use super::recorder::Recorder;
use super::setup::Setup;
use super::{Failure, account, digest, units};
use crate::album::Album;
#[cfg(feature = "pictures")]
use crate::outcome::Outcome;
use crate::outcome::Status;
use crate::scenes::Scenes;
#[cfg(feature = "pictures")]
use crate::summary::Summary;
use crate::trajectory::columns;

/// Runs a scene and writes its files.
pub(super) fn run(scenes: &Scenes, arguments: &RunArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.scene, &arguments.method)?;
    let out = setup.folder(arguments.out.as_deref());
    let recorder = Recorder::new(&out, setup.description, arguments.every);
    let mut observer = (Progress::new(), (recorder, Album::new(&setup.description)));
    let outcome = setup.simulate(!arguments.no_error_estimate, &mut observer)?;
    let (_, (mut recorder, album)) = observer;
    if let Some(reason) = recorder.unusable.take() {
        return Err(Failure::Use(reason));
    }
    let mut summary = account::summary(&setup, &outcome, &album);
    summary.rows = recorder.rows(matches!(outcome.status, Status::Unwritable(_)));
    let mut problems = Vec::new();
    #[cfg(feature = "pictures")]
    figures(arguments, &setup, (&outcome, &album), &out, &mut summary, &mut problems);
    let tables = if summary.rows > 0 { tables(arguments, &setup, &out) } else { Ok(Vec::new()) };
    let tables = tables.unwrap_or_else(|problem| {
        problems.push(problem);
        Vec::new()
    });
    let path = out.join("summary.json");
    let written = summary.write(&path);
    super::say(&digest::digest(&summary, &setup.description, &out, &tables, written.is_ok()));
    problems.extend(written.err().map(|e| super::unwritable(&path, &e)));
    problems.splice(0..0, account::problem(&outcome, &summary));
    if problems.is_empty() { Ok(()) } else { Err(Failure::Run(problems.join("\n"))) }
}

/// Writes what belongs to the trajectory, and says what that is; or what cannot be written.
fn tables(arguments: &RunArguments, setup: &Setup, out: &Path) -> Result<Vec<String>, String> {
    let table = out.join("trajectory.csv");
    units::write(&table, &columns(&setup.description), &setup.description)?;
    #[cfg(feature = "sweep")]
    if arguments.parquet {
        let path = out.join("trajectory.parquet");
        super::parquet::copy(&table, &path, |_| super::parquet::Kind::Number)
            .map_err(|e| super::unwritable(&path, &e))?;
        return Ok(vec![path.display().to_string()]);
    }
    #[cfg(not(feature = "sweep"))]
    let _ = arguments;
    Ok(Vec::new())
}

/// Draws the figures of a run.
#[cfg(feature = "pictures")]
fn figures(
    arguments: &RunArguments,
    setup: &Setup,
    (outcome, album): (&Outcome, &Album),
    out: &Path,
    summary: &mut Summary,
    problems: &mut Vec<String>,
) {
    // A curve takes two rows.
    if arguments.no_figures || summary.rows < 2 {
        return;
    }
    for (name, figure) in account::figures(setup, outcome, album) {
        let file = format!("figures/{name}.svg");
        match figure.svg().map(|svg| super::write(&out.join(&file), svg.as_bytes())) {
            Ok(Ok(())) => summary.figures.push(file),
            Ok(Err(e)) => problems.push(super::unwritable(&out.join(&file), &e)),
            Err(reason) => summary.warnings.push(format!("{file} cannot be drawn: {reason}")),
        }
    }
}
