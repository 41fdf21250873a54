//! `qrm run`

#[cfg(feature = "pictures")]
use std::path::Path;

use super::arguments::RunArguments;
use super::progress::Progress;
use super::recorder::Recorder;
use super::setup::Setup;
use super::{Failure, account, digest};
use crate::album::Album;
#[cfg(feature = "pictures")]
use crate::outcome::Outcome;
use crate::outcome::Status;
use crate::scenes::Scenes;
#[cfg(feature = "pictures")]
use crate::summary::Summary;

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
    let path = out.join("summary.json");
    let written = summary.write(&path);
    super::say(&digest::digest(&summary, &setup.description, &out, written.is_ok()));
    problems.extend(written.err().map(|e| super::unwritable(&path, &e)));
    problems.splice(0..0, account::problem(&outcome, &summary));
    if problems.is_empty() { Ok(()) } else { Err(Failure::Run(problems.join("\n"))) }
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
