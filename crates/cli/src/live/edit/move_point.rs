//! A point that is moved: lengths, angles and places that follow it.

use std::f64::consts::PI;

use qrm_scene::resolve;
use toml_edit::{Item, TableLike};

use super::constant_term::with_change;
use super::frame::Frame;
use super::linkage::{GROUND, Joint, LinkPoint, Linkage, point_of};
use super::number;
use super::places::{Places, direction, distance};
use super::toml_text::{Place, formula, replace};

/// Moves a point of all links that have it; all other points stay where they are.
pub(super) fn move_point(linkage: &mut Linkage, places: &Places, node: &str, to: [f64; 2]) -> Result<(), String> {
    let points = linkage.points_at(node)?;
    let resolution = places.resolution(&[to]);
    let to = on_lines(linkage, places, &points, to)?;
    for each in &points {
        move_in_link(linkage, places, each, to, resolution)?;
    }
    move_rods(linkage, places, &points, to, resolution)?;
    for joint in linkage.joints() {
        let is_near = linkage.key("joints", &joint.name, "near").is_some();
        // Of a slider, `near` is the place of the point of the first link.
        let count = if joint.kind == "revolute" { joint.members.len() } else { 1 };
        let is_here = joint.members.iter().take(count).any(|each| points.contains(each));
        if is_near && is_here {
            for axis in [0, 1] {
                let place: Place = (&["joints", &joint.name, "near"], Some(axis));
                number::set(&mut linkage.document, place, to[axis], resolution)?;
            }
        }
    }
    Ok(())
}

/// Projects the target onto the line of the ground that guides the point, if there is one.
///
/// # Errors
/// A joint that is no pin holds the point, and other points would not stay where they are.
fn on_lines(linkage: &Linkage, places: &Places, points: &[LinkPoint], to: [f64; 2]) -> Result<[f64; 2], String> {
    let mut to = to;
    for joint in linkage.joints() {
        let Joint { name, kind, members, .. } = &joint;
        let [moving, line] = members.as_slice() else { continue };
        let is_held = [moving, line].map(|each| points.contains(each));
        if is_held == [false, false] {
            continue;
        }
        if !["pin_in_slot", "prismatic"].contains(kind) {
            if ["rack", "cam", "gear", "belt"].contains(kind) {
                return Err(format!("joint `{name}` holds the point: the mouse cannot move it"));
            }
            continue;
        }
        if line.link != GROUND {
            return Err(format!("joint `{name}` slides along link `{}`, which would turn", line.link));
        }
        let keys = ["joints", name, "direction"];
        let has_direction = linkage.key("joints", name, "direction").is_some();
        let angle = if has_direction { number::get(&linkage.document, (&keys, None)) } else { Some(0.0) };
        let angle = angle.ok_or_else(|| format!("the `direction` of joint `{name}` is a formula"))?;
        let [x, y] = places.place_of(linkage, line)?;
        let (sin, cos) = angle.sin_cos();
        let along = (to[0] - x) * cos + (to[1] - y) * sin;
        to = [x + along * cos, y + along * sin];
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
    let corners = &points[..linkage.corner_count(link)];
    if let Some(corner) = corners.iter().position(|own| own == point) {
        return move_corner(linkage, places, link, corners, (corner, to), resolution);
    }
    if link != GROUND && points.len() == 1 {
        // The link moves with its point.
        return Ok(());
    }
    let place = if link == GROUND { to } else { Frame::at_start(linkage, places, link)?.local(to) };
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
    let before = Frame::at_start(linkage, places, link)?.angle;
    let mut at =
        corners.iter().map(|own| places.place_of(linkage, &point_of(link, own))).collect::<Result<Vec<_>, String>>()?;
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
    let frame = Frame { origin: at[0], angle: direction(at[0], at[1]) };
    // The other points of the link stay where they are.
    for point in &linkage.points_of(link)[corners.len()..] {
        let place = frame.local(places.place_of(linkage, &point_of(link, point))?);
        for axis in [0, 1] {
            number::set(
                &mut linkage.document,
                (&["links", link, "points", point], Some(axis)),
                place[axis],
                resolution,
            )?;
        }
    }
    turn(linkage, link, frame.angle, before)
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
    let now = linkage.key("joints", joint, key).and_then(Item::as_str).map(str::to_owned);
    let Some(now) = now.filter(|_| change.abs() > 0.5 * resolution) else { return Ok(()) };
    let reads = with_change(&now, change, units, resolution).into_iter().any(|new| {
        let set = |entry: &mut dyn TableLike| {
            entry.get_mut(key).and_then(Item::as_value_mut).map(|value| replace(value, formula(&new)))
        };
        linkage.change_entry("joints", joint, set).is_ok() && resolve::read("", &linkage.text()).is_ok()
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
        let other = places.place_of(linkage, other)?;
        let length = distance(other, to);
        let place: Place = (&["joints", &joint.name, "length"], None);
        if joint.kind == "rod" || number::get(&linkage.document, place).is_some() {
            number::set(&mut linkage.document, place, length, resolution)?;
        } else {
            let change = length - distance(other, places.place_of(linkage, own)?);
            change_sum(linkage, &joint.name, "length", change, ["m", ""], resolution)?;
        }
    }
    Ok(())
}
