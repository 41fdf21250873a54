//! `qrm derive`

use super::arguments::DeriveArguments;
use super::{Failure, settings};
use crate::scenes::Scenes;

/// Writes the derivation of a scene's equations of motion.
pub(super) fn derive(scenes: &Scenes, arguments: &DeriveArguments) -> Result<(), Failure> {
    let description = settings::scene(scenes, &arguments.scene)?.description();
    let path = settings::folder(&description, arguments.out.as_deref()).join("derivation.md");
    super::save(&path, description.derivation.as_bytes())?;
    super::say(&format!("wrote {}", path.display()));
    Ok(())
}
