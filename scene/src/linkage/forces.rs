//! The forces in joints, as outputs.

use super::graph::{Graph, PointId};
use super::places::Places;
use super::terms::whole;
use super::tree::Tree;
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier, JointKind, OutputSyntax, OutputValue, Target};
use crate::names::suggestion;
use crate::parser::Formula;

/// Whether the scene asks for a force in a joint.
pub(super) fn are_asked_for(document: &Document) -> bool {
    document.outputs.iter().any(|output| matches!(output.value, OutputValue::Joint(_)))
}

/// The outputs of a scene, where those for joints are two components and their norm.
pub(super) fn outputs(
    document: &Document,
    graph: &Graph,
    tree: &Tree,
    places: &Places,
    findings: &mut Vec<Diagnostic>,
) -> Vec<Vec<OutputSyntax>> {
    let names: Vec<&str> = graph.joints.iter().map(|joint| joint.syntax.identifier.name.as_str()).collect();
    let of = |output: &OutputSyntax| {
        let OutputValue::Joint(joint) = &output.value else { return Vec::new() };
        let Some(number) = names.iter().position(|name| *name == joint.name) else {
            let help = suggestion(&joint.name, names.iter().copied(), || format!("joints: {}", names.join(", ")));
            let title = format!("unknown joint `{}`", joint.name);
            findings.push(Diagnostic::error(title, joint.span.clone(), "not known").help(help));
            return Vec::new();
        };
        let ends = &graph.joints[number].ends;
        if graph.joints[number].syntax.kind == JointKind::Gear {
            let title = format!("joint `{}` has no force at a point", joint.name);
            let error = Diagnostic::error(title, joint.span.clone(), "it holds angles");
            findings.push(error.help("ask for the moment by `reaction`, or for the forces in the pins of the gears"));
            return Vec::new();
        }
        if ends.len() > 2 {
            let title = format!("joint `{}` joins {} links", joint.name, ends.len());
            let error = Diagnostic::error(title, joint.span.clone(), "between which of them?");
            findings.push(error.help("write a joint for each pair of links that is asked for"));
            return Vec::new();
        }
        let part = |suffix: &str, value: OutputValue| OutputSyntax {
            identifier: Identifier {
                name: format!("{}{suffix}", output.identifier.name),
                span: output.identifier.span.clone(),
            },
            value,
            unit: "N".to_owned(),
            doc: if output.doc.is_empty() {
                format!("force on {}", graph.name(ends[0].link))
            } else {
                output.doc.clone()
            },
        };
        let component = |suffix: &str, direction: [i32; 2]| part(suffix, force(graph, tree, places, number, direction));
        let parts = [component("_x", [1, 0]), component("_y", [0, 1])];
        let norm = OutputValue::Norm(parts.iter().map(|part| part.identifier.clone()).collect());
        parts.into_iter().chain([part("", norm)]).collect()
    };
    document.outputs.iter().map(of).collect()
}

/// The force on the first link of a joint along a direction.
fn force(graph: &Graph, tree: &Tree, places: &Places, number: usize, direction: [i32; 2]) -> OutputValue {
    let joint = &graph.joints[number];
    let span = &joint.syntax.identifier.span;
    let identifier = |name: &str| Identifier { name: name.to_owned(), span: span.clone() };
    let first = joint.ends[0];
    let Some(placed) = joint.ends.iter().find(|end| tree.places(number, **end)) else {
        return OutputValue::Reaction {
            constraint: identifier(&constraint(joint.syntax.kind, &joint.syntax.identifier.name, direction)),
            target: Target::Point(identifier(places.name(first))),
            along: Some(direction.map(whole)),
        };
    };
    // The bodies beyond the joint, which it holds.
    let beyond = tree.beyond(placed.link);
    let points = graph.all_points().filter(|id: &PointId| beyond.contains(&id.link));
    let is_body = |link: &&usize| graph.links[**link].is_some_and(|link| link.mass.is_some());
    let sign = if *placed == first { 1 } else { -1 };
    OutputValue::FreeBody {
        bodies: beyond.iter().filter(is_body).map(|link| identifier(graph.name(*link))).collect(),
        points: points.map(|id| identifier(places.name(id))).collect(),
        along: direction.map(|part| signed(sign * part)),
    }
}

/// The constraint of a joint that is not in the tree, for a direction.
fn constraint(kind: JointKind, name: &str, direction: [i32; 2]) -> String {
    match (kind.is_pin(), direction) {
        (true, [1, _]) => format!("{name}_x"),
        (true, _) => format!("{name}_y"),
        _ => name.to_owned(),
    }
}

fn signed(value: i32) -> Formula {
    let size = whole(value.abs());
    if value < 0 { super::terms::negate(size) } else { size }
}
