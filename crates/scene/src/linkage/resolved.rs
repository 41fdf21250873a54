//! The resolved links and joints, once every link has its position.

use super::angles::Angles;
use super::closures::JointConstraint;
use super::constants::Constants;
use super::graph::{Graph, PointId};
use super::places::Places;
use super::tree::Tree;
use crate::document::{DisplacementSyntax, Identifier};
use crate::parser::Formula;

/// Links and joints with all derived data.
pub(super) struct Linkage<'l> {
    pub(super) graph: &'l Graph<'l>,
    pub(super) tree: &'l Tree,
    pub(super) angles: &'l Angles,
    pub(super) places: &'l Places,
    pub(super) closures: &'l [JointConstraint],
    pub(super) constants: &'l Constants<'l>,
}

/// A displacement of all links that a joint of the tree places by its end.
pub(super) fn displacement_through(linkage: &Linkage, end: PointId, along: [Formula; 2]) -> DisplacementSyntax {
    let (bodies, points) = linkage.bodies_and_points(&linkage.tree.placed_through(end.link));
    DisplacementSyntax { bodies, points, along: Some(along), turn: None, slide: None }
}

impl Linkage<'_> {
    /// Whether a point has this name, in the expanded scene or as `LINK.POINT`.
    pub(super) fn is_named(&self, id: PointId, name: &str) -> bool {
        self.places.name(id) == name || self.graph.full_name(id) == name
    }

    /// The bodies and points of links.
    pub(super) fn bodies_and_points(&self, links: &[usize]) -> (Vec<Identifier>, Vec<Identifier>) {
        let identifier = |link: usize, name: &str| Identifier { name: name.to_owned(), span: self.graph.span(link) };
        let has_mass = |link: usize| self.graph.links[link].is_some_and(|link| link.mass.is_some());
        let is_body = |link: &&usize| has_mass(**link) || self.angles.angle(**link).class > 0;
        let bodies = links.iter().filter(is_body).map(|link| identifier(*link, self.graph.name(*link)));
        let points = self.graph.all_points().filter(|id| links.contains(&id.link));
        (bodies.collect(), points.map(|id| identifier(id.link, self.places.name(id))).collect())
    }
}
