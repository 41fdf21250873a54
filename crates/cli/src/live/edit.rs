//! Changes that are drawn with the mouse, made in the text of a scene.

mod add;
mod constant_term;
mod frame;
pub(super) mod length_parameters;
mod linkage;
mod move_point;
mod number;
mod places;
mod toggle;
mod toml_text;

use qrm_scene::resolve;
use serde::Deserialize;

use linkage::Linkage;
use move_point::move_point;
use places::Places;

/// A change of a scene in links and joints.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Edit {
    /// Moves a point of all links that have it.
    Move { point: String, to: [f64; 2] },
    /// Adds a bar.
    Bar { from: End, to: End },
    /// Adds a point to a link, with its path.
    Point { link: String, to: [f64; 2] },
    /// Pins a point to the ground.
    Pin { point: String },
    /// Holds a point on a line of the ground with this angle.
    Slider { point: String, direction: f64 },
    /// Drives the joint of a point and the ground, or removes its drive.
    Drive { point: String },
    /// Adds the force in the joint at a point to the outputs, or removes it.
    Force { point: String },
    /// Adds the path of a point to the drawing, or removes it.
    Path { point: String },
}

impl Edit {
    /// The places that it names.
    fn places(&self) -> Vec<[f64; 2]> {
        let place = |end: &End| if let End::Place(place) = end { Some(*place) } else { None };
        match self {
            Self::Move { to, .. } | Self::Point { to, .. } => vec![*to],
            Self::Bar { from, to } => [from, to].into_iter().filter_map(place).collect(),
            _ => Vec::new(),
        }
    }
}

/// An end of a new bar.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum End {
    /// At a point of the mechanism.
    Point(String),
    /// At a place without a point.
    Place([f64; 2]),
}

/// A change, and the position in which it was drawn.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Request {
    edit: Edit,
    /// Where the points are at the start, by their names in the drawing.
    places: Places,
    /// Changes with the same name are one step of the history.
    pub(super) gesture: Option<String>,
}

impl Request {
    /// The text of the scene after the change, and the names of the points of a new bar.
    ///
    /// # Errors
    /// The reason why the scene cannot be changed in this way.
    pub(super) fn apply(&self, text: &str) -> Result<(String, Vec<String>), String> {
        resolve::read("", text).map_err(|_| "the file has an error: mend it first".to_owned())?;
        let mut linkage = Linkage::parse(text)?;
        let places = self.places.checked(&self.edit.places())?;
        let mut ends = Vec::new();
        match &self.edit {
            Edit::Move { point, to } => move_point(&mut linkage, places, point, *to)?,
            Edit::Bar { from, to } => ends.extend(add::bar(&mut linkage, places, from, to)?),
            Edit::Point { link, to } => add::point(&mut linkage, places, link, *to)?,
            Edit::Pin { point } => add::pin(&mut linkage, places, point)?,
            Edit::Slider { point, direction } => add::slider(&mut linkage, places, point, *direction)?,
            Edit::Drive { point } => add::drive(&mut linkage, places, point)?,
            Edit::Force { point } => toggle::force(&mut linkage, point)?,
            Edit::Path { point } => toggle::path(&mut linkage, point)?,
        }
        Ok((linkage.text(), ends))
    }
}

#[cfg(test)]
mod tests;
