//! Extreme variants of a mechanism.

use super::{Known, Value};

/// A variant with other parameters, on which methods are tested.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Extreme {
    /// The name of the variant.
    pub name: String,
    /// The extreme property of the variant, for people.
    pub doc: String,
    /// Parameters with changed values.
    pub set: Vec<(usize, Value)>,
    /// The end time, unless it is that of the scene's own run.
    pub end_time: Option<Value>,
    /// The accuracy of the values.
    pub accuracy: Option<Value>,
    /// The known values at the end of the run of the variant.
    pub values: Vec<(Known, Value)>,
}
