//! Reads the joints of an assembly as joints in the plane.

use std::f64::consts::{FRAC_PI_2, PI};

use super::super::linkage::{End, ImportedLinkage, Joint, Kind};
use super::super::names::Names;
use super::super::numbers::wrap_angle;
use super::super::plane::{self, Plane, Vector, scaled};
use super::super::source::Source;
use super::parts::{Marker, Parts};
use super::tree::Node;
use crate::error::Error;

const Z: Vector = [0.0, 0.0, 1.0];

/// The joints of an assembly.
pub(super) fn items<'t>(assembly: &Node<'t>) -> Vec<Node<'t>> {
    let sets = assembly.child("ConstraintSets");
    sets.and_then(|sets| sets.child("Joints")).into_iter().flat_map(|joints| joints.children()).collect()
}

/// The plane of the assembly: across the axis of its first pin.
pub(super) fn plane(source: &Source, parts: &Parts, joints: &[Node]) -> Result<Plane, Error> {
    let pins = |kind: &str| joints.iter().find(|joint| joint.text() == kind);
    for kind in ["RevoluteJoint", "CylindricalJoint"] {
        if let Some(pin) = pins(kind) {
            return Ok(Plane::across(parts.world(&parts.marker(source, pin, "MarkerI")?).axis(2)));
        }
    }
    Ok(Plane::across(Z))
}

/// The joint in the plane that a joint of space is.
enum Flat {
    Pin,
    /// Along a line in the plane, turned by this angle from the z axis of the marker.
    Slider(f64),
    Slot(f64),
    Weld,
    /// The links do not turn against each other.
    Parallel,
    Gear,
    Nothing,
}

/// Adds the joints to a linkage.
pub(super) fn add(
    source: &Source,
    parts: &Parts,
    plane: &Plane,
    items: &[Node],
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) -> Result<(), Error> {
    let mut parallel = Vec::new();
    for item in items {
        let markers = [parts.marker(source, item, "MarkerI")?, parts.marker(source, item, "MarkerJ")?];
        if markers[0].part == markers[1].part {
            let title = format!("joint `{}` joins a part with itself", item.name());
            return Err(source.error(title, item.span(), "", "give it markers of two parts"));
        }
        let kind = flat(source, parts, plane, item, &markers)?;
        let offset = item.child("offset").and_then(|node| node.first()).map(|row| row.number(source)).transpose()?;
        let [i, j] = markers.map(|marker| marker.part);
        let joined = JoinedMarkers { parts, plane, linkage, markers, offset: offset.unwrap_or(0.0) };
        let (kind, ends) = match kind {
            Flat::Pin => (Kind::Pin, joined.ends(i == 0)),
            Flat::Weld => {
                let first = usize::from(i == 0);
                (Kind::Weld { rotation: joined.rotation(first) }, joined.ends(i == 0))
            }
            // The line is on the ground, if one of the parts is.
            Flat::Slider(turn) => {
                let is_swapped = j == 0;
                let direction = joined.direction(usize::from(is_swapped)) + turn;
                let rotation = joined.rotation(usize::from(!is_swapped));
                (Kind::Slider { direction, rotation }, joined.ends(!is_swapped))
            }
            // The line of a slot stays on its own part.
            Flat::Slot(turn) => (Kind::Slot { direction: joined.direction(0) + turn }, joined.ends(true)),
            Flat::Parallel => {
                parallel.push((item.name(), [i, j], joined.rotation(1)));
                continue;
            }
            Flat::Gear => {
                let (ratio, carrier, phase) = gear(source, item, &joined, linkage)?;
                (Kind::Gear { ratio, phase, carrier }, joined.ends(true))
            }
            Flat::Nothing => continue,
        };
        let name = names.unique(item.name(), "joint");
        linkage.joints.push(Joint { name, model_name: item.name().to_owned(), kind, ends, drive: None });
    }
    for (name, links, rotation) in parallel {
        hold(linkage, names, name, links, rotation);
    }
    Ok(())
}

/// Holds the angle between two links. A point on a line becomes a slider, other links get a gear of the ratio 1.
fn hold(linkage: &mut ImportedLinkage, names: &mut Names, name: &str, [i, j]: [usize; 2], rotation: f64) {
    for joint in &mut linkage.joints {
        let ends = [joint.ends[0].link, joint.ends[1].link];
        if let Kind::Slot { direction } = joint.kind
            && (ends == [i, j] || ends == [j, i])
        {
            let rotation = if ends == [j, i] { rotation } else { -rotation };
            joint.kind = Kind::Slider { direction, rotation };
            return;
        }
    }
    let ends = [j, i].map(|link| End { link, at: [0.0; 2] }).to_vec();
    let kind = Kind::Gear { ratio: 1.0, phase: rotation, carrier: 0 };
    linkage.joints.push(Joint {
        name: names.unique(name, "joint"),
        model_name: name.to_owned(),
        kind,
        ends,
        drive: None,
    });
}

