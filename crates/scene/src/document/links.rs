//! `[links]`: rigid bodies with points in their own frames.

use super::reader::{self, Reader};
use super::table::Table;
use super::values::position;
use super::{Identifier, Position};
use crate::diagnostic::Diagnostic;
use crate::linkage::terms;
use crate::parser::Formula;

/// An entry of `[links]`.
#[derive(Debug)]
pub struct LinkSyntax {
    /// The name of the link.
    pub identifier: Identifier,
    /// The points of the link, with their coordinates in its frame.
    pub points: Vec<(Identifier, [Formula; 2])>,
    /// The shape of the link, if it has one.
    pub shape: Option<Shape>,
    /// Mass, or the density of a shape.
    pub mass: Option<Mass>,
    /// Centre of mass in its frame.
    pub com: Option<Position>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Option<Formula>,
    /// The name of the coordinate that is its angle.
    pub coordinate: Option<Identifier>,
    /// Angle at the start.
    pub angle: Option<Formula>,
    /// Angular velocity at the start; if present, angle and rate are both given.
    pub rate: Option<Formula>,
    /// The description of the link.
    pub doc: String,
}

/// The shape of a link with the lengths of its sides.
#[derive(Debug)]
pub enum Shape {
    /// A slender bar from the origin along its x axis.
    Bar(Formula),
    /// A thin triangle. Its first corner is the origin, the second one lies on the positive x axis, and the third one
    /// to the left of it. The sides run from the first to the second corner, from there to the third, and back.
    Triangle([Formula; 3]),
}

/// The mass of a link.
#[derive(Debug)]
pub enum Mass {
    /// In kg.
    Whole(Formula),
    /// In kg/m for a bar, in kg/m^2 for a triangle.
    ByDensity(Formula),
}

/// Reads an entry of `[links]`.
pub(super) fn link(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<LinkSyntax> {
    let table = r.table(&format!("link `{}`", identifier.name), value)?;
    let mut points: Vec<(Identifier, [Formula; 2])> = Vec::new();
    let has_shape = table.is_there("bar") || table.is_there("triangle");
    let shape = if has_shape { shape(r, &table, &mut points) } else { None };
    if let Some(own) = table.optional("points")
        && let Some(own) = r.table(&format!("the points of link `{}`", identifier.name), own)
    {
        for (point, value) in own.all() {
            r.check_name(&point, "point");
            let place = r.pair(value, "m");
            points.push((point, place));
        }
    }
    let mass = match (table.optional("mass"), has_shape.then(|| table.optional("density")).flatten()) {
        (Some(mass), _) => Some(Mass::Whole(r.quantity(mass, "kg"))),
        (None, Some(density)) => {
            let unit = if matches!(shape, Some(Shape::Triangle(_))) { "kg/m^2" } else { "kg/m" };
            Some(Mass::ByDensity(r.quantity(density, unit)))
        }
        (None, None) => None,
    };
    let coordinate = table.optional("coordinate").and_then(|v| r.text(v));
    if let Some(coordinate) = &coordinate {
        r.check_name(coordinate, "coordinate");
    }
    let syntax = LinkSyntax {
        points,
        shape,
        mass,
        com: table.optional("com").and_then(|v| position(r, v)),
        inertia: table.optional("inertia").map(|v| r.quantity(v, "kg m^2")),
        coordinate,
        angle: table.optional("angle").map(|v| r.angle(v)),
        rate: table.optional("rate").map(|v| r.quantity(v, "rad/s")),
        doc: table.string(r, "doc"),
        identifier,
    };
    table.finish(r);
    Some(syntax)
}

/// Reads `bar = ["A", "B"]` with its `length`, or `triangle = ["A", "B", "C"]` with its `sides`; adds their points.
fn shape(r: &mut Reader, table: &Table, points: &mut Vec<(Identifier, [Formula; 2])>) -> Option<Shape> {
    let kind = table.one_of(r, &["bar", "triangle"], "a link has one shape")?;
    let corners = table.required(r, kind)?;
    let names: Vec<Identifier> = r.array(corners).into_iter().filter_map(|value| r.text(value)).collect();
    for name in &names {
        r.check_name(name, "point");
    }
    let zero = || [terms::whole(0), terms::whole(0)];
    if kind == "bar" {
        let length = table.required(r, "length").map_or_else(reader::placeholder, |v| r.quantity(v, "m"));
        let Ok([from, to]) = <[Identifier; 2]>::try_from(names) else {
            return wrong(r, corners, "a bar has two ends", "write `bar = [\"A\", \"B\"]`");
        };
        points.extend([(from, zero()), (to, [length.clone(), terms::whole(0)])]);
        return Some(Shape::Bar(length));
    }
    let sides = table.required(r, "sides")?;
    let lengths: Vec<Formula> = r.array(sides).into_iter().map(|value| r.quantity(value, "m")).collect();
    let Ok(lengths) = <[Formula; 3]>::try_from(lengths) else {
        return wrong(r, sides, "a triangle has three sides", "write `sides = [AB, BC, CA]`");
    };
    let Ok([a, b, c]) = <[Identifier; 3]>::try_from(names) else {
        return wrong(r, corners, "a triangle has three corners", "write `triangle = [\"A\", \"B\", \"C\"]`");
    };
    let [first, second, third] = lengths.clone();
    points.extend([(a, zero()), (b, [first.clone(), terms::whole(0)]), (c, terms::corner(first, second, third))]);
    Some(Shape::Triangle(lengths))
}

fn wrong(r: &mut Reader, value: reader::Value, title: &str, help: &str) -> Option<Shape> {
    r.has_unread_declarations = true;
    let error = Diagnostic::error(title, value.span(), "another number of them");
    r.findings.push(error.help(format!("{help}, or give all points by `points = {{ ... }}`")));
    None
}
