//! The positions of the points of all links, as points of an ordinary scene.

use std::collections::HashMap;

use super::angles::Angles;
use super::graph::{Graph, PointId};
use super::terms::{add, difference, direction, dot, is_zero, multiply, name, rotated, subtract, sum};
use super::tree::{Placement, Tree};
use crate::diagnostic::Span;
use crate::document::{Identifier, JointKind};
use crate::parser::Formula;

/// The points of the expanded scene.
pub(super) struct Places {
    /// Names and formulae, each after those that it uses.
    pub(super) points: Vec<(Identifier, [Formula; 2])>,
    names: HashMap<PointId, String>,
    /// Whether the centre of mass of a link that the ground guides along a line stays on that line.
    guides: bool,
}

impl Places {
    /// Computes the points of all links. Unless they are `shared`, each link has its own points at the pins of the
    /// tree. With `guides`, the centre of mass of a link that the ground guides along a line stays on that line.
    pub(super) fn new(graph: &Graph, tree: &Tree, angles: &Angles, shared: bool, guides: bool) -> Self {
        let representatives = representatives(graph, tree, shared);
        let mut places = Self { points: Vec::new(), names: names(graph, tree, &representatives), guides };
        for &link in &tree.order {
            places.place(graph, tree, angles, link, &representatives);
        }
        places
    }

    /// The name of a point.
    pub(super) fn name(&self, id: PointId) -> &str {
        &self.names[&id]
    }

    /// The plain name of a point in its link, if some point of the expanded scene has that name; otherwise the point's
    /// own name.
    pub(super) fn short_name<'n>(&'n self, graph: &Graph<'n>, id: PointId) -> &'n str {
        let short = graph.point_name(id);
        if self.names.values().any(|name| name == short) { short } else { self.name(id) }
    }

    /// The components of a point, as names.
    pub(super) fn components(&self, id: PointId, span: &Span) -> [Formula; 2] {
        ["x", "y"].map(|axis| name(format!("{}.{axis}", self.name(id)), span))
    }

    /// Adds the points of a link.
    fn place(
        &mut self,
        graph: &Graph,
        tree: &Tree,
        angles: &Angles,
        link: usize,
        representatives: &HashMap<PointId, PointId>,
    ) {
        let span = graph.span(link);
        let own = |point: usize| PointId { link, point };
        let points = graph.points(link);
        let base = match tree.placements[link] {
            Placement::Ground | Placement::Free => None,
            Placement::Pin { at, own, .. } => {
                if representatives[&own] == own {
                    let place = self.components(at, &span);
                    self.points.push((self.identifier(graph, own), place));
                }
                Some(own)
            }
            Placement::Slider { joint, at, own } => {
                let place = slid(self, graph, angles, (joint, at, own));
                self.points.push((self.identifier(graph, own), place));
                Some(own)
            }
        };
        let angle = angles.formula(link, &span);
        for point in 0..points.len() {
            let id = own(point);
            if base == Some(id) && representatives[&id] == id {
                continue;
            }
            let place = match base {
                _ if representatives[&id] != id && self.names[&id] == self.names[&representatives[&id]] => continue,
                _ if representatives[&id] != id => self.components(representatives[&id], &span),
                Some(base) => {
                    let local = difference(graph.local(id), graph.local(base));
                    sum(self.components(base, &span), rotated(local, &angle))
                }
                None if tree.placements[link] == Placement::Free => {
                    sum(origin(graph, link), rotated(graph.local(id), &angle))
                }
                None => graph.local(id),
            };
            self.points.push((self.identifier(graph, id), place));
        }
    }

    /// The position of a vector in the frame of a link that a joint guides along a line of the ground, restricted to
    /// that line. `None` without such a joint, and if joint forces are needed: the multiplier of the joint would lack
    /// the forces perpendicular to the line.
    pub(super) fn guided(
        &self,
        graph: &Graph,
        tree: &Tree,
        angles: &Angles,
        link: usize,
        local: [Formula; 2],
    ) -> Option<[Formula; 2]> {
        let span = graph.span(link);
        let joint = ground_guide(graph, tree, link).filter(|_| self.guides)?;
        let [point, on] = [graph.joints[joint].ends[0], graph.joints[joint].ends[1]];
        let from = self.components(on, &span);
        let along = line(graph, angles, joint);
        let point_place = self.components(point, &span);
        let foot = if is_zero(&along[1]) {
            let ([x, _], [_, y]) = (point_place, from);
            [x, y]
        } else {
            let way = dot(difference(point_place, from.clone()), along.clone());
            sum(from, along.map(|part| multiply(way.clone(), part)))
        };
        Some(sum(foot, rotated(difference(local, graph.local(point)), &angles.formula(link, &span))))
    }

