//! Values that are known from elsewhere.

use super::Value;

/// Values at one time that are known from elsewhere.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Reference {
    /// The name of the reference.
    pub name: String,
    /// Where it is from.
    pub doc: String,
    /// The time.
    pub t: Value,
    /// How accurate the values are.
    pub accuracy: Value,
    /// The values.
    pub values: Vec<(Known, Value)>,
}

/// A quantity whose value is known from elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Known {
    /// A coordinate.
    Coordinate(usize),
    /// The rate of a coordinate.
    Rate(usize),
    /// An output.
    Output(usize),
}
