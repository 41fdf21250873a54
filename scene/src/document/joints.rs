//! `[joints]`: what holds links together.

use super::Identifier;
use super::table::{self, Reader};
use crate::diagnostic::Diagnostic;
use crate::parser::Formula;

/// An entry of `[joints]`.
#[derive(Debug)]
pub struct JointSyntax {
    /// Its name.
    pub identifier: Identifier,
    /// What it holds.
    pub kind: JointKind,
    /// The points that it joins.
    pub ends: Vec<LinkPoint>,
    /// The direction of a line in the frame of the second link.
    pub direction: Option<Formula>,
    /// The angle of the first link less that of the second one, where the joint holds it.
    pub rotation: Option<Formula>,
    /// The length of a rod.
    pub length: Option<Formula>,
    /// Its rough position at the start.
    pub near: Option<[Formula; 2]>,
    /// The angle or length that the joint has as a function of time.
    pub drive: Option<Formula>,
    /// The length of a slider at the start.
    pub start: Option<Formula>,
    /// Its rate; length and rate are given with it.
    pub rate: Option<Formula>,
    /// What it is.
    pub doc: String,
}

/// A point of a link, `"link.point"`; the name of the joint is that of the point where none is given.
#[derive(Clone, Debug)]
pub struct LinkPoint {
    /// The link.
    pub link: Identifier,
    /// The point.
    pub point: Identifier,
}

/// Kinds of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Points of two or more links are in one place.
    Revolute,
    /// A point of the first link is on a line of the second one, and the links do not turn against each other.
    Prismatic,
    /// A point of the first link is on a line of the second one.
    PinInSlot,
    /// Points of two links are in one place, and the links do not turn against each other.
    Weld,
    /// Points of two links have a fixed distance.
    Rod,
}

impl JointKind {
    /// All of them, by the keys that they are written with.
    pub const ALL: [(&str, Self); 5] = [
        ("revolute", Self::Revolute),
        ("prismatic", Self::Prismatic),
        ("pin_in_slot", Self::PinInSlot),
        ("weld", Self::Weld),
        ("rod", Self::Rod),
    ];

    /// Whether a point slides along a line.
    pub fn is_slider(self) -> bool {
        matches!(self, Self::Prismatic | Self::PinInSlot)
    }

    /// Whether points are in one place.
    pub fn is_pin(self) -> bool {
        matches!(self, Self::Revolute | Self::Weld)
    }

    /// Whether the links do not turn against each other.
    pub fn holds_angle(self) -> bool {
        matches!(self, Self::Prismatic | Self::Weld)
    }
}

/// Reads an entry of `[joints]`.
pub(super) fn joint(r: &mut Reader, identifier: Identifier, value: table::Value) -> Option<JointSyntax> {
    let what = format!("joint `{}`", identifier.name);
    let table = r.table(&what, value)?;
    let keys = JointKind::ALL.map(|(key, _)| key);
    let key = table.one_of(r, &keys, "a joint is of one kind, and joins the links of its list")?;
    let kind = JointKind::ALL.into_iter().find(|(own, _)| *own == key)?.1;
    let list = table.required(r, key)?;
    let ends: Vec<LinkPoint> =
        r.array(list).into_iter().filter_map(|value| r.text(value)).map(|text| end(&text, &identifier)).collect();
    let joined = if kind == JointKind::Revolute { "two links or more" } else { "two links" };
    if ends.len() < 2 || (ends.len() > 2 && kind != JointKind::Revolute) {
        let error = Diagnostic::error(format!("{what} joins {joined}"), list.span(), format!("{} given", ends.len()));
        r.findings.push(error.help(format!("write `{key} = [\"LINK\", \"LINK\"]`, or `\"LINK.POINT\"` for a link")));
        return None;
    }
    let mut formula = |key: &str, has: bool| has.then(|| table.optional(key)).flatten().map(|v| r.formula(v));
    let direction = formula("direction", kind.is_slider());
    let rotation = formula("rotation", kind.holds_angle());
    let drive = formula("drive", matches!(kind, JointKind::Revolute | JointKind::Prismatic | JointKind::PinInSlot));
    let (start, rate) = (formula("start", kind.is_slider()), formula("rate", kind.is_slider()));
    let length =
        (kind == JointKind::Rod).then(|| table.required(r, "length").map_or_else(table::placeholder, |v| r.formula(v)));
    let near = table.optional("near").map(|v| r.pair(v));
    let doc = table.string(r, "doc");
    table.finish(r);
    Some(JointSyntax { identifier, kind, ends, direction, rotation, length, near, drive, start, rate, doc })
}

fn end(text: &Identifier, joint: &Identifier) -> LinkPoint {
    let (link, point) = text.name.split_once('.').unwrap_or((&text.name, &joint.name));
    let part = |name: &str| Identifier { name: name.trim().to_owned(), span: text.span.clone() };
    LinkPoint { link: part(link), point: part(point) }
}
