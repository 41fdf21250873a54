//! Links and joints to coordinates, points, bodies and constraints: what the rest of the program reads is an ordinary
//! scene.
//!
//! Links that do not turn against each other have one angle, absolute and counter-clockwise ([`angles`]). The place of
//! each link follows from that of another one by a joint of a spanning tree ([`tree`], [`places`]); joints that are not
//! in the tree become constraints ([`closures`]).

mod angles;
mod closures;
mod forces;
mod graph;
mod places;
mod start;
mod terms;
mod tree;

use crate::diagnostic::Diagnostic;
use crate::document::{
    BodySyntax, CoordinateSyntax, Document, DrawnSyntax, Identifier, JointKind, LinkSyntax, Mass, OutputSyntax,
    OutputValue, Position,
};
use crate::names::suggestion;
use crate::parser::Formula;
use angles::Angles;
use graph::{Graph, PointId};
use places::{Places, origin_names, slide};
use start::Rough;
use terms::{add, divide, multiply, whole};
use tree::{Placement, Tree};

/// Adds to a scene what its links and joints are in coordinates, points, bodies, constraints and drawings.
pub fn expand(document: &mut Document, findings: &mut Vec<Diagnostic>) {
    let is_empty = document.links.is_empty() && document.joints.is_empty();
    // What could not be read would be missing.
    if is_empty || document.lost_names {
        return;
    }
    let before = findings.len();
    let Some(graph) = Graph::new(document, findings) else {
        document.lost_names = true;
        document.is_whole = false;
        return;
    };
    let first = document.links.first().map_or(0..0, |link| link.identifier.span.clone());
    let angles = Angles::new(&graph);
    let tree = Tree::new(&graph);
    let places = Places::new(&graph, &tree, &angles, !forces::are_asked_for(document));
    let constraints = closures::constraints(&graph, &tree, &angles, &places);
    let coordinates = coordinates(&graph, &tree, &angles);
    let bodies =
        (1..graph.links.len()).filter_map(|link| body(&graph, &tree, &angles, &places, link, findings)).collect();
    let values = Rough::new(&graph, &angles, &tree).values();
    let drawing = if document.drawing.is_empty() { drawing(&graph, &angles, &places) } else { Vec::new() };
    let freedoms = coordinates.len().saturating_sub(constraints.len() + document.constraints.len());
    let forces = forces::outputs(document, &graph, &tree, &places, findings);
    let points = places.points;
    put_before(&mut document.coordinates, coordinates);
    put_before(&mut document.points, points);
    put_before(&mut document.bodies, bodies);
    put_before(&mut document.constraints, constraints);
    document.drawing.extend(drawing);
    let own = std::mem::take(&mut document.outputs);
    let is_force = |output: &OutputSyntax| matches!(output.value, OutputValue::Joint(_));
    let each = own.into_iter().zip(forces).map(|(own, forces)| if is_force(&own) { forces } else { vec![own] });
    document.outputs = each.flatten().collect();
    let unknown = start::write(document, values, freedoms);
    let coordinates = || document.coordinates.iter().map(|coordinate| &coordinate.identifier);
    for (what, suffix) in [("position", ""), ("rate", "_dot")] {
        let is_given = |own: &&Identifier| {
            document.given.iter().any(|(given, _)| given.name.strip_suffix(suffix) == Some(own.name.as_str()))
        };
        let given = coordinates().filter(is_given).count();
        if given < freedoms && document.is_whole && unknown.is_empty() && findings.len() == before {
            let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
            let freedom = if freedoms == 1 { "degree" } else { "degrees" };
            let title = format!(
                "the mechanism has {freedoms} {freedom} of freedom, but {} given at the start",
                if given == 1 { format!("1 {what} is") } else { format!("{} are", count(given, what)) }
            );
            findings.push(
                Diagnostic::error(title, first.clone(), "links begin here").help(
                    "give as many links as that a `rate` beside their `angle`, or a slider its `start` and `rate`",
                ),
            );
        }
    }
    for name in unknown {
        let span = coordinates().find(|own| own.name == name).map_or(0..0, |own| own.span.clone());
        let error = Diagnostic::error(format!("the start of `{name}` is not known"), span, "nothing says where it is");
        findings.push(error.help(
            "give the link an `angle`, or two of its joints a rough place by `near = [x, y]`; a slider takes \
             `start = ...`",
        ));
    }
    document.is_whole &= findings.len() == before;
}

