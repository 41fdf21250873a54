//! The forces in joints, by the equations of motion of what is beyond them.

use super::Linkage;
use super::closures::open_pins;
use super::graph::PointId;
use super::terms::whole;
use crate::document::{DisplacementSyntax, Identifier, OutputValue, Target};

/// The force that a joint has on the link of one of its ends, along a direction.
pub(super) fn force(linkage: &Linkage, number: usize, on: PointId, direction: [i32; 2]) -> OutputValue {
    let Linkage { graph, tree, places, .. } = linkage;
    let joint = &graph.joints[number];
    let identifier = |name: String| Identifier { name, span: joint.syntax.identifier.span.clone() };
    let name = &joint.syntax.identifier.name;
    if joint.ends.len() == 2 && !joint.ends.iter().any(|end| tree.places(number, *end)) {
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
    let others = |end: PointId| if end == on { 1 } else { -1 };
    // What the forces on all other ends are is taken away, where that on this one is not known by itself.
    let open = open_pins(tree, joint, number, places);
    let is_known = tree.places(number, on) || open.iter().any(|(_, end, _)| *end == on);
    let counts = |end: &PointId| !is_known || *end == on;
    let placed = joint.ends.iter().copied().filter(|end| tree.places(number, *end)).filter(counts);
    let axis = if direction[0] == 0 { "_y" } else { "_x" };
    OutputValue::FreeBody {
        displacements: placed.map(|end| beyond(linkage, end, direction.map(|part| others(end) * part))).collect(),
        multipliers: open
            .iter()
            .filter(|(_, end, _)| counts(end))
            .map(|(suffix, end, _)| (identifier(format!("{name}{suffix}{axis}")), whole(-others(*end))))
            .collect(),
    }
}

/// A displacement of all that a joint of the tree places by its end.
fn beyond(linkage: &Linkage, end: PointId, along: [i32; 2]) -> DisplacementSyntax {
    let (bodies, points) = linkage.bodies_and_points(&linkage.tree.beyond(end.link));
    DisplacementSyntax { bodies, points, along: Some(along.map(whole)), turn: None }
}

impl Linkage<'_> {
    /// The bodies and points of links.
    pub(super) fn bodies_and_points(&self, links: &[usize]) -> (Vec<Identifier>, Vec<Identifier>) {
        let identifier = |link: usize, name: &str| Identifier { name: name.to_owned(), span: self.graph.span(link) };
        let has_mass = |link: usize| self.graph.links[link].is_some_and(|link| link.mass.is_some());
        let is_body = |link: &&usize| has_mass(**link) || self.angles.of(**link).class > 0;
        let bodies = links.iter().filter(is_body).map(|link| identifier(*link, self.graph.name(*link)));
        let points = self.graph.all_points().filter(|id| links.contains(&id.link));
        (bodies.collect(), points.map(|id| identifier(id.link, self.places.name(id))).collect())
    }
}