    /// The position of a vector in the frame of a link.
    pub(super) fn local_position(
        &self,
        graph: &Graph,
        tree: &Tree,
        angles: &Angles,
        link: usize,
        local: [Formula; 2],
    ) -> [Formula; 2] {
        let span = graph.span(link);
        let angle = angles.formula(link, &span);
        match tree.placements[link] {
            Placement::Pin { own, .. } | Placement::Slider { own, .. } => {
                sum(self.components(own, &span), rotated(difference(local, graph.local(own)), &angle))
            }
            Placement::Free => sum(origin(graph, link), rotated(local, &angle)),
            Placement::Ground => local,
        }
    }

    fn identifier(&self, graph: &Graph, id: PointId) -> Identifier {
        Identifier { name: self.names[&id].clone(), span: graph.points(id.link)[id.point].0.span.clone() }
    }
}

/// The name of the coordinate of a slider.
pub(super) fn slide(graph: &Graph, joint: usize) -> String {
    format!("s_{}", graph.joints[joint].syntax.identifier.name)
}

/// The names of the coordinates of the origin of a link.
pub(super) fn origin_names(graph: &Graph, link: usize) -> [String; 2] {
    ["x", "y"].map(|axis| format!("{axis}_{}", graph.name(link)))
}

fn origin(graph: &Graph, link: usize) -> [Formula; 2] {
    origin_names(graph, link).map(|axis| name(axis, &graph.span(link)))
}

/// The joint by which the ground guides a link that the tree does not place by it.
fn ground_guide(graph: &Graph, tree: &Tree, link: usize) -> Option<usize> {
    graph.joints.iter().enumerate().position(|(number, joint)| {
        joint.syntax.kind == JointKind::Prismatic
            && (joint.ends[0].link, joint.ends[1].link) == (link, 0)
            && !tree.places(number, joint.ends[0])
    })
}

/// The direction of the line of a slider.
pub(super) fn line(graph: &Graph, angles: &Angles, joint: usize) -> [Formula; 2] {
    let syntax = graph.joints[joint].syntax;
    let span = &syntax.identifier.span;
    let angle = angles.formula(graph.joints[joint].ends[1].link, span);
    direction(&syntax.direction.clone().map_or(angle.clone(), |own| add(angle, own)))
}

/// The position of a link that a slider places: that of `own`, given that of `at`.
fn slid(places: &Places, graph: &Graph, angles: &Angles, (joint, at, own): (usize, PointId, PointId)) -> [Formula; 2] {
    let span = &graph.joints[joint].syntax.identifier.span;
    let way = line(graph, angles, joint).map(|part| multiply(name(slide(graph, joint), span), part));
    let from = places.components(at, span);
    // The line belongs to the second link.
    if graph.joints[joint].ends[0] == own { sum(from, way) } else { difference(from, way) }
}

/// For each point, the coinciding point of the link nearest to the ground, by joints of the tree.
fn representatives(graph: &Graph, tree: &Tree, shared: bool) -> HashMap<PointId, PointId> {
    let mut representatives: HashMap<PointId, PointId> = graph.all_points().map(|id| (id, id)).collect();
    for &link in tree.order.iter().filter(|_| shared) {
        if let Placement::Pin { at, own, .. } = tree.placements[link] {
            let of = representatives[&at];
            representatives.insert(own, of);
        }
    }
    representatives
}

/// Names in the expanded scene: the names in the links, prefixed by the name of the link where links use one name for
/// different positions.
fn names(graph: &Graph, tree: &Tree, representatives: &HashMap<PointId, PointId>) -> HashMap<PointId, String> {
    let pins: Vec<&[PointId]> =
        graph.joints.iter().filter(|joint| joint.syntax.kind.is_pin()).map(|joint| &joint.ends[..]).collect();
    let joined = |a: PointId, b: PointId| {
        let of =
            |id: PointId| move |ends: &&&[PointId]| ends.iter().any(|end| representatives[end] == representatives[&id]);
        representatives[&a] == representatives[&b] || pins.iter().filter(of(a)).any(|ends| of(b)(&ends))
    };
    let place = |id: &PointId| tree.order.iter().position(|link| *link == id.link);
    let mut ids: Vec<PointId> = graph.all_points().collect();
    ids.sort_by_key(|id| (place(id), id.point));
    let mut names = HashMap::new();
    for &id in &ids {
        let own = graph.point_name(id);
        let same: Vec<PointId> = ids.iter().copied().filter(|other| graph.point_name(*other) == own).collect();
        let first = same[0];
        let is_plain =
            same.iter().all(|other| joined(first, *other)) && representatives[&id] == representatives[&first];
        names.insert(id, if is_plain { own.to_owned() } else { format!("{}_{own}", graph.name(id.link)) });
    }
    names
}

/// The distance of a point from a line: the residual that keeps the point on the line.
pub(super) fn distance_from_line(places: &Places, graph: &Graph, angles: &Angles, joint: usize) -> Formula {
    let span = &graph.joints[joint].syntax.identifier.span;
    let [point, on] = [0, 1].map(|end| places.components(graph.joints[joint].ends[end], span));
    let [cos, sin] = line(graph, angles, joint);
    let [x, y] = difference(point, on);
    subtract(multiply(y, cos), multiply(x, sin))
}
