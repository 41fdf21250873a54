//! Curves over time, and their rendering in SVG.
//!
//! The SVG can be read back. Coordinates are in the units of its `viewBox`. Each panel has an element
//! `<g class="panel">` with the rectangle of the plotting area (`data-left`, `data-right`, `data-top`, `data-bottom`),
//! the times at its left and right (`data-t0`, `data-t1`), the values at its bottom and top (`data-low`, `data-high`)
//! and the scale of the ordinate (`data-scale`). Inside it, each curve has an element `<g class="curve">` with its name
//! (`data-name`), the colour of its lines (`data-stroke`) and of the labels of its extremes (`data-ink`), and its
//! extremes (`data-minimum`, `data-maximum`: time and value).

mod axis;
mod chart;
mod label;
mod layout;
mod look;
mod marks;
mod markup;
mod number;
mod path;
mod profile;
mod sheet;
mod span;
mod text;
mod trace;

use std::fmt;

/// Panels arranged vertically, with a common abscissa.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The title above the panels.
    pub title: String,
    /// The abscissa of all panels.
    pub abscissa: Abscissa,
    /// The panels from top to bottom.
    pub panels: Vec<Panel>,
}

/// The abscissa of all panels.
#[derive(Clone, Debug)]
pub struct Abscissa {
    /// The quantity of the abscissa, without its unit.
    pub quantity: String,
    /// The unit of the abscissa; empty if it has none.
    pub unit: String,
    /// The scale of the abscissa.
    pub scale: Scale,
    /// Whether both axes have the same scale, as for the path of a point or of a force.
    pub is_isometric: bool,
    /// Whether an isometric figure always shows the origin, as for the path of a force.
    pub has_origin: bool,
}

impl Abscissa {
    /// The time of a motion in s.
    pub fn time() -> Self {
        let (quantity, unit) = ("t".to_owned(), "s".to_owned());
        Self { quantity, unit, scale: Scale::Linear, is_isometric: false, has_origin: false }
    }
}

/// Curves in one unit.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The quantity of the ordinate, without its unit: `angular speed`.
    pub quantity: String,
    /// The unit of the ordinate; empty if it has none.
    pub unit: String,
    /// The scale of the ordinate.
    pub scale: Scale,
    /// The curves.
    pub curves: Vec<Curve>,
    /// The value below which the curves carry no information, and the reason.
    pub floor: Option<(f64, String)>,
}

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// A linear scale.
    Linear,
    /// A logarithmic scale in powers of ten; values that are not positive are omitted.
    Logarithmic,
}

/// A quantity over the abscissa, which is time in most figures.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The name of the curve in the legend: `phi2_dot`.
    pub name: String,
    /// A description of the curve in a few words: `crank`.
    pub doc: String,
    /// Pairs of time and value in the order of time; all finite. In an isometric figure the points of a path, in their
    /// order.
    pub points: Vec<(f64, f64)>,
    /// The smallest and the largest value of the curve, if they are marked.
    pub extremes: Option<Extremes>,
    /// Whether each point is drawn as a dot, for measurements.
    pub has_dots: bool,
}

/// The smallest and the largest value of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Time and value of the minimum.
    pub minimum: (f64, f64),
    /// Time and value of the maximum.
    pub maximum: (f64, f64),
}

impl Figure {
    /// Draws the figure as SVG: 800 CSS pixels wide, with a dark mode, as a separate file or inside an HTML page.
    ///
    /// # Errors
    /// There is nothing to draw, or the range is too large.
    pub fn svg(&self) -> Result<String, NoPicture> {
        sheet::draw(self)
    }
}

/// The reason why a figure cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoPicture {
    /// No curve has a point.
    Empty,
    /// This curve has a time or value that is not a finite number.
    NotFinite(String),
    /// The range of the times, or of the values of this quantity, is not a finite number.
    TooFarApart(String),
    /// The picture could not be written.
    NotWritten(String),
}

impl fmt::Display for NoPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("there are no points to draw"),
            Self::NotFinite(curve) => write!(f, "curve `{curve}` has a point that is not finite"),
            Self::TooFarApart(quantity) => write!(f, "the values of `{quantity}` lie too far apart to draw"),
            Self::NotWritten(why) => write!(f, "the picture was not written: {why}"),
        }
    }
}

impl std::error::Error for NoPicture {}
