//! Extreme variants of a mechanism.

use super::{Known, Value};

/// A variant with other parameters, on which methods are tried.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Extreme {
    /// Its name.
    pub name: String,
    /// What is extreme in it.
    pub doc: String,
    /// Parameters with other values.
    pub set: Vec<(usize, Value)>,
    /// When it ends, if not as the scene's own run.
    pub end_time: Option<Value>,
    /// How accurate the values are.
    pub accuracy: Option<Value>,
    /// What is known of its end.
    pub values: Vec<(Known, Value)>,
}