/// Finds what a joint does in the plane, by its kind and the directions of its axes.
fn flat(source: &Source, parts: &Parts, plane: &Plane, item: &Node, markers: &[Marker; 2]) -> Result<Flat, Error> {
    let axes = markers.map(|marker| parts.world(&marker).axis(2));
    let is_normal = axes.iter().all(|axis| plane.normal_sign(*axis).is_some());
    let is_flat = axes.iter().all(|axis| plane.contains(*axis));
    let is_line_flat = plane.contains(axes[0]);
    Ok(match item.text() {
        "RevoluteJoint" | "CylindricalJoint" if is_normal => Flat::Pin,
        "CylindricalJoint" | "TranslationalJoint" if is_flat => Flat::Slider(0.0),
        "TranslationalJoint" if is_normal => Flat::Weld,
        "FixedJoint" => Flat::Weld,
        "SphericalJoint" => Flat::Pin,
        "PlanarJoint" if is_normal => Flat::Nothing,
        "PlanarJoint" if is_flat => Flat::Slider(FRAC_PI_2),
        "PointInLineJoint" if plane.normal_sign(axes[0]).is_some() => Flat::Pin,
        "PointInLineJoint" if is_line_flat => Flat::Slot(0.0),
        "PointInPlaneJoint" if plane.normal_sign(axes[0]).is_some() => Flat::Nothing,
        "PointInPlaneJoint" if is_line_flat => Flat::Slot(FRAC_PI_2),
        "NoRotationJoint" => Flat::Parallel,
        "ParallelAxesJoint" if is_normal => Flat::Nothing,
        "ParallelAxesJoint" if is_flat => Flat::Parallel,
        "GearJoint" if is_normal => Flat::Gear,
        "RevoluteJoint" | "CylindricalJoint" | "TranslationalJoint" | "PlanarJoint" | "PointInLineJoint"
        | "PointInPlaneJoint" | "ParallelAxesJoint" | "GearJoint" => {
            let title =
                format!("the axis of joint `{}` is neither in the plane of the linkage nor across it", item.name());
            let label = format!("the linkage moves across the axis {:?}", plane.normal);
            let help = "a scene is a plane linkage: the axes of all pins are parallel, sliders move across them";
            return Err(source.error(title, item.span(), &label, help));
        }
        other => {
            let title = format!("joint `{}` is a `{other}`, which has no counterpart in a plane", item.name());
            let help = "use RevoluteJoint, CylindricalJoint, TranslationalJoint, FixedJoint, PlanarJoint, \
                        PointInLineJoint, PointInPlaneJoint, NoRotationJoint or GearJoint";
            return Err(source.error(title, item.span(), "a joint of another kind", help));
        }
    })
}

/// The markers I and J of a joint, in the plane.
struct JoinedMarkers<'l> {
    parts: &'l Parts,
    plane: &'l Plane,
    linkage: &'l ImportedLinkage,
    markers: [Marker; 2],
    /// The distance of a plane from marker I along its axis.
    offset: f64,
}

impl JoinedMarkers<'_> {
    /// The places of both markers on their parts. That of marker J is the first or the last.
    fn ends(&self, is_j_first: bool) -> Vec<End> {
        let end = |which: usize| {
            let Marker { part, frame } = self.markers[which];
            let place = if which == 0 { add_offset(frame.place, frame.axis(2), self.offset) } else { frame.place };
            End { link: part, at: self.parts.body(self.plane, part).project(place) }
        };
        if is_j_first { vec![end(1), end(0)] } else { vec![end(0), end(1)] }
    }

    /// The angle of the z axis of a marker, in the frame of its part.
    fn direction(&self, which: usize) -> f64 {
        let Marker { part, frame } = self.markers[which];
        self.parts.body(self.plane, part).angle_of(frame.axis(2))
    }

    /// The angle between two parts that a joint holds, by the axes of their markers, which are parallel.
    fn rotation(&self, first: usize) -> f64 {
        let second = 1 - first;
        let [a, b] = [first, second].map(|which| self.linkage.links[self.markers[which].part].angle);
        let now = wrap_angle(a - b);
        let is_flat =
            |which: usize, axis: usize| self.plane.contains(self.parts.world(&self.markers[which]).axis(axis));
        let Some(axis) = [2, 0, 1].into_iter().find(|axis| is_flat(0, *axis) && is_flat(1, *axis)) else { return now };
        let own = |which: usize| {
            let Marker { part, frame } = self.markers[which];
            self.parts.body(self.plane, part).angle_of(frame.axis(axis))
        };
        let held = own(second) - own(first);
        // The axes may point in opposite directions.
        wrap_angle(held + PI * ((now - held) / PI).round())
    }
}

fn add_offset(place: Vector, axis: Vector, offset: f64) -> Vector {
    if offset == 0.0 { place } else { plane::add(place, scaled(axis, offset)) }
}

/// Reads gears, and returns their ratio, their carrier and their phase.
fn gear(
    source: &Source,
    item: &Node,
    joined: &JoinedMarkers,
    linkage: &ImportedLinkage,
) -> Result<(f64, usize, f64), Error> {
    let radius = |key: &str| item.child(key).and_then(|node| node.first()).map(|row| row.number(source)).transpose();
    let [i, j] = [radius("radiusI")?.unwrap_or(0.0), radius("radiusJ")?.unwrap_or(0.0)];
    let links = joined.markers.map(|marker| marker.part);
    if i == 0.0 || j == 0.0 {
        let title = format!("gears `{}` have a radius of zero", item.name());
        return Err(source.error(title, item.span(), "", "give it radiusI and radiusJ"));
    }
    let pinned = |gear: usize| {
        linkage.joints.iter().filter(move |joint| joint.kind == Kind::Pin).filter_map(move |joint| {
            let ends = [joint.ends[0].link, joint.ends[1].link];
            if ends[0] == gear {
                Some(ends[1])
            } else if ends[1] == gear {
                Some(ends[0])
            } else {
                None
            }
        })
    };
    let carrier = pinned(links[0]).find(|carrier| pinned(links[1]).any(|other| other == *carrier));
    let Some(carrier) = carrier else {
        let title = format!("no part carries both gears of `{}`", item.name());
        return Err(source.error(title, item.span(), "", "join both gears to one part by pins, above this joint"));
    };
    let ratio = -i / j;
    let angle = |link: usize| linkage.links[link].angle - linkage.links[carrier].angle;
    Ok((ratio, carrier, wrap_angle(angle(links[1]) - ratio * angle(links[0]))))
}
