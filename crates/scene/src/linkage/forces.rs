//! Joint forces from free-body equations of the links that the joint places. They use virtual displacements, whose work
//! `crates/engine/src/virtual_work.rs` derives.

use super::cams::{CONTACT, Cam};
use super::closures::{DRIVE, open_pins};
use super::friction::load_of_joint;
use super::gears::forces_of_teeth;
use super::graph::PointId;
use super::places::{line, slide};
use super::resolved::{Linkage, displacement_through};
use super::terms::{dot, negate, whole};
use crate::document::{DisplacementSyntax, Identifier, JointKind, OutputValue, Target};
use crate::parser::Formula;

/// The force of a joint on the link of one of its ends, along a direction.
pub(super) fn force(linkage: &Linkage, number: usize, on: PointId, direction: [i32; 2]) -> OutputValue {
    let Linkage { graph, tree, angles, places, .. } = linkage;
    let joint = &graph.joints[number];
    let identifier = |name: String| Identifier { name, span: joint.syntax.identifier.span.clone() };
    let name = &joint.syntax.identifier.name;
    let is_closed = !joint.ends.iter().any(|end| tree.places(number, *end));
    let (drive, friction) = (joint.syntax.drive.as_ref(), joint.syntax.friction.as_ref());
    if joint.syntax.kind.is_slider() && (!is_closed || drive.is_some() || friction.is_some()) {
        let along_line = line(graph, angles, number);
        let [cos, sin] = along_line.clone();
        let factor = |way: [Formula; 2]| {
            let along = dot(way, direction.map(whole));
            if on == joint.ends[0] { along } else { negate(along) }
        };
        // The slider acts across the line; drive and friction act along it.
        let held = is_closed.then(|| (identifier(name.clone()), negate(factor([negate(sin), cos]))));
        let driven = drive.map(|_| (identifier(format!("{name}{DRIVE}")), negate(factor(along_line.clone()))));
        let rubbed = friction.map(|_| (identifier(load_of_joint(name)), factor(along_line.clone())));
        let placed = joint.ends.iter().find(|end| tree.places(number, **end));
        let displaced = placed.map(|end| {
            let way = if *end == on { direction } else { direction.map(|part| -part) };
            let slide = (factor(along_line.clone()), identifier(slide(graph, number)));
            DisplacementSyntax { slide: Some(slide), ..displacement_through(linkage, *end, way.map(whole)) }
        });
        return OutputValue::FreeBody {
            displacements: displaced.into_iter().collect(),
            multipliers: held.into_iter().chain(driven).collect(),
            loads: rubbed.into_iter().collect(),
        };
    }
    if joint.syntax.kind == JointKind::Cam {
        let cam = Cam::new(joint, angles, places);
        let [along, across] = cam.directions();
        let factor = |way: [Formula; 2]| {
            let along = dot(way, direction.map(whole));
            if on == joint.ends[0] { negate(along) } else { along }
        };
        // A flat face is held by its distance alone.
        let contact = joint.syntax.face.is_none().then(|| (identifier(format!("{name}{CONTACT}")), factor(across)));
        let multipliers = std::iter::once((identifier(name.clone()), factor(along))).chain(contact).collect();
        return OutputValue::FreeBody { displacements: Vec::new(), multipliers, loads: Vec::new() };
    }
    let teeth = forces_of_teeth(linkage, number, on, direction);
    if joint.ends.len() == 2 && is_closed && teeth.is_empty() {
        let suffix = match (joint.syntax.kind.is_pin(), direction) {
            (true, [1, _]) => "_x",
            (true, _) => "_y",
            _ => "",
        };
        return OutputValue::Reaction {
            constraint: identifier(format!("{name}{suffix}")),
            target: Target::Point(identifier(places.name(on).to_owned())),
            along: Some(direction.map(whole)),
        };
    }
    let axis = if direction[0] == 0 { "_y" } else { "_x" };
    if tree.places(number, on) {
        let displacements = vec![displacement_through(linkage, on, direction.map(whole))];
        return OutputValue::FreeBody { displacements, multipliers: teeth, loads: Vec::new() };
    }
    // Constraints connect this end to others; the end also carries the links that the tree places by it.
    let carried_ends = joint.ends.iter().copied().filter(|end| tree.placing_end(number, *end) == Some(on));
    let open = open_pins(tree, joint, number, places);
    let factor = |end: PointId, to: PointId| i32::from(to == on) - i32::from(end == on);
    let multipliers = open.iter().map(|(suffix, end, to)| (format!("{name}{suffix}{axis}"), factor(*end, *to)));
    OutputValue::FreeBody {
        displacements: carried_ends
            .map(|end| displacement_through(linkage, end, direction.map(|part| whole(-part))))
            .collect(),
        multipliers: multipliers
            .filter(|(_, factor)| *factor != 0)
            .map(|(name, factor)| (identifier(name), whole(factor)))
            .chain(teeth)
            .collect(),
        loads: Vec::new(),
    }
}
