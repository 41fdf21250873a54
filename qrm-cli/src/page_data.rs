//! The simulator of pages and scenes for it, as text.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use qrm_core::DerivedScene;
use qrm_scene::scene::Scene;

use crate::error::Error;

/// The simulator, compressed by gzip, in base64.
pub(crate) fn module() -> String {
    BASE64_STANDARD.encode(qrm_page::MODULE)
}

/// A scene, compressed by gzip, in base64.
pub(crate) fn packed(derived: DerivedScene, scene: Scene) -> Result<String, Error> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(&qrm_page::packed(derived, scene)).and_then(|()| encoder.finish());
    let bytes = written.map_err(|e| Error::run(format!("the scene cannot be compressed: {e}")))?;
    Ok(BASE64_STANDARD.encode(bytes))
}
