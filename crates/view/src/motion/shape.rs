//! Shapes of a moving drawing.

use serde::Serialize;

/// A shape at or between nodes, which are indices into [`Motion::nodes`](super::Motion::nodes).
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "camelCase")]
pub enum Shape {
    /// A rigid bar through two nodes, or a plate.
    Link {
        /// The name of the link.
        name: String,
        /// The nodes of the link.
        nodes: Vec<usize>,
    },
    /// A block that slides.
    Block {
        /// The name of the block.
        name: String,
        /// The node at the centre of the block.
        node: usize,
        /// The sliding direction, counter-clockwise from the x axis in rad.
        angle: Track,
    },
    /// A bearing that is fixed to the ground.
    Pivot {
        /// The node at the centre of the bearing.
        node: usize,
    },
    /// A line along which something slides.
    Guide {
        /// The nodes of the line.
        nodes: Vec<usize>,
        /// Whether the guide is a channel with walls on both sides of a block.
        is_channel: bool,
    },
    /// A thin rod, or a rope.
    Rod {
        /// The name of the rod.
        name: String,
        /// The nodes at the two ends of the rod.
        nodes: Vec<usize>,
    },
    /// Parallel springs, dampers and actuators.
    ForceElement {
        /// The name of the force element.
        name: String,
        /// The nodes at the two ends of the force element.
        nodes: Vec<usize>,
        /// The parts of the force element.
        parts: Vec<ForceElementPart>,
    },
    /// A gear; one without a name belongs to the ground.
    Gear {
        /// The name of the gear.
        name: String,
        /// The node at the centre of the gear.
        node: usize,
        /// The angle by which it has turned, counter-clockwise in rad.
        angle: Track,
        /// The radius of its pitch circle in m.
        radius: f64,
        /// The number of teeth.
        teeth: u32,
        /// The angle of the first tooth in its frame.
        phase: f64,
        /// Whether its teeth point inward.
        is_internal: bool,
    },
    /// A rack with teeth on its left; one without a name belongs to the ground.
    Rack {
        /// The name of the rack.
        name: String,
        /// A point that moves with it.
        node: usize,
        /// The direction of the rack, counter-clockwise from the x axis in rad.
        angle: Track,
        /// Its ends, measured from the node along its direction in m.
        along: [f64; 2],
        /// The distance of its pitch line to the left of the node, in m.
        across: f64,
        /// The distance between teeth in m; negative if the teeth are on its right.
        pitch: f64,
        /// The position of one of its teeth along the rack.
        phase: f64,
    },
    /// A moving slot or rod along which something slides.
    Rail {
        /// A point that moves with it.
        node: usize,
        /// The direction of the rail, counter-clockwise from the x axis in rad.
        angle: Track,
        /// Its ends, measured from the node along its direction in m.
        along: [f64; 2],
    },
    /// A belt over two pulleys.
    Belt {
        /// The name of the belt.
        name: String,
        /// The centres of the pulleys.
        nodes: Vec<usize>,
        /// The radii of the pulleys in m.
        radii: [f64; 2],
        /// Whether the belt crosses itself.
        is_crossed: bool,
        /// The angle by which the first pulley has turned relative to the line between the centres, in rad.
        angle: Track,
    },
    /// A body drawn by its outline.
    Outline {
        /// The name of the body.
        name: String,
        /// The origin of its frame.
        node: usize,
        /// The angle of its frame, counter-clockwise in rad.
        angle: Track,
        /// Abscissae of its corners in its frame in m.
        x: Vec<f64>,
        /// Ordinates of its corners in its frame in m.
        y: Vec<f64>,
    },
    /// A centre of mass.
    Mass {
        /// The name of the body.
        name: String,
        /// The node at its position.
        node: usize,
    },
}

/// The height of teeth above the pitch circle, and the rim of a ring, in modules.
pub(crate) const TIP: f64 = 0.8;
pub(crate) const RIM: f64 = 2.6;

/// A part of a force element between two nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ForceElementPart {
    /// A spring.
    Spring,
    /// A damper.
    Damper,
    /// A cylinder that pushes or pulls.
    Actuator,
}

/// The angle of a shape, borrowed like the shape itself.
macro_rules! angle_of {
    ($shape:expr) => {
        match $shape {
            Self::Block { angle, .. }
            | Self::Gear { angle, .. }
            | Self::Rack { angle, .. }
            | Self::Rail { angle, .. }
            | Self::Belt { angle, .. }
            | Self::Outline { angle, .. } => Some(angle),
            _ => None,
        }
    };
}

impl Shape {
    /// The nodes at or between which it is drawn.
    pub fn nodes(&self) -> &[usize] {
        match self {
            Self::Link { nodes, .. }
            | Self::Guide { nodes, .. }
            | Self::Rod { nodes, .. }
            | Self::ForceElement { nodes, .. }
            | Self::Belt { nodes, .. } => nodes,
            Self::Block { node, .. }
            | Self::Pivot { node }
            | Self::Mass { node, .. }
            | Self::Gear { node, .. }
            | Self::Rack { node, .. }
            | Self::Rail { node, .. }
            | Self::Outline { node, .. } => std::slice::from_ref(node),
        }
    }

    /// The name of the shape; empty if it has none.
    pub fn name(&self) -> &str {
        match self {
            Self::Link { name, .. }
            | Self::Block { name, .. }
            | Self::Mass { name, .. }
            | Self::Rod { name, .. }
            | Self::ForceElement { name, .. }
            | Self::Gear { name, .. }
            | Self::Rack { name, .. }
            | Self::Belt { name, .. }
            | Self::Outline { name, .. } => name,
            Self::Pivot { .. } | Self::Guide { .. } | Self::Rail { .. } => "",
        }
    }

    /// The angle of the shape, if it has one.
    pub fn angle(&self) -> Option<&Track> {
        angle_of!(self)
    }

    /// The mutable angle of the shape, if it has one.
    pub fn angle_mut(&mut self) -> Option<&mut Track> {
        angle_of!(self)
    }

    /// The lengths and positions of the shape in its own frame.
    pub fn sizes(&self) -> Vec<f64> {
        match self {
            Self::Gear { radius, phase, .. } => vec![*radius, *phase],
            Self::Rack { along, across, pitch, phase, .. } => vec![along[0], along[1], *across, *pitch, *phase],
            Self::Rail { along, .. } => along.to_vec(),
            Self::Belt { radii, .. } => radii.to_vec(),
            Self::Outline { x, y, .. } => x.iter().chain(y).copied().collect(),
            _ => Vec::new(),
        }
    }

    /// The extent of the shape around each of its nodes, in m.
    pub fn radii(&self) -> Vec<f64> {
        match self {
            // The rim of a ring gear is outside of its teeth.
            Self::Gear { radius, teeth, is_internal, .. } => {
                let module = 2.0 * radius / f64::from((*teeth).max(1));
                vec![radius + module * if *is_internal { RIM } else { TIP }]
            }
            Self::Belt { radii, .. } => radii.to_vec(),
            Self::Outline { x, y, .. } => {
                vec![x.iter().zip(y).map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max)]
            }
            _ => vec![0.0; self.nodes().len()],
        }
    }

    /// The ends of the shape in the frame of its node, if it is a line in such a frame.
    pub fn ends(&self) -> Option<[[f64; 2]; 2]> {
        match self {
            Self::Rack { along, across, .. } => Some(along.map(|along| [along, *across])),
            Self::Rail { along, .. } => Some(along.map(|along| [along, 0.0])),
            _ => None,
        }
    }
}

/// One value per frame, or a single one if it never changes.
pub type Track = Vec<f64>;
