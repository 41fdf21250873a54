//! A point that is moved: lengths, angles and places that follow it.

use std::f64::consts::PI;

use qrm_scene::resolve;
use toml_edit::Item;

use super::angle::with_change;
use super::linkage::{GROUND, LinkPoint, Linkage, formula, point_of};
use super::number::{self, Place, replace};
use super::places::{Places, direction, distance};

/// Moves a point of all links that have it; all other points stay where they are.
pub(super) fn run(linkage: &mut Linkage, places: &Places, node: &str, to: [f64; 2]) -> Result<String, String> {
    let points = linkage.points_at(node)?;
    let resolution = places.resolution(&[to]);
    let to = on_lines(linkage, places, &points, to)?;
    for each in &points {
        move_in_link(linkage, places, each, to, resolution)?;
    }
    move_rods(linkage, places, &points, to, resolution)?;
    for joint in linkage.joints() {
        let is_near = linkage.key("joints", &joint.name, "near").is_some();
        let is_here =
            joint.members.iter().take(if joint.kind == "revolute" { 9 } else { 1 }).any(|each| points.contains(each));
        if is_near && is_here {
            for axis in [0, 1] {
                let place: Place = (&["joints", &joint.name, "near"], Some(axis));
                number::set(&mut linkage.document, place, to[axis], resolution)?;
            }
        }
    }
    Ok(node.to_owned())
}

/// The position of a link.
pub(super) struct Frame {
    origin: [f64; 2],
    pub(super) angle: f64,
}

impl Frame {
    /// The position of the frame of a link.
    pub(super) fn of(linkage: &Linkage, places: &Places, link: &str) -> Result<Self, String> {
        let points: Vec<LinkPoint> = linkage.points_of(link).iter().map(|point| point_of(link, point)).collect();
        let place = |index: usize| places.of(linkage, &points[index]);
        if corner_count(linkage, link) > 0 {
            let [origin, end] = [place(0)?, place(1)?];
            return Ok(Self { origin, angle: direction(origin, end) });
        }
        let own = |index: usize| {
            let LinkPoint { link, point } = &points[index];
            linkage.own_place(link, point).ok_or_else(|| format!("point `{point}` of link `{link}` is a formula"))
        };
        if points.len() < 2 {
            return Err(format!("link `{link}` has one point, so its angle is not seen in the drawing"));
        }
        let [a, b] = [own(0)?, own(1)?];
        let angle = direction(place(0)?, place(1)?) - direction(a, b);
        let [x, y] = place(0)?;
        let (sin, cos) = angle.sin_cos();
        Ok(Self { origin: [x - (a[0] * cos - a[1] * sin), y - (a[0] * sin + a[1] * cos)], angle })
    }

    /// A place in the frame of the link.
    pub(super) fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        let [x, y] = [x - self.origin[0], y - self.origin[1]];
        [x * cos + y * sin, y * cos - x * sin]
    }
}

/// The number of corners of a bar or a triangle; 0 for another link.
fn corner_count(linkage: &Linkage, link: &str) -> usize {
    let has = |key| linkage.key("links", link, key).is_some();
    if has("bar") {
        2
    } else if has("triangle") {
        3
    } else {
        0
    }
}

/// The place next to one that is wanted on the line of the ground that holds the point.
fn on_lines(linkage: &Linkage, places: &Places, points: &[LinkPoint], to: [f64; 2]) -> Result<[f64; 2], String> {
    for joint in linkage.joints().iter().filter(|joint| ["pin_in_slot", "prismatic"].contains(&joint.kind)) {
        let [moving, line] = joint.members.as_slice() else { continue };
        if !points.contains(moving) || line.link != GROUND {
            continue;
        }
        let keys = ["joints", &joint.name, "direction"];
        let has_direction = linkage.key("joints", &joint.name, "direction").is_some();
        let angle = if has_direction { number::get(&linkage.document, (&keys, None)) } else { Some(0.0) };
        let angle = angle.ok_or_else(|| format!("the `direction` of joint `{}` is a formula", joint.name))?;
        let [x, y] = places.of(linkage, line)?;
        let (sin, cos) = angle.sin_cos();
        let along = (to[0] - x) * cos + (to[1] - y) * sin;
        return Ok([x + along * cos, y + along * sin]);
    }
    Ok(to)
}

/// Moves a point in its link.
fn move_in_link(
    linkage: &mut Linkage,
    places: &Places,
    moved: &LinkPoint,
    to: [f64; 2],
    resolution: f64,
) -> Result<(), String> {
    let LinkPoint { link, point } = moved;
    let points = linkage.points_of(link);
    let corners = &points[..corner_count(linkage, link)];
    if let Some(corner) = corners.iter().position(|own| own == point) {
        return move_corner(linkage, places, link, corners, (corner, to), resolution);
    }
    if link != GROUND && points.len() == 1 {
        // The link moves with its point.
        return Ok(());
    }
    let place = if link == GROUND { to } else { Frame::of(linkage, places, link)?.local(to) };
    for axis in [0, 1] {
        let keys = ["links", link.as_str(), "points", point.as_str()];
        number::set(&mut linkage.document, (&keys, Some(axis)), place[axis], resolution)?;
    }
    Ok(())
}

