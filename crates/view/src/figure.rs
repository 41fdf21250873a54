//! Curves over time, and their picture as SVG.
//!
//! The SVG can be read back. Coordinates are counted in its `viewBox`; for each panel there is an element `<g
//! class="panel">` with the rectangle of the plotting area (`data-left`, `data-right`, `data-top`, `data-bottom`), the
//! times at its left and right (`data-t0`, `data-t1`), the values at its bottom and top (`data-low`, `data-high`) and
//! how the ordinate is divided (`data-scale`). In it there is for each curve an element `<g class="curve">` with its
//! name (`data-name`), the colour of its lines (`data-stroke`) and of the labels of its extremes (`data-ink`), and its
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

/// Panels one above the other, over the same abscissa.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Stands above the panels.
    pub title: String,
    /// The abscissa of all panels.
    pub abscissa: Abscissa,
    /// The panels, the first one at the top.
    pub panels: Vec<Panel>,
}

/// The abscissa of all panels.
#[derive(Clone, Debug)]
pub struct Abscissa {
    /// The quantity of the abscissa, without its unit.
    pub quantity: String,
    /// The unit of the abscissa; empty if it has none.
    pub unit: String,
    /// How it is divided.
    pub scale: Scale,
    /// Whether a unit is as long on the ordinate, as in the path of a point or of a force.
    pub is_isometric: bool,
    /// Whether an isometric figure shows the origin even where no curve is near it, as that of a force does.
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
    /// How the ordinate is divided.
    pub scale: Scale,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Below this value nothing can be told, and why.
    pub floor: Option<(f64, String)>,
}

/// How an axis is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten; values that are not above zero are left out.
    Logarithmic,
}

/// A quantity over the abscissa, which is time in most figures.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The name of the curve in the legend: `phi2_dot`.
    pub name: String,
    /// A description of the curve in a few words: `crank`.
    pub doc: String,
    /// Time and value, in the order of time; all finite. In an isometric figure the points of a path, in its order.
    pub points: Vec<(f64, f64)>,
    /// The smallest and the largest value of the curve, if they are to be marked.
    pub extremes: Option<Extremes>,
    /// Whether each point is a measurement, to be seen as a dot.
    pub has_dots: bool,
}

/// The smallest and the largest value of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Time and value of the smallest.
    pub minimum: (f64, f64),
    /// Time and value of the largest.
    pub maximum: (f64, f64),
}

impl Figure {
    /// The figure as SVG: 800 CSS pixels wide, dark on a dark screen, fit to stand alone or in an HTML page.
    ///
    /// # Errors
    /// There is nothing to draw, or it lies too far apart.
    pub fn svg(&self) -> Result<String, NoPicture> {
        sheet::draw(self)
    }
}

/// Why a figure cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoPicture {
    /// No curve has a point.
    Empty,
    /// This curve has a time or value that is not a finite number.
    NotFinite(String),
    /// The times, or the values of this quantity, lie so far apart that their difference is not a finite number.
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
