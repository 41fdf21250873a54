//! Links and joints as they are drawn.

use super::angles::Angles;
use super::graph::{Graph, PointId};
use super::places::Places;
use super::terms::{add, whole};
use crate::document::{DrawnSyntax, Identifier, JointKind, Position};

/// Links as bars and plates, sliding links as blocks, pins on the ground as pivots.
pub(super) fn drawing(graph: &Graph, angles: &Angles, places: &Places) -> Vec<(Identifier, DrawnSyntax)> {
    let at = |id: PointId| Position::Point(Identifier { name: places.short_name(graph, id).to_owned(), span: 0..0 });
    let mut drawn = Vec::new();
    for link in 1..graph.links.len() {
        let mut names: Vec<&str> = Vec::new();
        let ids = (0..graph.points(link).len()).map(|point| PointId { link, point });
        let ids: Vec<PointId> = ids
            .filter(|id| {
                let name = places.short_name(graph, *id);
                let is_new = !names.contains(&name);
                names.push(name);
                is_new
            })
            .collect();
        let Some(syntax) = graph.links[link].filter(|_| ids.len() > 1) else { continue };
        drawn.push((syntax.identifier.clone(), DrawnSyntax::Link(ids.into_iter().map(at).collect())));
    }
    for joint in &graph.joints {
        let identifier = joint.syntax.identifier.clone();
        let ground = joint.ends.iter().find(|end| end.link == 0);
        match (joint.syntax.kind, ground) {
            (JointKind::Prismatic, _) => {
                let span = &identifier.span;
                let own = joint.syntax.direction.clone().unwrap_or_else(|| whole(0));
                let angle = Some(add(angles.formula(joint.ends[1].link, span), own));
                drawn.push((identifier, DrawnSyntax::Block { at: at(joint.ends[0]), angle }));
            }
            (JointKind::Revolute, Some(end)) => drawn.push((identifier, DrawnSyntax::Pivot(at(*end)))),
            _ => {}
        }
    }
    drawn
}
