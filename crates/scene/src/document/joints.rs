//! `[joints]`: the connections between links.

use super::reader::{self, Reader};
use super::table::Table;
use super::values::side;
use super::{Identifier, Side};
use crate::diagnostic::Diagnostic;
use crate::linkage::terms;
use crate::parser::Formula;

/// An entry of `[joints]`.
#[derive(Debug)]
pub struct JointSyntax {
    /// The name of the joint.
    pub identifier: Identifier,
    /// The kind of the joint.
    pub kind: JointKind,
    /// Whether a rod is a cylinder, which drives its length.
    pub is_cylinder: bool,
    /// The points that it joins.
    pub ends: Vec<LinkPoint>,
    /// The direction of a line in the frame of the second link.
    pub direction: Option<Formula>,
    /// The angle of the first link minus that of the second one, if the joint holds it.
    pub rotation: Option<Formula>,
    /// The length of a rod or cylinder, the radius of a rolling link, or the ratio of gears or pulleys.
    pub size: Option<Formula>,
    /// The link that carries the axes of gears.
    pub carrier: Option<LinkPoint>,
    /// The radii of the pulleys of a belt.
    pub radii: Option<[Formula; 2]>,
    /// The profile of a cam, as a function of the angle `theta` in its frame.
    pub profile: Option<Formula>,
    /// The direction of a follower's face in the frame of its link; `None` if the follower is a point.
    pub face: Option<Formula>,
    /// The side towards which the residual of its constraint may move.
    pub one_sided: Option<Side>,
    /// The angle or displacement of the first link in addition to the one that the second link imposes.
    pub phase: Option<Formula>,
    /// The approximate position of the joint at the start.
    pub near: Option<[Formula; 2]>,
    /// The angle or length of the joint as a function of time.
    pub drive: Option<Formula>,
    /// The length of a slider, or the contact angle of a cam, at the start.
    pub start: Option<Formula>,
    /// The rate of the slider's length or the cam's angle at the start; if present, length and rate are both given.
    pub rate: Option<Formula>,
    /// The dry friction of the joint.
    pub friction: Option<JointFriction>,
    /// The description of the joint.
    pub doc: String,
}

/// The dry friction of a pin or a slider.
#[derive(Debug)]
pub struct JointFriction {
    /// The coefficient of friction.
    pub mu: Formula,
    /// The radius of the pin; `None` for a slider.
    pub radius: Option<Formula>,
    /// The sliding speed at which friction reaches three quarters of its full size.
    pub slip: Formula,
}

/// A point of a link, `"link.point"`; the point defaults to the name of the joint. Gears have no points.
#[derive(Clone, Debug)]
pub struct LinkPoint {
    /// The link.
    pub link: Identifier,
    /// The point.
    pub point: Option<Identifier>,
}

/// Kinds of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Points of two or more links coincide.
    Revolute,
    /// A point of the first link lies on a line of the second one, and the links cannot turn relative to each other.
    Prismatic,
    /// A point of the first link lies on a line of the second one.
    PinInSlot,
    /// Points of two links coincide, and the links cannot turn relative to each other.
    Weld,
    /// Points of two links have a constant distance.
    Rod,
    /// The angle of the first link is proportional to that of the second one: gears, belts, rolling on a circle.
    Gear,
    /// The first link rolls along a line of the second one.
    Rack,
    /// The first link follows a profile of the second one.
    Cam,
}

/// The key of a rod whose length is driven.
const CYLINDER: &str = "cylinder";

impl JointKind {
    /// All kinds with their keys in a scene file.
    pub const ALL: [(&str, Self); 10] = [
        ("revolute", Self::Revolute),
        ("prismatic", Self::Prismatic),
        ("pin_in_slot", Self::PinInSlot),
        ("weld", Self::Weld),
        ("rod", Self::Rod),
        (CYLINDER, Self::Rod),
        ("gear", Self::Gear),
        ("belt", Self::Gear),
        ("rack", Self::Rack),
        ("cam", Self::Cam),
    ];

    /// Whether the joint can be one-sided: a single constraint then has its name.
    fn can_be_one_sided(self) -> bool {
        matches!(self, Self::PinInSlot | Self::Rod | Self::Cam)
    }

    /// Whether a point slides along a line.
    pub fn is_slider(self) -> bool {
        matches!(self, Self::Prismatic | Self::PinInSlot)
    }

    /// Whether points coincide.
    pub fn is_pin(self) -> bool {
        matches!(self, Self::Revolute | Self::Weld)
    }

    /// Whether the links cannot turn relative to each other.
    pub fn holds_angle(self) -> bool {
        matches!(self, Self::Prismatic | Self::Weld)
    }
}

