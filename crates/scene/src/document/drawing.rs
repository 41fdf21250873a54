//! Entries of `[drawing]`.

use super::reader::{self, Reader};
use super::table::Table;
use super::values::position;
use super::{Identifier, Position};
use crate::diagnostic::Diagnostic;
use crate::parser::Formula;

/// The kinds of entries of `[drawing]`.
#[derive(Debug)]
pub enum DrawnSyntax {
    /// A rigid bar through points.
    Link(Vec<Position>),
    /// A thin rod or a rope.
    Rod([Position; 2]),
    /// A block that slides.
    Block {
        /// The centre of the block.
        at: Position,
        /// The sliding direction of the block.
        angle: Option<Formula>,
        /// A point on the line along which it slides.
        on: Option<Position>,
    },
    /// A bearing on the ground.
    Pivot(Position),
    /// A line along which something slides.
    Guide(Vec<Position>),
    /// A spring, a damper or an actuator.
    ForceElement(ForceElementKind, [Position; 2]),
    /// A gear.
    Gear {
        /// The centre of the gear.
        at: Position,
        /// The radius of its pitch circle.
        radius: Formula,
        /// The angle by which it has turned.
        angle: Option<Formula>,
        /// Whether its teeth point inward.
        is_internal: bool,
    },
    /// A toothed rack.
    Rack {
        /// A point that moves with it.
        on: Position,
        /// The centre of the gear that rolls on it.
        wheel: Position,
        /// The radius of that gear; negative if it rolls on the right-hand side of the rack.
        radius: Formula,
        /// The direction of the rack.
        angle: Option<Formula>,
    },
    /// A belt over two pulleys.
    Belt {
        /// The centres of the pulleys.
        at: [Position; 2],
        /// The radii of the pulleys.
        radii: [Formula; 2],
        /// Whether the belt crosses itself.
        is_crossed: bool,
        /// The angle by which the first pulley has turned relative to the line between the centres.
        angle: Option<Formula>,
    },
    /// A cam.
    Cam {
        /// The centre of the cam.
        at: Position,
        /// The angle by which it has turned.
        angle: Option<Formula>,
        /// The radius of the cam as a function of the polar angle in its frame, or the distance of a face as a function
        /// of the angle of its normal.
        profile: Formula,
        /// Whether the follower has a flat face.
        is_flat: bool,
    },
    /// The path of a point.
    Path(Identifier),
}

/// The kinds of force elements between two points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum ForceElementKind {
    /// A spring.
    Spring,
    /// A damper.
    Damper,
    /// A cylinder that pushes or pulls.
    Actuator,
}

impl ForceElementKind {
    /// The key of the element in a scene file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Spring => "spring",
            Self::Damper => "damper",
            Self::Actuator => "actuator",
        }
    }
}

const KINDS: [&str; 13] =
    ["link", "rod", "block", "pivot", "guide", "spring", "damper", "actuator", "gear", "rack", "belt", "cam", "path"];

pub(super) fn drawn(r: &mut Reader, identifier: &Identifier, value: reader::Value) -> Option<DrawnSyntax> {
    let table = r.table(&format!("drawing of `{}`", identifier.name), value)?;
    let kind = table.one_of(r, &KINDS, "a part of a drawing is of one kind")?;
    let asked = table.required(r, kind)?;
    let force_element = |r: &mut Reader, force_element: ForceElementKind| {
        ends(r, kind, asked).map(|ends| DrawnSyntax::ForceElement(force_element, ends))
    };
    let drawn = match kind {
        "link" => places(r, asked).map(DrawnSyntax::Link),
        "guide" => places(r, asked).map(DrawnSyntax::Guide),
        "rod" => ends(r, kind, asked).map(DrawnSyntax::Rod),
        "spring" => force_element(r, ForceElementKind::Spring),
        "damper" => force_element(r, ForceElementKind::Damper),
        "actuator" => force_element(r, ForceElementKind::Actuator),
        "block" => {
            let angle = angle(r, &table);
            let on = table.optional("on").and_then(|v| position(r, v));
            position(r, asked).map(|at| DrawnSyntax::Block { at, angle, on })
        }
        "gear" => {
            let (radius, angle) = (length(r, &table, "radius"), angle(r, &table));
            let is_internal = table.optional("internal").is_some_and(|v| r.boolean(v));
            position(r, asked).map(|at| DrawnSyntax::Gear { at, radius, angle, is_internal })
        }
        "rack" => {
            let (radius, angle) = (length(r, &table, "radius"), angle(r, &table));
            ends(r, kind, asked).map(|[on, wheel]| DrawnSyntax::Rack { on, wheel, radius, angle })
        }
        "belt" => {
            let radii = table.required(r, "radii").map(|v| r.pair(v, "m"));
            let is_crossed = table.optional("crossed").is_some_and(|v| r.boolean(v));
            let angle = angle(r, &table);
            let at = ends(r, kind, asked);
            at.zip(radii).map(|(at, radii)| DrawnSyntax::Belt { at, radii, is_crossed, angle })
        }
        "cam" => {
            let (profile, angle) = (length(r, &table, "profile"), angle(r, &table));
            let is_flat = table.optional("flat").is_some_and(|v| r.boolean(v));
            position(r, asked).map(|at| DrawnSyntax::Cam { at, angle, profile, is_flat })
        }
        "pivot" => position(r, asked).map(DrawnSyntax::Pivot),
        _ => r.text(asked).map(DrawnSyntax::Path),
    };
    table.finish(r);
    drawn
}

/// Reads an angle.
fn angle(r: &mut Reader, table: &Table) -> Option<Formula> {
    table.optional("angle").map(|v| r.quantity(v, "rad"))
}

/// Reads a length.
fn length(r: &mut Reader, table: &Table, key: &str) -> Formula {
    table.required(r, key).map_or_else(reader::placeholder, |v| r.quantity(v, "m"))
}

/// Reads two or more positions.
fn places(r: &mut Reader, value: reader::Value) -> Option<Vec<Position>> {
    let items = list(r, value)?;
    if items.len() < 2 {
        let error = Diagnostic::error("a line needs two places or more", value.span(), "too few");
        r.findings.push(error.help(HELP));
        return None;
    }
    items.into_iter().map(|item| position(r, item)).collect()
}

/// Reads two positions.
fn ends(r: &mut Reader, key: &str, value: reader::Value) -> Option<[Position; 2]> {
    let items = list(r, value)?;
    let [first, second] = items[..] else {
        let error =
            Diagnostic::error(format!("`{key}` needs two places"), value.span(), format!("{} given", items.len()));
        r.findings.push(error.help(HELP));
        return None;
    };
    let (first, second) = (position(r, first), position(r, second));
    Some([first?, second?])
}

fn list<'t, 'v>(r: &mut Reader, value: reader::Value<'t, 'v>) -> Option<Vec<reader::Value<'t, 'v>>> {
    if !value.is_array() {
        r.wrong_type(value, "an array of places");
        return None;
    }
    Some(r.array(value))
}

const HELP: &str = "name points, or give places as `['x', 'y']`: `[\"A\", ['0', '0.3']]`";
