//! `[links]`: rigid bodies with points in their own frames.

use super::sections::position;
use super::table::{self, Reader, Table};
use super::{Identifier, Position};
use crate::diagnostic::Diagnostic;
use crate::parser::Formula;

/// An entry of `[links]`.
#[derive(Debug)]
pub struct LinkSyntax {
    /// Its name.
    pub identifier: Identifier,
    /// Its points and their coordinates in its frame.
    pub points: Vec<(Identifier, [Formula; 2])>,
    /// The length of a slender bar, from its first point to its second one.
    pub bar: Option<Formula>,
    /// Mass, of a bar also by its length.
    pub mass: Option<Mass>,
    /// Centre of mass in its frame.
    pub com: Option<Position>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Option<Formula>,
    /// The name of the coordinate that is its angle.
    pub coordinate: Option<Identifier>,
    /// Angle at the start.
    pub angle: Option<Formula>,
    /// Angular velocity at the start; angle and rate are given with it.
    pub rate: Option<Formula>,
    /// What it is.
    pub doc: String,
}

/// The mass of a link.
#[derive(Debug)]
pub enum Mass {
    /// In kg.
    Whole(Formula),
    /// In kg/m.
    ByLength(Formula),
}

/// Reads an entry of `[links]`.
pub(super) fn link(r: &mut Reader, identifier: Identifier, value: table::Value) -> Option<LinkSyntax> {
    let table = r.table(&format!("link `{}`", identifier.name), value)?;
    let is_bar = table.is_there("bar");
    let mut points: Vec<(Identifier, [Formula; 2])> = Vec::new();
    let bar = if is_bar { bar(r, &table, &mut points) } else { None };
    if let Some(own) = table.optional("points")
        && let Some(own) = r.table(&format!("the points of link `{}`", identifier.name), own)
    {
        for (point, value) in own.all() {
            r.check_name(&point, "point");
            let place = r.pair(value);
            points.push((point, place));
        }
    }
    let mass = match (table.optional("mass"), is_bar.then(|| table.optional("density")).flatten()) {
        (Some(mass), _) => Some(Mass::Whole(r.formula(mass))),
        (None, Some(density)) => Some(Mass::ByLength(r.formula(density))),
        (None, None) => None,
    };
    let coordinate = table.optional("coordinate").and_then(|v| r.text(v));
    if let Some(coordinate) = &coordinate {
        r.check_name(coordinate, "coordinate");
    }
    let syntax = LinkSyntax {
        points,
        bar,
        mass,
        com: table.optional("com").and_then(|v| position(r, v)),
        inertia: table.optional("inertia").map(|v| r.formula(v)),
        coordinate,
        angle: table.optional("angle").map(|v| r.formula(v)),
        rate: table.optional("rate").map(|v| r.formula(v)),
        doc: table.string(r, "doc"),
        identifier,
    };
    table.finish(r);
    Some(syntax)
}

/// The ends of `bar = ["A", "B"]` and its `length`.
fn bar(r: &mut Reader, table: &Table, points: &mut Vec<(Identifier, [Formula; 2])>) -> Option<Formula> {
    let ends = table.optional("bar")?;
    let names: Vec<Identifier> = r.array(ends).into_iter().filter_map(|value| r.text(value)).collect();
    let length = table.required(r, "length").map_or_else(table::placeholder, |v| r.formula(v));
    let Ok([from, to]) = <[Identifier; 2]>::try_from(names) else {
        r.lost = true;
        let error = Diagnostic::error("a bar has two ends", ends.span(), "not two names");
        r.findings.push(error.help("write `bar = [\"A\", \"B\"]`, or give all points by `points = { ... }`"));
        return None;
    };
    for name in [&from, &to] {
        r.check_name(name, "point");
    }
    points.push((from, [table::zero(), table::zero()]));
    points.push((to, [length.clone(), table::zero()]));
    Some(length)
}
