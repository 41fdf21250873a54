//! `qrm page`

use std::io::Write;
use std::path::PathBuf;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use clap::Args;
use flate2::Compression;
use flate2::write::GzEncoder;
use qrm_core::{DerivedScene, Model};
use qrm_scene::resolve;
use qrm_view::animation::{LiveScene, live_page};

use crate::error::Error;
use crate::options::SceneName;
use crate::output::save_and_print;
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
    let page = live_page(&LiveScene {
        title: description.name.to_owned(),
        doc: description.doc.to_owned(),
        module: BASE64_STANDARD.encode(qrm_page::MODULE),
        data: BASE64_STANDARD.encode(compressed(&qrm_page::packed(DerivedScene::of(model), scene))?),
    });
    let path = options.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}.html", description.name)));
    save_and_print(&path, page.as_bytes())
}

/// Bytes compressed by gzip.
fn compressed(bytes: &[u8]) -> Result<Vec<u8>, Error> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.map_err(|e| Error::run(format!("the scene cannot be compressed: {e}")))
}
