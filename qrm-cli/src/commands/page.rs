//! `qrm page`

use std::path::PathBuf;

use clap::Args;
use qrm_core::{DerivedScene, Model};
use qrm_scene::resolve;
use qrm_view::animation::{SimulatorPage, simulator_page};

use crate::error::Error;
use crate::options::SceneName;
use crate::output::{save_and_print, shell_word};
use crate::packing;
use crate::scenes::FoundScene;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
    /// The file [default: SCENE.html]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes a page with a scene and its simulator.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let FoundScene { model, path } = options.scene.find(models)?;
    let description = model.description;
    let (scene, _) = resolve::read(&path, description.source)?;
    let page = simulator_page(&SimulatorPage {
        title: description.name,
        doc: description.doc,
        command: &shell_word(&options.scene.scene),
        is_writable: false,
        module: &packing::module(),
        scene: Some(&packing::packed(DerivedScene::of(model), scene)?),
    });
    let path = options.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}.html", description.name)));
    save_and_print(&path, page.as_bytes())
}
