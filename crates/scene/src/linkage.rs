//! Expands links and joints into coordinates, points, bodies and constraints, so that the rest of the program sees an
//! ordinary scene.
//!
//! Links that cannot turn relative to each other share one angle, absolute and counter-clockwise (`angles`). The
//! position of each link follows from that of another link through a joint of a spanning tree (`tree`, `places`);
//! joints outside the tree become constraints (`closures`).

mod angles;
mod bodies;
mod cams;
mod closures;
mod constants;
mod drawing;
mod forces;
mod four_bars;
mod friction;
mod gears;
mod graph;
mod independent_coordinates;
mod lengths;
mod loads;
mod moments;
mod outputs;
mod places;
mod resolved;
mod start;
mod start_positions;
pub(crate) mod terms;
mod tree;

use std::collections::BTreeMap;

use crate::diagnostic::{Diagnostic, errors};
use crate::document::{CoordinateSyntax, Document, DrawnSyntax, Identifier, LoadSyntax, NearSyntax};
use angles::Angles;
use constants::Constants;
use friction::Frictions;
pub(crate) use friction::load_of_joint;
use graph::{Graph, PointId};
pub(crate) use loads::unknown_frame;
use places::{Places, origin_names, slide};
use resolved::Linkage;
use start_positions::StartPositions;
use tree::{Placement, Tree};

/// Adds the coordinates, points, bodies, constraints and drawings of links and joints to a scene.
pub fn expand(document: &mut Document, findings: &mut Vec<Diagnostic>) {
    let is_empty = document.links.is_empty() && document.joints.is_empty();
    // Unreadable parts would be missing.
    if is_empty || document.has_unread_declarations {
        return;
    }
    let before = errors(findings);
    let Some(graph) = Graph::new(document, findings) else {
        document.has_unread_declarations = true;
        document.is_well_formed = false;
        return;
    };
    let first = document.links.first().map_or(0..0, |link| link.identifier.span.clone());
    let angles = Angles::new(&graph);
    angles.check(&graph, findings);
    let tree = Tree::new(&graph);
    let shared = !outputs::are_of_joints(document);
    start::check_rates(&graph, &tree, &angles, findings);
    let places = Places::new(&graph, &tree, &angles, shared, shared && !outputs::are_reactions(document));
    let closures = closures::closures(&graph, &tree, &angles, &places);
    let coordinates = coordinates(&graph, &tree, &angles);
    let bodies = (1..graph.links.len())
        .filter_map(|link| bodies::body(&graph, &tree, &angles, &places, link, findings))
        .collect();
    let driven = start::driven(&graph, &angles);
    let values = StartPositions::new(&graph, &angles, &tree).values();
    let four_bars = four_bars::four_bars(&graph, &angles, &places);
    let constants = Constants::new(document);
    lengths::check(document, &constants, findings);
    // Paths are added to the drawing of the links.
    let is_drawn = document.drawing.iter().any(|(_, part)| !matches!(part, DrawnSyntax::Path(_)));
    let drawing = if is_drawn { Vec::new() } else { drawing::drawing(&graph, &angles, &places, &constants) };
    let count = [coordinates.len() + document.coordinates.len(), closures.len() + document.constraints.len()];
    let freedoms = count[0].saturating_sub(count[1]);
    let linkage = Linkage {
        graph: &graph,
        tree: &tree,
        angles: &angles,
        places: &places,
        closures: &closures,
        constants: &constants,
    };
    loads::check(document, &linkage, findings);
    let forces = loads::turned(document, &linkage, findings);
    let outputs = outputs::outputs(document, &linkage, findings);
    let frictions = Frictions::new(&linkage, findings);
    let point_names: BTreeMap<String, String> =
        graph.all_points().map(|id| (graph.full_name(id), places.name(id).to_owned())).collect();
    let near = graph.joints.iter().filter_map(|joint| {
        let point = places.name(joint.ends[0]).to_owned();
        let points = |link: usize| {
            (0..graph.points(link).len()).map(|point| places.name(PointId { link, point }).to_owned()).collect()
        };
        let links = joint.ends.iter().map(|end| end.link).filter(|link| *link != 0).map(points).collect();
        Some(NearSyntax { joint: joint.syntax.identifier.clone(), point, links, place: joint.syntax.near.clone()? })
    });
    let near = near.collect();
    let points = places.points;
    let constraints = closures.into_iter().map(|closure| closure.syntax).collect();
    document.four_bars = four_bars;
    document.near = near;
    put_before(&mut document.coordinates, coordinates);
    put_before(&mut document.points, points);
    put_before(&mut document.bodies, bodies);
    put_before(&mut document.constraints, constraints);
    document.drawing.extend(drawing);
    let own = std::mem::take(&mut document.outputs);
    document.outputs =
        own.into_iter().zip(outputs).flat_map(|(own, instead)| instead.unwrap_or_else(|| vec![own])).collect();
    document.outputs.extend(frictions.outputs);
    for ((_, load), turned) in document.loads.iter_mut().zip(forces) {
        if let (LoadSyntax::Force { force, frame, .. }, Some(turned)) = (load, turned) {
            (*force, *frame) = (turned, None);
        }
    }
    document.loads.extend(frictions.loads);
    document.for_each_point_name(|point| {
        if let Some(name) = point_names.get(&point.name) {
            point.name.clone_from(name);
        }
    });
    document.point_names = point_names;
    let unknown = start::write(document, values, freedoms, &driven);
    start::report_unknown(document, &unknown, findings);
    // Consequential errors are not reported.
    if document.is_well_formed && errors(findings) == before {
        start::report_too_few(document, freedoms, &first, findings);
    }
    document.is_well_formed &= errors(findings) == before;
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
    for (number, name) in cams::coordinates(graph) {
        let own = &graph.joints[number].syntax.identifier;
        coordinates.push(coordinate(
            name,
            "rad",
            own.span.clone(),
            format!("angle of the contact of joint {}", own.name),
        ));
    }
    coordinates
}
