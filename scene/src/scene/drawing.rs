//! What a picture of a mechanism shows.

use super::Value;

/// A part of a picture.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Drawn {
    /// Its name.
    pub name: String,
    /// What it looks like.
    pub kind: DrawnKind,
}

/// The kinds of parts of a picture.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum DrawnKind {
    /// A rigid bar through places.
    Link(Vec<[Value; 2]>),
    /// A block that slides.
    Block {
        /// Its middle.
        at: [Value; 2],
        /// The direction it slides in.
        angle: Option<Value>,
    },
    /// A bearing on the ground.
    Pivot([Value; 2]),
    /// A line that something slides along.
    Guide(Vec<[Value; 2]>),
    /// The path of a point.
    Path(usize),
}

impl DrawnKind {
    /// Its formulae.
    pub fn values(&self) -> Vec<&Value> {
        match self {
            Self::Link(places) | Self::Guide(places) => places.iter().flatten().collect(),
            Self::Block { at, angle } => at.iter().chain(angle).collect(),
            Self::Pivot(at) => at.iter().collect(),
            Self::Path(_) => Vec::new(),
        }
    }
}
