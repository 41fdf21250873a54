//! A derived scene as bytes for a page.

use qrm_core::{DerivedScene, OwnedDescription};
use qrm_scene::scene::Scene;
use serde::{Deserialize, Serialize};

/// A scene as a page holds it.
#[derive(Serialize, Deserialize)]
pub(crate) struct Packed {
    pub(crate) derived: DerivedScene,
    pub(crate) scene: Scene,
}

/// The bytes of a scene for a page.
///
/// # Panics
/// Never: memory is all that it needs.
pub fn packed(derived: DerivedScene, scene: Scene) -> Vec<u8> {
    // The page shows no texts of that length.
    let description = OwnedDescription { source: String::new(), derivation: String::new(), ..derived.description };
    let packed = Packed { derived: DerivedScene { description, tape: derived.tape.without_texts() }, scene };
    postcard::to_stdvec(&packed).unwrap_or_else(|e| unreachable!("memory takes all bytes: {e}"))
}
