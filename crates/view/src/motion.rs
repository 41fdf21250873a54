//! The content of an animation: a drawing that moves, frame by frame, and curves beside it.

mod shape;

use serde::Serialize;

pub use shape::{ForceElementPart, Shape, Track};
#[cfg(feature = "gif")]
pub(crate) use shape::{RIM, TIP};

/// A recorded motion.
#[derive(Clone, Debug, Serialize)]
pub struct Motion {
    /// The title of the animation: the thing that moves.
    pub title: String,
    /// A sentence about it.
    pub doc: String,
    /// The time of each frame in s, rising; at least two.
    pub times: Vec<f64>,
    /// Places of the drawing.
    pub nodes: Vec<Node>,
    /// The shapes drawn at or between nodes, the lowest layer first.
    pub shapes: Vec<Shape>,
    /// Forces.
    pub arrows: Vec<Arrow>,
    /// Curves over time.
    pub plots: Vec<Plot>,
}

/// A place of the drawing.
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
    /// Whether it is a reaction of the mechanism, not a load on it.
    pub is_reaction: bool,
    /// The node that it acts on.
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
