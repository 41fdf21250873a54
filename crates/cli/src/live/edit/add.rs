//! Bars, points, joints and drives that are added to a linkage.

use std::f64::consts::TAU;

use toml_edit::{Array, InlineTable, Item, Value};

use super::End;
use super::frame::Frame;
use super::linkage::{GROUND, Joint, LinkPoint, Linkage, member, point_of};
use super::number::{degrees, rounded};
use super::places::{Places, direction, distance};
use super::toggle;
use super::toml_text::{change_table, formula, texts};

/// The rate of a new drive: a turn in a second.
const RATE: &str = "60rpm*t";
/// The mass of a new bar in kg, so that joints have forces.
const MASS: i64 = 1;

/// Adds a bar; a start without a point is pinned to the ground. Returns the points at its ends.
pub(super) fn bar(linkage: &mut Linkage, places: &Places, from: &End, to: &End) -> Result<[String; 2], String> {
    let own = (1..).map(|number| format!("bar{number}")).find(|name| !linkage.is_used(name)).unwrap_or_default();
    let start = BarEnd::new(linkage, places, from, "")?;
    let end = BarEnd::new(linkage, places, to, &start.name)?;
    if end.points.iter().any(|each| start.points.iter().any(|other| each.link == other.link)) {
        return Err("both points are on one link already".to_owned());
    }
    let resolution = places.resolution(&[start.place, end.place]);
    let length = rounded(distance(start.place, end.place), resolution);
    if length <= 0.0 {
        return Err("a bar needs two points that are apart".to_owned());
    }
    let mut link = InlineTable::new();
    link.insert("bar", Value::Array(texts([&start.name, &end.name])));
    link.insert("length", length.into());
    link.insert("mass", MASS.into());
    link.insert("angle", formula(&degrees(direction(start.place, end.place))));
    linkage.section("links")?.insert(&own, Item::Value(link.into()));
    if start.points.is_empty() {
        add_ground_point(linkage, &start.name, start.place, resolution)?;
        join(linkage, &[point_of(&own, &start.name)], &point_of(GROUND, &start.name))?;
    } else {
        join(linkage, &start.points, &point_of(&own, &start.name))?;
    }
    if !end.points.is_empty() {
        join(linkage, &end.points, &point_of(&own, &end.name))?;
    }
    Ok([start.name, end.name])
}

/// An end of a new bar: the name of its point, its place, and the points of links that are there.
struct BarEnd {
    name: String,
    place: [f64; 2],
    points: Vec<LinkPoint>,
}

impl BarEnd {
    /// An end; a new point has another name than the one at the other end.
    fn new(linkage: &Linkage, places: &Places, end: &End, other: &str) -> Result<Self, String> {
        Ok(match end {
            End::Point(node) => {
                let points = linkage.points_at(node)?;
                Self { name: points[0].point.clone(), place: places.place_of(linkage, &points[0])?, points }
            }
            End::Place(place) => Self { name: linkage.point_name(other), place: *place, points: Vec::new() },
        })
    }
}

/// Adds a point to a link, with its path.
pub(super) fn point(linkage: &mut Linkage, places: &Places, link: &str, to: [f64; 2]) -> Result<(), String> {
    linkage.change_entry("links", link, |_| ())?;
    let name = linkage.point_name("");
    let place = if link == GROUND { to } else { Frame::at_start(linkage, places, link)?.local(to) };
    add_point(linkage, link, &name, place, places.resolution(&[to]))?;
    if link != GROUND {
        toggle::path(linkage, &name)?;
    }
    Ok(())
}

/// Pins a point to the ground.
pub(super) fn pin(linkage: &mut Linkage, places: &Places, node: &str) -> Result<(), String> {
    let points = moving_points_at(linkage, node)?;
    let name = points[0].point.clone();
    let place = places.place_of(linkage, &points[0])?;
    add_ground_point(linkage, &name, place, places.resolution(&[place]))?;
    join(linkage, &points, &point_of(GROUND, &name))
}

/// The points of moving links at a point of the drawing that is not on the ground.
fn moving_points_at(linkage: &Linkage, node: &str) -> Result<Vec<LinkPoint>, String> {
    let points = linkage.points_at(node)?;
    if points.iter().any(|each| each.link == GROUND) {
        return Err(format!("`{node}` is on the ground already"));
    }
    Ok(points)
}

