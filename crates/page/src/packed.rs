//! A derived scene as bytes for a page.

use qrm_core::{DerivedScene, OwnedDescription, Tape};
use qrm_scene::scene::Scene;
use serde::{Deserialize, Serialize};

/// A scene in the format of a page.
#[derive(Serialize, Deserialize)]
pub(crate) struct Packed {
    pub(crate) description: OwnedDescription,
    /// The tape for evaluators: a page prints no code.
    pub(crate) tape: Tape,
    pub(crate) scene: Scene,
}

/// Encodes a scene for a page.
///
/// # Panics
/// Never: encoding needs nothing but memory.
pub fn packed(derived: DerivedScene, scene: Scene) -> Vec<u8> {
    // The page does not show these long texts.
    let description = OwnedDescription { source: String::new(), derivation: String::new(), ..derived.description };
    let packed = Packed { description, tape: derived.tape.placed(), scene };
    postcard::to_stdvec(&packed).unwrap_or_else(|e| unreachable!("memory takes all bytes: {e}"))
}
