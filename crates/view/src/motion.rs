//! The content of an animation: a moving drawing, frame by frame, and curves next to it.

mod shape;

use serde::Serialize;

pub use shape::{ForceElementPart, Shape, Track};
#[cfg(feature = "gif")]
pub(crate) use shape::{RIM, TIP};

/// A recorded motion.
#[derive(Clone, Debug, Serialize)]
pub struct Motion {
    /// The title of the animation: the moving thing.
    pub title: String,
    /// A sentence about the motion.
    pub doc: String,
    /// The time of each frame in s, increasing; at least two.
    pub times: Vec<f64>,
    /// The positions in the drawing.
    pub nodes: Vec<Node>,
    /// The shapes at or between nodes, lowest layer first.
    pub shapes: Vec<Shape>,
    /// The forces.
    pub arrows: Vec<Arrow>,
    /// The curves over time.
    pub plots: Vec<Plot>,
}

/// A position in the drawing.
#[derive(Clone, Debug, Serialize)]
pub struct Node {
    /// The name of the node; empty if it has none.
    pub name: String,
    /// Whether its path is drawn.
    pub is_traced: bool,
    /// Abscissa in m.
    pub x: Track,
    /// Ordinate in m, upward.
    pub y: Track,
}

/// A force.
#[derive(Clone, Debug, Serialize)]
pub struct Arrow {
    /// The name of the force.
    pub name: String,
    /// A description of the force.
    pub doc: String,
    /// Whether the force is a reaction of the mechanism instead of a load on it.
    pub is_reaction: bool,
    /// The node on which it acts.
    pub node: usize,
    /// The component of the force along x in N.
    pub x: Track,
    /// The component of the force along y in N.
    pub y: Track,
}

/// Curves in one unit.
#[derive(Clone, Debug, Serialize)]
pub struct Plot {
    /// The title of the plot: the quantity that the curves show.
    pub title: String,
    /// The unit of the curves.
    pub unit: String,
    /// The curves.
    pub curves: Vec<PlotCurve>,
}

/// A quantity over time.
#[derive(Clone, Debug, Serialize)]
pub struct PlotCurve {
    /// The name of the quantity.
    pub name: String,
    /// A value for each frame.
    pub values: Vec<f64>,
}
