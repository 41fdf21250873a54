//! Reference values.

use super::Value;

/// Reference values at one time.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Reference {
    /// The name of the reference.
    pub name: String,
    /// The source of the values.
    pub doc: String,
    /// The time.
    pub t: Value,
    /// The accuracy of the values.
    pub accuracy: Value,
    /// The values.
    pub values: Vec<(Known, Value)>,
}

/// A quantity with a reference value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Known {
    /// A coordinate.
    Coordinate(usize),
    /// The rate of a coordinate.
    Rate(usize),
    /// An output.
    Output(usize),
}
