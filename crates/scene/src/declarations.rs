//! The names that formulae may contain, with their units.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::dimension::{Dimension, Source};
use crate::expression::Expression;
use crate::spline::Spline;
use crate::unit::Unit;

/// A function given by points: `spline(x)`, and `formula*cardinal(x)` for each ordinate that is a formula. Its cardinal
/// spline is one at its point and zero at the others.
#[derive(Clone, Debug)]
pub(crate) struct LookupTable {
    /// The spline with zeros in place of formulae.
    pub(crate) spline: Arc<Spline>,
    /// The ordinates that are formulae, with their cardinal splines.
    pub(crate) parts: Vec<(Expression<String>, Arc<Spline>)>,
    /// The dimensions of abscissae and of ordinates; `None` for numbers without units.
    pub(crate) dimensions: [Option<Dimension>; 2],
}

impl From<Spline> for LookupTable {
    fn from(spline: Spline) -> Self {
        Self { spline: Arc::new(spline), parts: Vec::new(), dimensions: [None, None] }
    }
}

/// The names that formulae may contain, with their units.
#[derive(Clone, Debug, Default)]
pub struct Declarations {
    /// The lookup tables.
    pub(crate) tables: Vec<LookupTable>,
    /// The names of tables with formulae as entries. The formulae of parameters cannot call them.
    pub(crate) tables_of_parameters: BTreeSet<String>,
    units: BTreeMap<String, Option<Unit>>,
    /// The names that are parameters.
    parameters: BTreeSet<String>,
}

impl Declarations {
    /// Adds a name; `unit` is the text of its unit, or empty.
    pub fn declare(&mut self, name: &str, unit: &str) {
        let unit = if unit.is_empty() { None } else { Unit::parse(unit) };
        self.units.insert(name.to_owned(), unit);
    }

    /// Adds a name with a unit, or none.
    pub(crate) fn declare_unit(&mut self, name: &str, unit: Option<Unit>) {
        self.units.insert(name.to_owned(), unit);
    }

    /// Adds a parameter; `unit` is the text of its unit, or empty.
    pub fn declare_parameter(&mut self, name: &str, unit: &str) {
        self.declare(name, unit);
        self.parameters.insert(name.to_owned());
    }

    /// Adds a coordinate, its rate and its acceleration; `unit` is the unit of the coordinate.
    pub(crate) fn declare_coordinate(&mut self, name: &str, unit: &str) {
        self.declare(name, unit);
        self.declare(&format!("{name}_dot"), &format!("({unit})/s"));
        self.declare(&format!("{name}_ddot"), &format!("({unit})/s^2"));
    }

    /// Adds the energies, which conditions may contain.
    pub(crate) fn declare_energies(&mut self) {
        ["kinetic_energy", "potential_energy", "energy"].into_iter().for_each(|name| self.declare(name, "J"));
    }

    /// Whether a name is that of a parameter.
    pub(crate) fn is_parameter(&self, name: &str) -> bool {
        self.parameters.contains(name)
    }

    /// Whether a name other than that of a table has been added.
    pub(crate) fn contains(&self, name: &str) -> bool {
        self.units.contains_key(name)
    }

    /// Removes a name.
    pub(crate) fn remove(&mut self, name: &str) {
        self.units.remove(name);
    }

    /// The unit of a name; components of points are lengths, and `t` is a time.
    pub(crate) fn unit(&self, name: &str) -> Option<Unit> {
        let implied = match name.rsplit_once('.') {
            Some((_, "x" | "y")) => "m",
            Some((_, "x_dot" | "y_dot")) => "m/s",
            None if name == "t" => "s",
            _ => return self.units.get(name)?.clone(),
        };
        Unit::parse(implied)
    }

    /// The source of the unit of a name.
    pub(crate) fn source(&self, name: &str) -> Source {
        match self.units.get(name) {
            Some(Some(unit)) if unit.is_scaled() => Source::Conversion,
            Some(Some(_)) if self.parameters.contains(name) => Source::Declaration,
            _ => Source::Nature,
        }
    }
}
