//! `qrm explain`

use super::arguments::ExplainArguments;
use super::{Failure, settings};
use crate::scenes::Scenes;

/// Says what the generated code of a scene costs and does without.
pub(super) fn explain(scenes: &Scenes, arguments: &ExplainArguments) -> Result<(), Failure> {
    let description = settings::scene(scenes, &arguments.scene)?.description();
    // The same text stands in front of the generated module.
    let comment = description.code.lines().map_while(|line| line.strip_prefix("//"));
    let lines = comment.map(|line| line.strip_prefix(' ').unwrap_or(line)).skip_while(|line| *line != "Operations:");
    let text: Vec<&str> = lines.collect();
    super::say(&format!("{}: {}\n\n{}", description.name, description.doc, text.join("\n")));
    Ok(())
}