/// Holds a point on a line of the ground.
pub(super) fn slider(linkage: &mut Linkage, places: &Places, node: &str, angle: f64) -> Result<(), String> {
    let points = moving_points_at(linkage, node)?;
    let place = places.place_of(linkage, &points[0])?;
    let line = linkage.free_name(&format!("{}0", points[0].point));
    add_ground_point(linkage, &line, place, places.resolution(&[place]))?;
    let name = linkage.free_name(&format!("guide_{}", points[0].point));
    let mut joint = InlineTable::new();
    let members = [&points[0], &point_of(GROUND, &line)].map(|each| member(each, &name));
    joint.insert("pin_in_slot", Value::Array(texts(members)));
    if angle != 0.0 {
        joint.insert("direction", formula(&degrees(angle % TAU)));
    }
    linkage.section("joints")?.insert(&name, Item::Value(joint.into()));
    Ok(())
}

/// Drives the link that is pinned to the ground at a point, or removes its drive. A point that is not pinned is pinned
/// first.
pub(super) fn drive(linkage: &mut Linkage, places: &Places, node: &str) -> Result<(), String> {
    let points = linkage.points_at(node)?;
    if !points.iter().any(|each| each.link == GROUND) {
        if points.len() > 1 {
            return Err(format!("`{node}` joins moving links: a drive turns a link that is pinned to the ground"));
        }
        pin(linkage, places, node)?;
    }
    let points = linkage.points_at(node)?;
    let on_ground = |joint: &Joint| joint.members.iter().any(|each| each.link == GROUND);
    let pins = linkage.pins_at(&points);
    let Some(joint) = pins.iter().find(|joint| on_ground(joint)) else {
        return Err(format!("no link is pinned to the ground at `{node}`"));
    };
    let [first, second] = joint.members.as_slice() else {
        return Err(format!(
            "{} links meet at `{node}`: a drive turns one link against the ground",
            joint.members.len()
        ));
    };
    let (link, sign) = if first.link == GROUND { (&second.link, -1.0) } else { (&first.link, 1.0) };
    let angle = Frame::at_start(linkage, places, link)?.angle;
    let is_new = linkage.change_entry("joints", &joint.name, |entry| {
        let is_new = entry.remove("drive").is_none();
        if is_new {
            entry.insert("drive", Item::Value(formula(&format!("{} + {RATE}", degrees(sign * angle)))));
        }
        is_new
    })?;
    // The drive says where the link is at the start.
    linkage.change_entry("links", link, |entry| {
        entry.remove("angle");
        if !is_new {
            entry.insert("angle", Item::Value(formula(&degrees(angle))));
        }
    })
}

/// Pins a point of a link to others in the same place: by a pin that is there, or by a new one.
fn join(linkage: &mut Linkage, points: &[LinkPoint], new: &LinkPoint) -> Result<(), String> {
    let pins = linkage.pins_at(points);
    if let Some(pin) = pins.iter().find(|pin| !pin.is_driven) {
        return linkage.change_entry("joints", &pin.name, |entry| {
            let list = entry.get_mut("revolute").and_then(Item::as_array_mut);
            list.into_iter().for_each(|list| list.push(member(new, &pin.name)));
        });
    }
    let has_joint = linkage.entries("joints").any(|(name, _)| name == new.point);
    let name = if has_joint { linkage.free_name(&format!("pin_{}", new.point)) } else { new.point.clone() };
    let mut joint = InlineTable::new();
    joint.insert("revolute", Value::Array(texts([&points[0], new].map(|each| member(each, &name)))));
    linkage.section("joints")?.insert(&name, Item::Value(joint.into()));
    Ok(())
}

fn add_ground_point(linkage: &mut Linkage, name: &str, place: [f64; 2], resolution: f64) -> Result<(), String> {
    if linkage.document.get("links").and_then(|links| links.get(GROUND)).is_none() {
        linkage.section("links")?.insert(GROUND, Item::Value(InlineTable::new().into()));
    }
    add_point(linkage, GROUND, name, place, resolution)
}

/// Adds a point in the frame of a link.
fn add_point(linkage: &mut Linkage, link: &str, name: &str, place: [f64; 2], resolution: f64) -> Result<(), String> {
    let place: Array = place.into_iter().map(|x| rounded(x, resolution)).collect();
    let is_added = linkage.change_entry("links", link, |entry| {
        let points = entry.entry("points").or_insert_with(|| Item::Value(InlineTable::new().into()));
        change_table(points, |points| drop(points.insert(name, Item::Value(place.into()))))
    })?;
    is_added.ok_or_else(|| format!("the points of link `{link}` are no table"))
}
