//! Errors of a translation into another language.

/// The error for a part that has no translation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no translation of {0}")]
pub struct Untranslated(pub(crate) String);
