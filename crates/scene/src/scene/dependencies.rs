//! Dependencies of formulae on coordinates, parameters, rates and time.

use std::collections::BTreeSet;

use super::{Quantity, Scene, Value};

impl Scene {
    /// Whether a formula could be read and all its names looked up.
    pub fn is_known(value: &Value) -> bool {
        value.names().all(|name| *name != Quantity::Unknown)
    }

    /// Whether any of these formulae depends on time, also through points.
    pub fn depends_on_time<'s>(&'s self, values: impl IntoIterator<Item = &'s Value>) -> bool {
        self.quantities_of(values).any(|name| name == Quantity::Time)
    }

    /// Whether a formula contains a rate, also that of a point.
    pub fn depends_on_rates(&self, value: &Value) -> bool {
        self.quantities_of([value]).any(|name| matches!(name, Quantity::Rate(_) | Quantity::PointRate(..)))
    }

    /// The coordinates on which formulae depend, also through points.
    pub fn coordinates_of<'s>(&'s self, values: impl IntoIterator<Item = &'s Value>) -> Vec<usize> {
        let mut found = vec![false; self.coordinates.len()];
        for quantity in self.quantities_of(values) {
            if let Quantity::Coordinate(i) | Quantity::Rate(i) = quantity {
                found[i] = true;
            }
        }
        (0..found.len()).filter(|&i| found[i]).collect()
    }

    /// The parameters on which formulae depend, also through points and other parameters.
    pub fn parameters_of<'s>(&'s self, values: impl IntoIterator<Item = &'s Value>) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        let mut pending: Vec<&Value> = values.into_iter().collect();
        while let Some(value) = pending.pop() {
            for quantity in self.quantities_of([value]) {
                if let Quantity::Parameter(i) = quantity
                    && found.insert(i)
                {
                    pending.push(&self.parameters[i].formula);
                }
            }
        }
        found
    }

    /// The quantities in formulae and in the points that they use. Each point is visited once; a quantity may occur
    /// more often.
    fn quantities_of<'s>(&'s self, values: impl IntoIterator<Item = &'s Value>) -> impl Iterator<Item = Quantity> + 's {
        let mut visited = vec![false; self.points.len()];
        let mut pending: Vec<&Value> = values.into_iter().collect();
        let mut names = None;
        std::iter::from_fn(move || {
            loop {
                let Some(name) = names.as_mut().and_then(Iterator::next) else {
                    names = Some(pending.pop()?.names());
                    continue;
                };
                if let Quantity::Point(point, _) | Quantity::PointRate(point, _) = *name
                    && !std::mem::replace(&mut visited[point], true)
                {
                    pending.extend(&self.points[point].position);
                }
                return Some(*name);
            }
        })
    }
}