/// Moves an end of a bar or a corner of a triangle: sides, and the angle of the link, follow.
fn move_corner(
    linkage: &mut Linkage,
    places: &Places,
    link: &str,
    corners: &[String],
    (corner, to): (usize, [f64; 2]),
    resolution: f64,
) -> Result<(), String> {
    let before = Frame::of(linkage, places, link)?.angle;
    let mut at =
        corners.iter().map(|own| places.of(linkage, &point_of(link, own))).collect::<Result<Vec<_>, String>>()?;
    let length = ["links", link, "length"];
    let sides = ["links", link, "sides"];
    let written: Vec<Place> = match corners.len() {
        2 => vec![(&length, None)],
        _ => (0..3).map(|side| (&sides[..], Some(side))).collect(),
    };
    let side = |at: &[[f64; 2]], side: usize| distance(at[side], at[(side + 1) % at.len()]);
    for (number, place) in written.iter().enumerate() {
        let shown = side(&at, number);
        let known = number::get(&linkage.document, *place);
        if known.is_some_and(|known| (known - shown).abs() > 0.01 * shown + 2.0 * resolution) {
            return Err("the page does not show the file as it is: wait for it, or undo the last change".to_owned());
        }
    }
    at[corner] = to;
    if let [a, b, c] = at.as_slice()
        && (b[0] - a[0]) * (c[1] - a[1]) <= (b[1] - a[1]) * (c[0] - a[0])
    {
        return Err(format!("triangle `{link}` would turn over: list its corners in the other order"));
    }
    for (number, place) in written.into_iter().enumerate() {
        let length = side(&at, number);
        if length <= resolution {
            return Err(format!("link `{link}` would have no length"));
        }
        number::set(&mut linkage.document, place, length, resolution)?;
    }
    turn(linkage, link, direction(at[0], at[1]), before)
}

/// Writes the angle of a link at the start, where the file has it: as its `angle`, or in the `drive` of a joint.
fn turn(linkage: &mut Linkage, link: &str, angle: f64, before: f64) -> Result<(), String> {
    if linkage.key("links", link, "angle").is_some() {
        number::set(&mut linkage.document, (&["links", link, "angle"], None), angle, 1e-4)?;
    }
    let change = (angle - before + PI).rem_euclid(2.0 * PI) - PI;
    if change.abs() > 1e-6
        && let Some(joint) = linkage.tie_of(link)
    {
        return Err(format!("joint `{joint}` ties the angle of link `{link}`: it cannot be turned alone"));
    }
    for joint in linkage.joints().iter().filter(|joint| joint.kind == "revolute") {
        if let Some(place) = joint.members.iter().position(|each| each.link == link) {
            let change = if place == 0 { change } else { -change };
            change_sum(linkage, &joint.name, "drive", change, ["deg", ""], 1e-4)?;
        }
    }
    Ok(())
}

/// Changes the constant in a formula of a joint, if it has this key.
fn change_sum(
    linkage: &mut Linkage,
    joint: &str,
    key: &str,
    change: f64,
    units: [&str; 2],
    resolution: f64,
) -> Result<(), String> {
    let Some(formula_now) = linkage.key("joints", joint, key).and_then(Item::as_str).map(str::to_owned) else {
        return Ok(());
    };
    let reads = with_change(&formula_now, change, units, resolution).into_iter().any(|new| {
        let entry = linkage.entry("joints", joint);
        let value = entry.ok().and_then(|entry| entry.get_mut(key)).and_then(Item::as_value_mut);
        let is_set = value.map(|value| replace(value, formula(&new))).is_some();
        is_set && resolve::read("", &linkage.text()).is_ok()
    });
    if reads { Ok(()) } else { Err(format!("a constant cannot be added to the `{key}` of joint `{joint}`")) }
}

/// Sets the lengths of rods and cylinders that end at a point.
fn move_rods(
    linkage: &mut Linkage,
    places: &Places,
    points: &[LinkPoint],
    to: [f64; 2],
    resolution: f64,
) -> Result<(), String> {
    for joint in linkage.joints().iter().filter(|joint| ["rod", "cylinder"].contains(&joint.kind)) {
        let [a, b] = joint.members.as_slice() else { continue };
        let (own, other) = match (points.contains(a), points.contains(b)) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ => continue,
        };
        let other = places.of(linkage, other)?;
        let length = distance(other, to);
        let place: Place = (&["joints", &joint.name, "length"], None);
        if joint.kind == "rod" || number::get(&linkage.document, place).is_some() {
            number::set(&mut linkage.document, place, length, resolution)?;
        } else {
            let change = length - distance(other, places.of(linkage, own)?);
            change_sum(linkage, &joint.name, "length", change, ["m", ""], resolution)?;
        }
    }
    Ok(())
}
