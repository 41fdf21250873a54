//! Constraints of the joints that the spanning tree does not contain, of rods, and of drives.

use super::angles::Angles;
use super::graph::{Graph, Joint, PointId};
use super::places::{Places, distance_from_line, line, slide};
use super::terms::{add, call, difference, dot, multiply, name, negate, subtract, whole};
use super::tree::{Placement, Tree};
use crate::document::{ConstraintSyntax, Identifier, JointKind};
use crate::function::Function;
use crate::parser::Formula;

/// The constraints of all joints, in their order.
pub(super) fn constraints(graph: &Graph, tree: &Tree, angles: &Angles, places: &Places) -> Vec<ConstraintSyntax> {
    let mut constraints = Vec::new();
    for (number, joint) in graph.joints.iter().enumerate() {
        let syntax = joint.syntax;
        let mut put = |suffix: &str, residual: Formula, unit: &str| {
            constraints.push(ConstraintSyntax {
                identifier: Identifier {
                    name: format!("{}{suffix}", syntax.identifier.name),
                    span: syntax.identifier.span.clone(),
                },
                residual,
                unit: unit.to_owned(),
                one_sided: None,
                doc: syntax.doc.clone(),
            });
        };
        match syntax.kind {
            JointKind::Revolute | JointKind::Weld => {
                let open = open_pins(tree, joint, number, places);
                let is_one = open.len() == 1;
                for (place, (end, to)) in open.into_iter().enumerate() {
                    let [x, y] = difference(
                        places.components(end, &syntax.identifier.span),
                        places.components(to, &syntax.identifier.span),
                    );
                    let number = if is_one { String::new() } else { (place + 1).to_string() };
                    put(&format!("{number}_x"), x, "m");
                    put(&format!("{number}_y"), y, "m");
                }
            }
            JointKind::Prismatic | JointKind::PinInSlot => {
                if !joint.ends.iter().any(|end| tree.places(number, *end)) {
                    put("", distance_from_line(places, graph, angles, number), "m");
                }
            }
            JointKind::Rod => {
                let [a, b] = [0, 1].map(|end| places.components(joint.ends[end], &syntax.identifier.span));
                put("", subtract(call(Function::Hypot, difference(a, b)), size(joint)), "m");
            }
            JointKind::Gear => {
                let span = &syntax.identifier.span;
                let carrier = angles.formula(joint.carrier, span);
                let [first, second] =
                    [0, 1].map(|end| subtract(angles.formula(joint.ends[end].link, span), carrier.clone()));
                put("", subtract(first, add_phase(joint, multiply(size(joint), second))), "rad");
            }
            JointKind::Rack => {
                let span = &syntax.identifier.span;
                let [point, on] = [0, 1].map(|end| places.components(joint.ends[end], span));
                let along = dot(difference(point, on), line(graph, angles, number));
                let [first, second] = [0, 1].map(|end| angles.formula(joint.ends[end].link, span));
                // Counter-clockwise it rolls back.
                let rolled = negate(multiply(size(joint), subtract(first, second)));
                put("", subtract(along, add_phase(joint, rolled)), "m");
            }
        }
        if let Some(drive) = &syntax.drive {
            let (value, unit) = driven(graph, tree, angles, places, number);
            put("_drive", subtract(value, drive.clone()), unit);
        }
    }
    constraints
}

fn size(joint: &Joint) -> Formula {
    joint.syntax.size.clone().unwrap_or_else(|| whole(0))
}

fn add_phase(joint: &Joint, value: Formula) -> Formula {
    joint.syntax.phase.clone().map_or(value.clone(), |phase| add(value, phase))
}

/// The pairs of points that a pin holds together and the tree does not.
fn open_pins(tree: &Tree, joint: &Joint, number: usize, places: &Places) -> Vec<(PointId, PointId)> {
    let roots: Vec<PointId> = joint.ends.iter().copied().filter(|end| !tree.places(number, *end)).collect();
    let Some((to, others)) = roots.split_first() else { return Vec::new() };
    let is_open = |end: &&PointId| places.name(**end) != places.name(*to);
    others.iter().filter(is_open).map(|end| (*end, *to)).collect()
}

/// The angle or length of a joint, as a drive gives it.
fn driven(graph: &Graph, tree: &Tree, angles: &Angles, places: &Places, number: usize) -> (Formula, &'static str) {
    let joint = &graph.joints[number];
    let span = &joint.syntax.identifier.span;
    let [first, second] = [joint.ends[0], joint.ends[1]];
    if joint.syntax.kind == JointKind::Revolute {
        return (subtract(angles.formula(first.link, span), angles.formula(second.link, span)), "rad");
    }
    let is_coordinate = joint
        .ends
        .iter()
        .any(|end| matches!(tree.placements[end.link], Placement::Slider { joint, .. } if joint == number));
    if is_coordinate {
        return (name(slide(graph, number), span), "m");
    }
    let way = difference(places.components(first, span), places.components(second, span));
    (dot(way, line(graph, angles, number)), "m")
}
