//! What an animation shows: a drawing that moves, frame by frame, and curves beside it.

use serde::Serialize;

/// A recorded motion.
#[derive(Clone, Debug, Serialize)]
pub struct Motion {
    /// What moves.
    pub title: String,
    /// A sentence about it.
    pub doc: String,
    /// The time of each frame in s, rising; at least two.
    pub times: Vec<f64>,
    /// Places of the drawing.
    pub nodes: Vec<Node>,
    /// What is drawn between them, the lowest layer first.
    pub shapes: Vec<Shape>,
    /// Forces.
    pub arrows: Vec<Arrow>,
    /// Curves over time.
    pub plots: Vec<Plot>,
}

/// A value for each frame, or a single one if it never changes.
pub type Track = Vec<f64>;

/// A place of the drawing.
#[derive(Clone, Debug, Serialize)]
pub struct Node {
    /// Its name; empty if it has none.
    pub name: String,
    /// Whether its path is drawn.
    pub is_traced: bool,
    /// Abscissa in m.
    pub x: Track,
    /// Ordinate in m, upward.
    pub y: Track,
}

/// Something drawn at or between nodes, which are given by their places in [`Motion::nodes`].
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Shape {
    /// A rigid bar through nodes.
    Link {
        /// Its name.
        name: String,
        /// Its nodes.
        nodes: Vec<usize>,
    },
    /// A block that slides.
    Block {
        /// Its name.
        name: String,
        /// Its middle.
        node: usize,
        /// The direction it slides in, counter-clockwise from the x axis in rad.
        angle: Track,
    },
    /// A bearing that is fixed to the ground.
    Pivot {
        /// Its middle.
        node: usize,
    },
    /// A line that something slides along.
    Guide {
        /// Its nodes.
        nodes: Vec<usize>,
    },
    /// A centre of mass.
    Mass {
        /// The name of the body.
        name: String,
        /// Where it is.
        node: usize,
    },
}

/// A force.
#[derive(Clone, Debug, Serialize)]
pub struct Arrow {
    /// Its name.
    pub name: String,
    /// What it is.
    pub doc: String,
    /// Whether it is a reaction of the mechanism, not a load on it.
    pub is_reaction: bool,
    /// The node that it acts on.
    pub node: usize,
    /// Its component along x in N.
    pub x: Track,
    /// Its component along y in N.
    pub y: Track,
}

/// Curves in one unit.
#[derive(Clone, Debug, Serialize)]
pub struct Plot {
    /// What they show.
    pub title: String,
    /// Their unit.
    pub unit: String,
    /// The curves.
    pub curves: Vec<PlotCurve>,
}

/// A quantity over time.
#[derive(Clone, Debug, Serialize)]
pub struct PlotCurve {
    /// Its name.
    pub name: String,
    /// A value for each frame.
    pub values: Vec<f64>,
}
