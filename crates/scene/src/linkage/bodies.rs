//! Links with their masses, as bodies of an ordinary scene.

use super::angles::Angles;
use super::graph::{Graph, PointId};
use super::places::Places;
use super::terms::{self, add, divide, multiply, whole};
use super::tree::Tree;
use crate::diagnostic::Diagnostic;
use crate::document::{BodySyntax, Identifier, LinkSyntax, Mass, Position, Shape};
use crate::names::suggestion;
use crate::parser::Formula;

/// Creates the body of a link, unless it has no mass and cannot turn.
pub(super) fn body(
    graph: &Graph,
    tree: &Tree,
    angles: &Angles,
    places: &Places,
    link: usize,
    findings: &mut Vec<Diagnostic>,
) -> Option<BodySyntax> {
    let syntax = graph.links[link]?;
    let mass = syntax.mass.as_ref().map(|mass| match mass {
        Mass::Whole(mass) => mass.clone(),
        Mass::ByDensity(density) => multiply(density.clone(), syntax.shape.as_ref().map_or_else(|| whole(1), extent)),
    });
    let com = com(graph, tree, angles, places, link, findings).filter(|_| mass.is_some());
    let turns = angles.angle(link).class > 0;
    let inertia = syntax.inertia.clone().or_else(|| inertia_of_shape(syntax, mass.as_ref()?)).filter(|_| turns);
    let angle = turns.then(|| angles.formula(link, &graph.span(link)));
    let identifier = syntax.identifier.clone();
    (mass.is_some() || angle.is_some()).then_some(BodySyntax { identifier, mass, com, angle, inertia })
}

/// The centre of mass of a link; by default the centroid of its shape.
fn com(
    graph: &Graph,
    tree: &Tree,
    angles: &Angles,
    places: &Places,
    link: usize,
    findings: &mut Vec<Diagnostic>,
) -> Option<Position> {
    let syntax = graph.links[link]?;
    let (local, id) = match &syntax.com {
        Some(Position::Pair(local)) => (local.clone(), None),
        Some(Position::Point(point)) => {
            let own = graph.points(link).iter().position(|(own, _)| own.name == point.name);
            if own.is_none() {
                let title = format!("link `{}` has no point `{}`", graph.name(link), point.name);
                let names: Vec<&str> = graph.points(link).iter().map(|(own, _)| own.name.as_str()).collect();
                let help = suggestion(&point.name, names.iter().copied(), || match &names[..] {
                    [] => "write it as `com = [x, y]` in the frame of the link".to_owned(),
                    names => format!("its points: {}", names.join(", ")),
                });
                findings.push(Diagnostic::error(title, point.span.clone(), "not known").help(help));
            }
            let id = PointId { link, point: own.unwrap_or(0) };
            (if own.is_some() { graph.local(id) } else { [whole(0), whole(0)] }, own.map(|_| id))
        }
        None => {
            if let (Some(Mass::Whole(mass) | Mass::ByDensity(mass)), None) = (&syntax.mass, &syntax.shape) {
                let title = format!("link `{}` has a mass but no centre of mass", graph.name(link));
                let error = Diagnostic::error(title, mass.whole_span(), "no `com`");
                findings.push(error.help("add `com = \"POINT\"`, or `com = [x, y]` in the frame of the link"));
            }
            (syntax.shape.as_ref().map_or_else(|| [whole(0), whole(0)], centroid), None)
        }
    };
    if let Some(place) = places.guided(graph, tree, angles, link, local.clone()) {
        return Some(Position::Pair(place));
    }
    Some(match id {
        Some(id) => Position::Point(Identifier { name: places.name(id).to_owned(), span: graph.span(link) }),
        None => Position::Pair(places.local_position(graph, tree, angles, link, local)),
    })
}

/// The moment of inertia about the centroid: `m l^2/12` of a slender bar, `m (a^2 + b^2 + c^2)/36` of a thin triangle.
/// `None` if the centre of mass is elsewhere.
fn inertia_of_shape(link: &LinkSyntax, mass: &Formula) -> Option<Formula> {
    let square = |side: &Formula| multiply(side.clone(), side.clone());
    let sides = |sides: Formula, by: i32| divide(multiply(mass.clone(), sides), whole(by));
    match link.shape.as_ref().filter(|_| link.com.is_none())? {
        Shape::Bar(length) => Some(sides(square(length), 12)),
        Shape::Triangle([a, b, c]) => Some(sides(add(add(square(a), square(b)), square(c)), 36)),
    }
}

/// The length of a bar or the area of a triangle.
fn extent(shape: &Shape) -> Formula {
    match shape {
        Shape::Bar(length) => length.clone(),
        Shape::Triangle([a, b, c]) => terms::area(a.clone(), &terms::corner(a.clone(), b.clone(), c.clone())),
    }
}

/// The centroid of a shape in the frame of its link.
fn centroid(shape: &Shape) -> [Formula; 2] {
    match shape {
        Shape::Bar(length) => [divide(length.clone(), whole(2)), whole(0)],
        Shape::Triangle([a, b, c]) => {
            let [x, y] = terms::corner(a.clone(), b.clone(), c.clone());
            [divide(add(a.clone(), x), whole(3)), divide(y, whole(3))]
        }
    }
}
