//! `qrm explain`

use clap::Args;
use qrm_core::Model;

use crate::error::Error;
use crate::options::SceneName;
use crate::output::print;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
}

/// Prints the cost of a scene's generated code, and what it does without.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let description = options.scene.find(models)?.model.description;
    // The text stands in front of the generated module.
    let comment = description.code.lines().map_while(|line| line.strip_prefix("//"));
    let lines = comment.map(|line| line.strip_prefix(' ').unwrap_or(line)).skip_while(|line| *line != "Operations:");
    let text: Vec<&str> = lines.collect();
    print(&format!("{}: {}\n\n{}", description.name, description.doc, text.join("\n")));
    Ok(())
}