fn put_before<T>(list: &mut Vec<T>, before: Vec<T>) {
    list.splice(0..0, before);
}

fn coordinates(graph: &Graph, tree: &Tree, angles: &Angles) -> Vec<CoordinateSyntax> {
    let coordinate = |name: String, unit: &str, span: std::ops::Range<usize>, doc: String| CoordinateSyntax {
        identifier: Identifier { name, span },
        unit: unit.to_owned(),
        doc,
    };
    let angle = |(name, link): &(String, usize)| {
        let own = graph.links[*link].map_or("", |link| &link.doc);
        let doc = if own.is_empty() { format!("angle of {}", graph.name(*link)) } else { own.to_owned() };
        coordinate(name.clone(), "rad", graph.span(*link), doc)
    };
    let mut coordinates: Vec<CoordinateSyntax> = angles.coordinates.iter().map(angle).collect();
    for &link in &tree.order {
        match tree.placements[link] {
            Placement::Slider { joint, .. } => {
                let syntax = graph.joints[joint].syntax;
                let doc = format!("place along joint {}", syntax.identifier.name);
                coordinates.push(coordinate(slide(graph, joint), "m", syntax.identifier.span.clone(), doc));
            }
            Placement::Free => {
                let doc = || format!("origin of {}", graph.name(link));
                let names = origin_names(graph, link);
                coordinates.extend(names.map(|name| coordinate(name, "m", graph.span(link), doc())));
            }
            Placement::Ground | Placement::Pin { .. } => {}
        }
    }
    coordinates
}

/// The body of a link, unless it is without mass and does not turn.
fn body(
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
        Mass::ByLength(density) => multiply(density.clone(), syntax.bar.clone().unwrap_or_else(|| whole(1))),
    });
    let com = com(graph, tree, angles, places, link, findings).filter(|_| mass.is_some());
    let turns = angles.of(link).class > 0;
    let inertia = syntax.inertia.clone().or_else(|| slender(syntax, mass.as_ref()?)).filter(|_| turns);
    let angle = turns.then(|| angles.formula(link, &graph.span(link)));
    let identifier = syntax.identifier.clone();
    (mass.is_some() || angle.is_some()).then_some(BodySyntax { identifier, mass, com, angle, inertia })
}

/// The centre of mass of a link, in the middle of a bar where it is not given.
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
            if let (Some(Mass::Whole(mass) | Mass::ByLength(mass)), None) = (&syntax.mass, &syntax.bar) {
                let title = format!("link `{}` has a mass and no centre of mass", graph.name(link));
                let error = Diagnostic::error(title, mass.whole_span(), "no `com`");
                findings.push(error.help("add `com = \"POINT\"`, or `com = [x, y]` in the frame of the link"));
            }
            ([divide(syntax.bar.clone().unwrap_or_else(|| whole(0)), whole(2)), whole(0)], None)
        }
    };
    if let Some(place) = places.guided(graph, tree, angles, link, local.clone()) {
        return Some(Position::Pair(place));
    }
    Some(match id {
        Some(id) => Position::Point(Identifier { name: places.name(id).to_owned(), span: graph.span(link) }),
        None => Position::Pair(places.of_local(graph, tree, angles, link, local)),
    })
}

/// The moment of inertia of a slender bar whose centre of mass is in its middle, `m l^2/12`.
fn slender(link: &LinkSyntax, mass: &Formula) -> Option<Formula> {
    let length = link.bar.clone().filter(|_| link.com.is_none())?;
    Some(divide(multiply(multiply(mass.clone(), length.clone()), length), whole(12)))
}

/// Links as bars and plates, sliding links as blocks, pins on the ground as pivots.
fn drawing(graph: &Graph, angles: &Angles, places: &Places) -> Vec<(Identifier, DrawnSyntax)> {
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
