//! `qrm derive`

mod expanded;
mod point_names;

use clap::Args;
use qrm_core::Model;
use qrm_scene::resolve;
use qrm_scene::source::read_text;

use crate::error::Error;
use crate::options::{OutFolder, SceneName};
use crate::output::{print, save};
use crate::scenes::{FoundScene, SceneSource, path_of};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
    /// Print the scene with its links and joints written out as coordinates, points, bodies and constraints
    #[arg(long = "scene", conflicts_with = "out")]
    expanded: bool,
    #[command(flatten)]
    out: OutFolder,
}

/// Writes the derivation of a scene's equations of motion.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    if options.expanded {
        return print_expanded(options.scene.source(models)?);
    }
    let FoundScene { model, path, .. } = options.scene.find(models)?;
    let path = options.out.folder(&path).join("derivation.md");
    save(&path, model.description.derivation.as_bytes())?;
    print(&format!("wrote {}", path.display()));
    Ok(())
}

/// Prints a scene without links and joints.
fn print_expanded(source: SceneSource) -> Result<(), Error> {
    let (path, text) = match source {
        SceneSource::File(path) => (path.display().to_string(), read_text(&path)?),
        SceneSource::Model(model) => (path_of(model.description), model.description.source.to_owned()),
    };
    resolve::read(&path, &text)?;
    let text = expanded::expanded(&text).map_err(|e| Error::run(format!("{path}: {e}")))?;
    print(text.trim_end());
    Ok(())
}
