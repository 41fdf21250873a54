//! `qrm animate`

use clap::Args;
use qrm_core::Model;

use crate::error::Error;
use crate::options::{MethodOptions, OutFolder, SceneOptions, StartOptions};
use crate::output::{print, save_and_print};
use crate::progress::Progress;
use crate::run_report::RunReport;
use crate::setup::Setup;
use qrm_pictures::{Recording, motion};
use qrm_view::motion::Motion;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    start: StartOptions,
    #[command(flatten)]
    method: MethodOptions,
    /// Make no GIF, only the page
    #[arg(long)]
    no_gif: bool,
    #[command(flatten)]
    out: OutFolder,
}

/// Runs a scene and writes its animation.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let setup = Setup::new(models, &options.scene, &options.method)?.starting_from(&options.start)?;
    let out = options.out.folder(&setup.path);
    let (motion, report) = animation(&setup)?;
    print(&format!("{}: {}\n", setup.description.name, report.message));
    save_and_print(&out.join("animation.html"), qrm_view::animation::page(&motion).as_bytes())?;
    if !options.no_gif {
        let gif = qrm_view::gif::gif(&motion).map_err(|e| Error::run(format!("no GIF could be made: {e}")))?;
        save_and_print(&out.join("animation.gif"), &gif)?;
    }
    report.problem().map_or(Ok(()), Err)
}

/// The motion of a run, and the report of that run.
pub(crate) fn animation(setup: &Setup) -> Result<(Motion, RunReport), Error> {
    let mut observer = (Progress::new(), Recording::new(setup.description));
    let outcome = setup.simulate(false, &mut observer)?;
    let recording = observer.1;
    let report = RunReport::new(setup, &outcome, &recording);
    if recording.frames.len() < 2 {
        return Err(report.message.into());
    }
    let (motion, _) = motion(&setup.scene, &setup.parameters(), &recording)?;
    Ok((motion, report))
}
