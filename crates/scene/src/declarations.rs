//! The names that formulae may contain, with their units.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::spline::Spline;
use crate::unit::Unit;

/// The names that formulae may contain, with their units.
#[derive(Clone, Debug, Default)]
pub struct Declarations {
    /// The lookup tables.
    pub tables: Vec<Arc<Spline>>,
    units: BTreeMap<String, Option<Unit>>,
}

impl Declarations {
    /// Adds a name; `unit` is the text of its unit, or empty.
    pub fn declare(&mut self, name: &str, unit: &str) {
        let unit = if unit.is_empty() { None } else { Unit::parse(unit) };
        self.units.insert(name.to_owned(), unit);
    }

    /// Adds a coordinate and its rate; `unit` is the unit of the coordinate.
    pub(crate) fn declare_coordinate(&mut self, name: &str, unit: &str) {
        self.declare(name, unit);
        self.declare(&format!("{name}_dot"), &format!("({unit})/s"));
    }

    /// Whether a name other than that of a table has been added.
    pub(crate) fn contains(&self, name: &str) -> bool {
        self.units.contains_key(name)
    }

    /// The unit of a name.
    pub(crate) fn unit(&self, name: &str) -> Option<&Unit> {
        self.units.get(name)?.as_ref()
    }
}