/// Reads an entry of `[joints]`.
pub(super) fn joint(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<JointSyntax> {
    let what = format!("joint `{}`", identifier.name);
    let table = r.table(&what, value)?;
    let keys = JointKind::ALL.map(|(key, _)| key);
    let key = table.one_of(r, &keys, "a joint is of one kind, and joins the links of its list")?;
    let kind = JointKind::ALL.into_iter().find(|(own, _)| *own == key)?.1;
    let list = table.required(r, key)?;
    let ends: Vec<LinkPoint> =
        r.array(list).into_iter().filter_map(|value| r.text(value)).map(|text| end(&text, &identifier, kind)).collect();
    let joined = if kind == JointKind::Revolute { "two links or more" } else { "two links" };
    if ends.len() < 2 || (ends.len() > 2 && kind != JointKind::Revolute) {
        let error = Diagnostic::error(format!("{what} joins {joined}"), list.span(), format!("{} given", ends.len()));
        r.findings.push(error.help(format!("write `{key} = [\"LINK\", \"LINK\"]`, or `\"LINK.POINT\"` for a link")));
        return None;
    }
    let mut angle = |key: &str, has: bool| has.then(|| table.optional(key)).flatten().map(|v| r.angle(v));
    let direction = angle("direction", kind.is_slider() || kind == JointKind::Rack);
    let phase_angle = angle("phase", kind == JointKind::Gear);
    let rotation = angle("rotation", kind.holds_angle());
    let face = angle("face", kind == JointKind::Cam);
    let mut quantity =
        |key: &str, has: bool, unit: &str| has.then(|| table.optional(key)).flatten().map(|v| r.quantity(v, unit));
    // That of a rack is a length.
    let phase = quantity("phase", kind == JointKind::Rack, "m").or(phase_angle);
    let is_driven = matches!(kind, JointKind::Revolute | JointKind::Prismatic | JointKind::PinInSlot);
    let drive = quantity("drive", is_driven, if kind.is_slider() { "m" } else { "rad" });
    let start =
        quantity("start", kind.is_slider() || kind == JointKind::Cam, if kind.is_slider() { "m" } else { "rad" });
    let rate = quantity("rate", kind.is_slider(), "m/s");
    let needed = |r: &mut Reader, key: &str, unit: &str| {
        table.required(r, key).map_or_else(reader::placeholder, |v| r.quantity(v, unit))
    };
    let radii = (key == "belt").then(|| radii_of_belt(r, &table)).flatten();
    let size = match key {
        "rod" | CYLINDER => Some(needed(r, "length", "m")),
        "gear" => Some(needed(r, "ratio", "-")),
        "rack" => Some(needed(r, "radius", "m")),
        "belt" => Some(radii.as_ref().map_or_else(reader::placeholder, |(_, ratio)| ratio.clone())),
        _ => None,
    };
    let radii = radii.map(|(radii, _)| radii);
    r.declarations.declare("theta", "rad");
    let profile = (kind == JointKind::Cam).then(|| needed(r, "profile", "m"));
    r.declarations.remove("theta");
    let side_of = kind.can_be_one_sided().then(|| table.optional("one_sided")).flatten();
    let one_sided = side_of.and_then(|v| r.text(v)).and_then(|text| side(r, &text));
    let carrier = (kind == JointKind::Gear).then(|| table.optional("carrier")).flatten();
    let carrier = carrier.and_then(|v| r.text(v)).map(|text| end(&text, &identifier, kind));
    let near = (kind != JointKind::Gear).then(|| table.optional("near")).flatten().map(|v| r.pair(v, "m"));
    let has_friction = kind == JointKind::Revolute || kind.is_slider();
    let friction = has_friction.then(|| table.optional("friction")).flatten();
    let friction = friction.and_then(|v| friction_of(r, &what, v, kind.is_slider()));
    let doc = table.string(r, "doc");
    table.finish(r);
    Some(JointSyntax {
        identifier,
        kind,
        is_cylinder: key == CYLINDER,
        ends,
        direction,
        rotation,
        size,
        carrier,
        radii,
        profile,
        face,
        one_sided,
        phase,
        near,
        drive,
        start,
        rate,
        friction,
        doc,
    })
}

/// Reads `radii = [r1, r2]` of pulleys, and `crossed`; also returns the ratio of the radii.
fn radii_of_belt(r: &mut Reader, table: &Table) -> Option<([Formula; 2], Formula)> {
    let radii = table.required(r, "radii").map(|v| r.pair(v, "m"));
    let is_crossed = table.optional("crossed").is_some_and(|v| r.boolean(v));
    let radii = radii?;
    let [first, second] = radii.clone();
    let ratio = terms::divide(second, first);
    Some((radii, if is_crossed { terms::negate(ratio) } else { ratio }))
}

/// Reads `friction = { mu = ..., radius = ..., slip = ... }`; sliders have no radius.
fn friction_of(r: &mut Reader, joint: &str, value: reader::Value, is_slider: bool) -> Option<JointFriction> {
    let table = r.table(&format!("the friction of {joint}"), value)?;
    let mut quantity = |key: &str, unit: &str| table.required(r, key).map(|v| r.quantity(v, unit));
    let (mu, slip) = (quantity("mu", "-"), quantity("slip", "m/s"));
    let radius = if is_slider { Some(None) } else { quantity("radius", "m").map(Some) };
    table.finish(r);
    Some(JointFriction { mu: mu?, radius: radius?, slip: slip? })
}

fn end(text: &Identifier, joint: &Identifier, kind: JointKind) -> LinkPoint {
    let part = |name: &str| Identifier { name: name.trim().to_owned(), span: text.span.clone() };
    let (link, point) = match text.name.split_once('.') {
        Some((link, point)) => (link, Some(point)),
        None => (text.name.as_str(), (kind != JointKind::Gear).then_some(joint.name.as_str())),
    };
    LinkPoint { link: part(link), point: point.map(part) }
}
