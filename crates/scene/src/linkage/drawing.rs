//! The drawing of links and joints.

mod gears;

use self::gears::gears;
use super::angles::Angles;
use super::cams::THETA;
use super::constants::Constants;
use super::graph::{Graph, Joint, PointId};
use super::places::Places;
use super::terms::{add, difference, direction, dot, multiply, negate, substituted, sum, whole};
use crate::document::{DrawnSyntax, ForceElementKind, Identifier, JointKind, Position};

/// Draws gears and belts below everything else, links as bars and plates, sliding links as blocks, and pins on the
/// ground as pivots.
pub(super) fn drawing(
    graph: &Graph,
    angles: &Angles,
    places: &Places,
    constants: &Constants,
) -> Vec<(Identifier, DrawnSyntax)> {
    let at = |id: PointId| Position::Point(Identifier { name: places.short_name(graph, id).to_owned(), span: 0..0 });
    let mut drawn = gears(graph, angles, constants, &at);
    for links in rigid(graph) {
        let mut names: Vec<&str> = Vec::new();
        let ids =
            links.iter().flat_map(|link| (0..graph.points(*link).len()).map(|point| PointId { link: *link, point }));
        let ids: Vec<PointId> = ids
            .filter(|id| {
                let name = places.short_name(graph, *id);
                let is_new = !names.contains(&name);
                names.push(name);
                is_new
            })
            .collect();
        let Some(syntax) = graph.links[links[0]].filter(|_| ids.len() > 1) else { continue };
        drawn.push((syntax.identifier.clone(), DrawnSyntax::Link(ids.into_iter().map(at).collect())));
    }
    let racks = || graph.joints.iter().filter(|joint| joint.syntax.kind == JointKind::Rack);
    let rolls = |end: PointId| racks().any(|rack| rack.ends[0] == end);
    for joint in &graph.joints {
        let identifier = joint.syntax.identifier.clone();
        let ground = joint.ends.iter().find(|end| end.link == 0);
        match (joint.syntax.kind, ground) {
            // The slider that keeps a gear on its rack is not drawn separately.
            (JointKind::Prismatic | JointKind::PinInSlot, _) if rolls(joint.ends[0]) => {}
            (JointKind::Prismatic | JointKind::PinInSlot, _) => {
                let span = &identifier.span;
                let own = joint.syntax.direction.clone().unwrap_or_else(|| whole(0));
                let angle = Some(add(angles.formula(joint.ends[1].link, span), own));
                let block = DrawnSyntax::Block { at: at(joint.ends[0]), angle, on: Some(at(joint.ends[1])) };
                // In a guide the link itself slides; on a pin, a separate block does.
                let sliding = graph.links[joint.ends[0].link].filter(|_| joint.syntax.kind == JointKind::Prismatic);
                drawn.push((sliding.map_or(identifier, |link| link.identifier.clone()), block));
            }
            (JointKind::Cam, _) => {
                let profile = joint.syntax.profile.clone().unwrap_or_else(|| whole(0));
                let angle = Some(angles.formula(joint.ends[1].link, &identifier.span));
                let is_flat = joint.syntax.face.is_some();
                let cam = DrawnSyntax::Cam { at: at(joint.ends[1]), angle, profile, is_flat };
                let own = graph.links[joint.ends[1].link].map(|link| &link.identifier);
                // Below all parts drawn later.
                drawn.insert(0, (own.cloned().unwrap_or_else(|| identifier.clone()), cam));
                drawn.extend(face(angles, places, joint).map(|face| (identifier, face)));
            }
            (JointKind::Rod, _) => {
                let ends = [at(joint.ends[0]), at(joint.ends[1])];
                let cylinder = |ends| DrawnSyntax::ForceElement(ForceElementKind::Actuator, ends);
                drawn
                    .push((identifier, if joint.syntax.is_cylinder { cylinder(ends) } else { DrawnSyntax::Rod(ends) }));
            }
            (JointKind::Revolute, Some(end)) => drawn.push((identifier, DrawnSyntax::Pivot(at(*end)))),
            _ => {}
        }
    }
    drawn
}

/// The face of a follower, as long as the cam is wide.
fn face(angles: &Angles, places: &Places, joint: &Joint) -> Option<DrawnSyntax> {
    let (face, profile) = (joint.syntax.face.as_ref()?, joint.syntax.profile.as_ref()?);
    let span = &joint.syntax.identifier.span;
    let centre = places.components(joint.ends[1], span);
    let way = difference(places.components(joint.ends[0], span), centre.clone());
    let [cos, sin] = direction(&add(angles.formula(joint.ends[0].link, span), face.clone()));
    // The middle of the face lies opposite the middle of the cam.
    let height = dot(way, [cos.clone(), sin.clone()]);
    let middle = sum(centre, [cos.clone(), sin.clone()].map(|part| multiply(height.clone(), part)));
    let half = substituted(profile, THETA, &whole(0));
    let along = [negate(sin), cos].map(|part| multiply(half.clone(), part));
    let ends = [difference(middle.clone(), along.clone()), sum(middle, along)];
    Some(DrawnSyntax::Link(ends.map(Position::Pair).into()))
}

/// The moving links, grouped with the links welded to them.
fn rigid(graph: &Graph) -> Vec<Vec<usize>> {
    let mut bodies: Vec<Vec<usize>> = (1..graph.links.len()).map(|link| vec![link]).collect();
    for joint in graph.joints.iter().filter(|joint| joint.syntax.kind == JointKind::Weld) {
        let place = |end: &PointId| bodies.iter().position(|links| links.contains(&end.link));
        if let [Some(first), Some(second)] = [place(&joint.ends[0]), place(&joint.ends[1])]
            && first != second
        {
            let others = bodies.remove(first.max(second));
            bodies[first.min(second)].extend(others);
        }
    }
    bodies
}
