//! What cannot be translated.

/// The error for something that has no translation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no translation of {0}")]
pub struct Untranslated(pub(crate) String);
