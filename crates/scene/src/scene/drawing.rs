//! The parts of a picture of a mechanism.

use super::Value;
use crate::document::ForceElementKind;

/// A part of a picture.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Drawn {
    /// The name of the part.
    pub name: String,
    /// The kind of the part.
    pub kind: DrawnKind,
}

/// The kinds of parts of a picture.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub enum DrawnKind {
    /// A rigid bar through places.
    Link(Vec<[Value; 2]>),
    /// A thin rod or a rope.
    Rod([[Value; 2]; 2]),
    /// A block that slides.
    Block {
        /// The centre of the block.
        at: [Value; 2],
        /// The sliding direction of the block.
        angle: Option<Value>,
        /// A point on the line along which it slides.
        on: Option<[Value; 2]>,
    },
    /// A bearing on the ground.
    Pivot([Value; 2]),
    /// A line along which something slides.
    Guide(Vec<[Value; 2]>),
    /// A spring, a damper or an actuator.
    ForceElement(ForceElementKind, [[Value; 2]; 2]),
    /// A gear.
    Gear {
        /// The centre of the gear.
        at: [Value; 2],
        /// The radius of its pitch circle.
        radius: Value,
        /// The angle by which it has turned.
        angle: Option<Value>,
        /// Whether its teeth point inward.
        is_internal: bool,
    },
    /// A toothed rack.
    Rack {
        /// A point that moves with it.
        on: [Value; 2],
        /// The centre of the gear that rolls on it.
        wheel: [Value; 2],
        /// The radius of that gear; negative if it rolls on the right-hand side of the rack.
        radius: Value,
        /// The direction of the rack.
        angle: Option<Value>,
    },
    /// A belt over two pulleys.
    Belt {
        /// The centres of the pulleys.
        at: [[Value; 2]; 2],
        /// The radii of the pulleys.
        radii: [Value; 2],
        /// Whether the belt crosses itself.
        is_crossed: bool,
        /// The angle by which the first pulley has turned relative to the line between the centres.
        angle: Option<Value>,
    },
    /// A cam.
    Cam {
        /// The centre of the cam.
        at: [Value; 2],
        /// The angle by which it has turned.
        angle: Option<Value>,
        /// The radius of the cam, where [`Quantity::Stretch`](super::Quantity::Stretch) is the polar angle in its
        /// frame; or the distance of a face, where it is the angle of the face's normal.
        profile: Value,
        /// Whether the follower has a flat face.
        is_flat: bool,
    },
    /// The path of a point.
    Path(usize),
}

impl DrawnKind {
    /// The formulae of the part.
    pub fn values(&self) -> Vec<&Value> {
        match self {
            Self::Link(places) | Self::Guide(places) => places.iter().flatten().collect(),
            Self::Rod(ends) | Self::ForceElement(_, ends) => ends.iter().flatten().collect(),
            Self::Block { at, angle, on } => at.iter().chain(angle).chain(on.iter().flatten()).collect(),
            Self::Pivot(at) => at.iter().collect(),
            Self::Gear { at, radius, angle, .. } => at.iter().chain([radius]).chain(angle).collect(),
            Self::Rack { on, wheel, radius, angle } => on.iter().chain(wheel).chain([radius]).chain(angle).collect(),
            Self::Belt { at, radii, angle, .. } => at.iter().flatten().chain(radii).chain(angle).collect(),
            Self::Cam { at, angle, profile, .. } => at.iter().chain(angle).chain([profile]).collect(),
            Self::Path(_) => Vec::new(),
        }
    }
}
