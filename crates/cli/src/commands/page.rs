//! `qrm page`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use qrm_core::{DerivedScene, Model};
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
    /// The file [default: SCENE.html, after the file of the scene]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes a page with a scene and its simulator.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let found = options.scene.find(models)?;
    let stem = Path::new(&found.path).file_stem().unwrap_or_default();
    let out = options.out.clone().unwrap_or_else(|| Path::new(stem).with_added_extension("html"));
    check_place(&out)?;
    save_and_print(&out, page(&found, &options.scene.scene)?.as_bytes())
}

/// Creates the page of a scene; `name` is its name on the command line.
pub(crate) fn page(found: &FoundScene, name: &str) -> Result<String, Error> {
    let FoundScene { model, .. } = found;
    let description = model.description;
    let scene = found.read()?;
    // The folder of a file means nothing where the page is read.
    let name = Path::new(name).file_name().unwrap_or_default().to_string_lossy();
    let page = SimulatorPage {
        title: description.name,
        doc: description.doc,
        command: &shell_word(&name),
        is_writable: false,
        module: &packing::module(),
        scene: Some(&packing::packed(DerivedScene::from_model(model), Arc::unwrap_or_clone(scene))?),
    };
    simulator_page(&page, packing::compressed)
}

/// Returns an error if a page would overwrite a file of another kind.
fn check_place(out: &Path) -> Result<(), Error> {
    let shown = out.display();
    if out.is_dir() {
        return Err(Error::usage(format!("`--out {shown}` is a folder")).help("name a file, as `--out page.html`"));
    }
    if !out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html")) {
        return Err(Error::usage(format!("`--out {shown}` is not the name of a page"))
            .help("choose a name that ends in `.html`"));
    }
    Ok(())
}
