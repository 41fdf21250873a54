//! `qrm derive`

use clap::Args;
use qrm_core::Model;

use crate::error::Error;
use crate::options::{OutFolder, SceneName};
use crate::output::{print, save};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
    #[command(flatten)]
    out: OutFolder,
}

/// Writes the derivation of a scene's equations of motion.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let description = options.scene.find(models)?.model.description;
    let path = options.out.of(description).join("derivation.md");
    save(&path, description.derivation.as_bytes())?;
    print(&format!("wrote {}", path.display()));
    Ok(())
}
