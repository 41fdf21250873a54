//! Constraints of joints outside the spanning tree, of rods, and of drives.

use super::angles::Angles;
use super::cams::{CONTACT, Cam};
use super::graph::{Graph, Joint, PointId};
use super::places::{Places, distance_from_line, line, slide};
use super::terms::{add, call, difference, dot, multiply, name, negate, subtract, whole};
use super::tree::Tree;
use crate::document::{ConstraintSyntax, Identifier, JointKind};
use crate::function::Function;
use crate::parser::Formula;

/// A constraint of a joint.
pub(super) struct JointConstraint {
    /// The constraint.
    pub(super) syntax: ConstraintSyntax,
    /// The derivatives of its residual with respect to the angle of each link, with points fixed.
    pub(super) slopes: Vec<(usize, Formula)>,
}

/// Creates the constraints of all joints, in their order.
pub(super) fn closures(graph: &Graph, tree: &Tree, angles: &Angles, places: &Places) -> Vec<JointConstraint> {
    let mut closures = Vec::new();
    for (number, joint) in graph.joints.iter().enumerate() {
        let syntax = joint.syntax;
        let span = &syntax.identifier.span;
        let mut put = |suffix: &str, residual: Formula, unit: &str, slopes: Vec<(usize, Formula)>| {
            let name = format!("{}{suffix}", syntax.identifier.name);
            let syntax = ConstraintSyntax {
                identifier: Identifier { name, span: span.clone() },
                residual,
                unit: unit.to_owned(),
                one_sided: syntax.one_sided.filter(|_| suffix.is_empty()),
                is_drive: suffix == DRIVE,
                doc: syntax.doc.clone(),
            };
            closures.push(JointConstraint { syntax, slopes });
        };
        let components = |end: usize| places.components(joint.ends[end], span);
        let angle = |end: usize| angles.formula(joint.ends[end].link, span);
        // The distance of the first point from the second one, along the line of the latter.
        let along = || dot(difference(components(0), components(1)), line(graph, angles, number));
        let across = || distance_from_line(places, graph, angles, number);
        match syntax.kind {
            JointKind::Revolute | JointKind::Weld => {
                for (suffix, end, to) in open_pins(tree, joint, number, places) {
                    let [x, y] = difference(places.components(end, span), places.components(to, span));
                    put(&format!("{suffix}_x"), x, "m", Vec::new());
                    put(&format!("{suffix}_y"), y, "m", Vec::new());
                }
            }
            JointKind::Prismatic | JointKind::PinInSlot => {
                if !joint.ends.iter().any(|end| tree.places(number, *end)) {
                    put("", across(), "m", vec![(joint.ends[1].link, negate(along()))]);
                }
            }
            JointKind::Rod => {
                let length = call(Function::Hypot, difference(components(0), components(1)));
                put("", subtract(length, size(joint)), "m", Vec::new());
            }
            // `Angles::check` reports such gears.
            JointKind::Gear if angles.turn_together([joint.ends[0].link, joint.ends[1].link, joint.carrier]) => {}
            JointKind::Gear => {
                let carrier = angles.formula(joint.carrier, span);
                let [first, second] = [0, 1].map(|end| subtract(angle(end), carrier.clone()));
                let residual = subtract(first, add_phase(joint, multiply(size(joint), second)));
                put("", residual, "rad", gear_slopes(joint));
            }
            JointKind::Rack => {
                // Turning counter-clockwise, it rolls backwards.
                let rolled = negate(multiply(size(joint), subtract(angle(0), angle(1))));
                let of_line = subtract(across(), size(joint));
                let slopes = vec![(joint.ends[0].link, size(joint)), (joint.ends[1].link, of_line)];
                put("", subtract(along(), add_phase(joint, rolled)), "m", slopes);
            }
            JointKind::Cam => {
                let cam = Cam::new(joint, angles, places);
                let (residual, slopes) = cam.distance();
                put("", residual, "m", slopes);
                let (residual, unit, slopes) = cam.contact();
                put(CONTACT, residual, unit, slopes);
            }
        }
        let Some(drive) = &syntax.drive else { continue };
        let [first, second] = [joint.ends[0].link, joint.ends[1].link];
        let (value, unit, slopes) = if syntax.kind == JointKind::Revolute {
            (subtract(angle(0), angle(1)), "rad", vec![(first, whole(1)), (second, whole(-1))])
        } else if joint.ends.iter().any(|end| tree.places(number, *end)) {
            (name(slide(graph, number), span), "m", Vec::new())
        } else {
            (along(), "m", vec![(second, across())])
        };
        put(DRIVE, subtract(value, drive.clone()), unit, slopes);
    }
    closures
}

/// The suffix that turns the name of a joint into the name of the constraint of its drive.
pub(super) const DRIVE: &str = "_drive";

/// The derivatives of a gear constraint with respect to the angles of its links.
pub(super) fn gear_slopes(joint: &Joint) -> Vec<(usize, Formula)> {
    let [first, second] = [joint.ends[0].link, joint.ends[1].link];
    vec![(first, whole(1)), (second, negate(size(joint))), (joint.carrier, subtract(size(joint), whole(1)))]
}

fn size(joint: &Joint) -> Formula {
    joint.syntax.size.clone().unwrap_or_else(|| whole(0))
}

fn add_phase(joint: &Joint, value: Formula) -> Formula {
    joint.syntax.phase.clone().map_or(value.clone(), |phase| add(value, phase))
}

/// The pairs of points of a pin that the tree does not join, with the suffixes of the names of their constraints.
pub(super) fn open_pins(tree: &Tree, joint: &Joint, number: usize, places: &Places) -> Vec<(String, PointId, PointId)> {
    let roots: Vec<PointId> = joint.ends.iter().copied().filter(|end| !tree.places(number, *end)).collect();
    let Some((to, others)) = roots.split_first() else { return Vec::new() };
    let open: Vec<PointId> = others.iter().copied().filter(|end| places.name(*end) != places.name(*to)).collect();
    let is_one = open.len() == 1;
    let suffix = |place: usize| if is_one { String::new() } else { (place + 1).to_string() };
    open.into_iter().enumerate().map(|(place, end)| (suffix(place), end, *to)).collect()
}
