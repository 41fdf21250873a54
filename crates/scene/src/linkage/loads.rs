//! Loads on points of links.

use super::graph::PointId;
use super::outputs::are_of_joints;
use super::resolved::Linkage;
use super::terms;
use crate::diagnostic::Diagnostic;
use crate::document::{Along, Document, Identifier, JointPart, LoadSyntax, OutputValue, Target};
use crate::expression::Node;
use crate::names::suggestion;
use crate::parser::Formula;

/// Reports loads between two points that always coincide, and loads on a pin whose force depends on which of its links
/// carries them.
pub(super) fn check(document: &Document, linkage: &Linkage, findings: &mut Vec<Diagnostic>) {
    for (_, load) in &document.loads {
        if let LoadSyntax::Force { target: Target::Point(point), .. } = load {
            findings.extend(fault_of_point(document, linkage, point));
        }
        let LoadSyntax::Spring(spring) = load else { continue };
        let (first, second) = match &spring.along {
            Along::Between(first, second) => (first, second),
            Along::Formula(length) => {
                findings.extend(fault_of_length(document, linkage, length));
                continue;
            }
        };
        findings.extend([first, second].into_iter().filter_map(|point| fault_of_point(document, linkage, point)));
        let Some(joint) = pin_of_both(linkage, first, second) else { continue };
        let title = format!("points `{}` and `{}` are always in one place", first.name, second.name);
        let label = format!("joint `{joint}` holds them together");
        findings.push(Diagnostic::error(title, second.span.clone(), label).help("name points that can move apart"));
    }
}

/// The components of each force that is fixed to a link, in the frame of the ground; `None` for other loads.
pub(super) fn turned(
    document: &Document,
    linkage: &Linkage,
    findings: &mut Vec<Diagnostic>,
) -> Vec<Option<[Formula; 2]>> {
    let graph = linkage.graph;
    let mut components = |load: &LoadSyntax| {
        let LoadSyntax::Force { force, frame: Some(frame), .. } = load else { return None };
        let Some(link) = (0..graph.links.len()).find(|link| graph.name(*link) == frame.name) else {
            findings.push(unknown_frame(frame, (0..graph.links.len()).map(|link| graph.name(link))));
            return None;
        };
        Some(terms::rotated(force.clone(), &linkage.angles.formula(link, &frame.span)))
    };
    document.loads.iter().map(|(_, load)| components(load)).collect()
}

/// Reports a frame that is no link.
pub(crate) fn unknown_frame<'n>(frame: &Identifier, links: impl Iterator<Item = &'n str>) -> Diagnostic {
    let error = Diagnostic::error(format!("unknown link `{}`", frame.name), frame.span.clone(), "not in [links]");
    error.help(suggestion(&frame.name, links, || "name the link to which the force is fixed".to_owned()))
}

/// The fault of a length that names a point of several links, or of none.
fn fault_of_length(document: &Document, linkage: &Linkage, length: &Formula) -> Option<Diagnostic> {
    let point = |(id, node): (usize, &Node<String>)| match node {
        Node::Name(name) => name.rsplit_once('.').map(|(point, _)| (point.to_owned(), length.span(id))),
        _ => None,
    };
    let mut points = length.nodes().iter().enumerate().filter_map(point);
    let fault = points.find_map(|(name, span)| fault_of_point(document, linkage, &Identifier { name, span }))?;
    Some(fault.help("write `between` with the point of a link, or name a point that one link has alone"))
}

/// The fault of a point of several links if the force in the pin between them is needed, or of a point of none.
fn fault_of_point(document: &Document, linkage: &Linkage, point: &Identifier) -> Option<Diagnostic> {
    let graph = linkage.graph;
    if graph.all_points().all(|id| linkage.places.name(id) != point.name) {
        return fault_of_owner(document, point);
    }
    let is_own = |end: &&PointId| graph.point_name(**end) == point.name;
    let asked = |output: &OutputValue, name: &str| match output {
        OutputValue::Joint { joint, part: JointPart::Force, .. } => joint.name == name,
        _ => false,
    };
    graph.joints.iter().filter(|joint| joint.syntax.kind.is_pin()).find_map(|joint| {
        let name = &joint.syntax.identifier.name;
        let is_needed =
            joint.syntax.friction.is_some() || document.outputs.iter().any(|output| asked(&output.value, name));
        let links: Vec<&str> = joint.ends.iter().filter(is_own).map(|end| graph.name(end.link)).collect();
        if !is_needed || links.len() < 2 {
            return None;
        }
        let title = format!("point `{}` belongs to links `{}`", point.name, links.join("` and `"));
        let label = format!("the force in joint `{name}` depends on which link carries this load");
        let points: Vec<String> = links.iter().map(|link| format!("`\"{link}.{}\"`", point.name)).collect();
        let help = format!("name the link as well: {}", points.join(" or "));
        Some(Diagnostic::error(title, point.span.clone(), label).help(help))
    })
}

/// The fault of a moving point that belongs to no link, if forces in joints are needed: they do not count its load.
fn fault_of_owner(document: &Document, point: &Identifier) -> Option<Diagnostic> {
    let own = document.points.iter().find(|(own, _)| own.name == point.name);
    let (_, place) = own.filter(|_| are_of_joints(document))?;
    let is_known = |name: &String| {
        name == "t" || name == "pi" || document.parameters.iter().any(|parameter| parameter.identifier.name == *name)
    };
    if place.iter().all(|part| part.names().all(is_known)) {
        return None;
    }
    let title = format!("point `{}` moves and belongs to no link", point.name);
    let error = Diagnostic::error(title, point.span.clone(), "which link carries this load?");
    Some(error.help("forces in joints follow from the loads on links: add the point to the `points` of a link"))
}

/// The pin that holds two different points together.
fn pin_of_both<'l>(linkage: &Linkage<'l>, first: &Identifier, second: &Identifier) -> Option<&'l str> {
    let has = |ends: &[PointId], point: &Identifier| ends.iter().any(|end| linkage.is_named(*end, &point.name));
    let joints = linkage.graph.joints.iter().filter(|joint| joint.syntax.kind.is_pin());
    let joint = joints.into_iter().find(|joint| has(&joint.ends, first) && has(&joint.ends, second))?;
    Some(&joint.syntax.identifier.name)
}
