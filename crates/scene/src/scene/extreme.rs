//! Extreme variants of a mechanism.

use super::{Known, Value};

/// A variant with other parameters, on which methods are tried.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Extreme {
    /// The name of the variant.
    pub name: String,
    /// The description of what is extreme in the variant.
    pub doc: String,
    /// Parameters with other values.
    pub set: Vec<(usize, Value)>,
    /// When it ends, if not as the scene's own run.
    pub end_time: Option<Value>,
    /// How accurate the values are.
    pub accuracy: Option<Value>,
    /// The known values at the end of the run of the variant.
    pub values: Vec<(Known, Value)>,
}
