//! `qrm explain`

use clap::Args;
use qrm_core::Model;

use crate::error::Error;
use crate::format::heading;
use crate::options::SceneName;
use crate::output::print;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
}

/// Prints the cost of a scene's generated code, and the parts that it omits.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let model = options.scene.find(models)?.model;
    let (description, notes) = (model.description, &model.named_tape().notes);
    print(&format!("{}\n\n{}", heading(description), notes.join("\n")));
    Ok(())
}
