//! A quantity of a plot.

use qrm_scene::names::{is_identifier, suggestion};
use qrm_sim::columns::{Column, Kind};

use crate::error::Error;
use crate::setup::Setup;

/// A column of the trajectory, or a component of a point.
pub(super) struct Quantity {
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) doc: String,
    pub(super) source: Source,
}

/// The hint for a user who tries to plot a formula.
const FORMULA: &str = "write a formula as an output under [outputs], and plot that";

/// The source of its numbers.
pub(super) enum Source {
    /// A column: its index in a row, and its kind.
    Column(usize, Kind),
    /// The x (0) or y (1) component of a point.
    Point(usize, usize),
}

impl Quantity {
    /// Finds a quantity by its name: `x6`, `phi2_dot`, `C.y`.
    pub(super) fn new(setup: &Setup, columns: &[Column], name: &str) -> Result<Self, Error> {
        if let Some((point, component)) = name.split_once('.') {
            return Self::from_point(setup, point, component);
        }
        if let Some((place, column)) = columns.iter().enumerate().find(|(_, column)| column.name == name) {
            let Column { name, unit, doc, kind } = column.clone();
            return Ok(Self { name, unit, doc, source: Source::Column(place, kind) });
        }
        let names = || columns.iter().map(|column| column.name.as_str());
        let help = match is_identifier(name) {
            true => suggestion(name, names(), || format!("its columns: {}", names().collect::<Vec<_>>().join(", "))),
            false => FORMULA.to_owned(),
        };
        Err(Error::usage(format!("scene `{}` has no column `{name}`", setup.description.name)).help(help))
    }

    fn from_point(setup: &Setup, point: &str, component: &str) -> Result<Self, Error> {
        let points = &setup.scene.points;
        let names = || points.iter().map(|point| point.name.as_str());
        let Some(place) = names().position(|name| name == point) else {
            let help = suggestion(point, names(), || match points.len() {
                0 => FORMULA.to_owned(),
                _ => format!("its points: {}", names().collect::<Vec<_>>().join(", ")),
            });
            return Err(Error::usage(format!("scene `{}` has no point `{point}`", setup.description.name)).help(help));
        };
        let Some(axis) = ["x", "y"].iter().position(|axis| *axis == component) else {
            return Err(Error::usage(format!("there is no column `{point}.{component}`")).help(format!(
                "components of points are `{point}.x` and `{point}.y`; their rates become columns under [outputs], \
                 such as `{point}_x_dot = {{ rate = '{point}.x', unit = \"m/s\" }}`"
            )));
        };
        let name = format!("{point}.{component}");
        Ok(Self { name, unit: "m".to_owned(), doc: String::new(), source: Source::Point(place, axis) })
    }

    /// The name of the quantity, with its description if there is one.
    pub(super) fn title(&self) -> String {
        if self.doc.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.doc) }
    }
}
