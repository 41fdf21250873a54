//! Links as nodes and joints as edges, by their numbers.

use crate::diagnostic::{Diagnostic, Span};
use crate::document::{Document, Identifier, JointSyntax, LinkSyntax};
use crate::names::suggestion;

/// The name of the link that does not move.
pub(super) const GROUND: &str = "ground";

/// Links and joints.
pub(super) struct Graph<'d> {
    /// All links by number. The ground is always the first, even if the scene does not mention it.
    pub(super) links: Vec<Option<&'d LinkSyntax>>,
    pub(super) joints: Vec<Joint<'d>>,
}

/// A joint.
pub(super) struct Joint<'d> {
    pub(super) syntax: &'d JointSyntax,
    pub(super) ends: Vec<PointId>,
    /// The number of the link that carries the gears.
    pub(super) carrier: usize,
}

/// A point of a link: the number of the link, and of the point in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct PointId {
    pub(super) link: usize,
    pub(super) point: usize,
}

impl<'d> Graph<'d> {
    /// Looks up the links and points of all joints; `None` if one of them is unknown.
    pub(super) fn new(document: &'d Document, findings: &mut Vec<Diagnostic>) -> Option<Self> {
        let before = findings.len();
        let ground = document.links.iter().find(|link| link.identifier.name == GROUND);
        if let Some(ground) = ground {
            check_ground(ground, findings);
        }
        let moving = document.links.iter().filter(|link| link.identifier.name != GROUND).map(Some);
        let mut graph = Self { links: std::iter::once(ground).chain(moving).collect(), joints: Vec::new() };
        for link in &document.links {
            for (place, (point, _)) in link.points.iter().enumerate() {
                if link.points[..place].iter().any(|(other, _)| other.name == point.name) {
                    let title = format!("link `{}` has two points `{}`", link.identifier.name, point.name);
                    findings.push(
                        Diagnostic::error(title, point.span.clone(), "the second one").help("choose another name"),
                    );
                }
            }
        }
        for syntax in &document.joints {
            let ends: Vec<PointId> = syntax.ends.iter().filter_map(|end| graph.end(end, findings)).collect();
            for (place, end) in ends.iter().enumerate() {
                if ends[..place].iter().any(|other| other.link == end.link) {
                    let (joint, link) = (&syntax.identifier.name, graph.name(end.link));
                    let title = format!("joint `{joint}` joins link `{link}` to itself");
                    let error = Diagnostic::error(title, syntax.ends[place].link.span.clone(), "the second time");
                    findings.push(error.help("name another link, or take this one out"));
                }
            }
            let carrier = syntax.carrier.as_ref().and_then(|end| graph.end(end, findings));
            graph.joints.push(Joint { syntax, ends, carrier: carrier.map_or(0, |end| end.link) });
        }
        (findings.len() == before).then_some(graph)
    }

    fn end(&self, end: &crate::document::LinkPoint, findings: &mut Vec<Diagnostic>) -> Option<PointId> {
        let names: Vec<&str> = (0..self.links.len()).map(|link| self.name(link)).collect();
        let Some(link) = names.iter().position(|name| *name == end.link.name) else {
            findings.push(unknown("link", &end.link, &names));
            return None;
        };
        // Gears are joined only by their angles.
        let Some(named) = &end.point else { return Some(PointId { link, point: 0 }) };
        let points: Vec<&str> = self.points(link).iter().map(|(point, _)| point.name.as_str()).collect();
        let Some(point) = points.iter().position(|name| *name == named.name) else {
            let title = format!("link `{}` has no point `{}`", end.link.name, named.name);
            let known = || match &points[..] {
                [] => format!("give it points: `{} = {{ points = {{ {} = [x, y] }} }}`", end.link.name, named.name),
                points => format!("its points: {}; write `\"{}.POINT\"`", points.join(", "), end.link.name),
            };
            let help = suggestion(&named.name, points.iter().copied(), known);
            findings.push(Diagnostic::error(title, named.span.clone(), "not known").help(help));
            return None;
        };
        Some(PointId { link, point })
    }

    /// Some links, and all links connected to them by joints for which `counts` is true.
    pub(super) fn joined(&self, mut links: Vec<usize>, counts: impl Fn(usize, &Joint) -> bool) -> Vec<usize> {
        let mut next = 0;
        while next < links.len() {
            for (_, joint) in self.joints.iter().enumerate().filter(|(number, joint)| counts(*number, joint)) {
                if joint.ends.iter().any(|end| end.link == links[next]) {
                    let ends = joint.ends.iter().map(|end| end.link);
                    let more: Vec<usize> = ends.filter(|link| !links.contains(link)).collect();
                    links.extend(more);
                }
            }
            next += 1;
        }
        links
    }

    /// The name of a link.
    pub(super) fn name(&self, link: usize) -> &'d str {
        self.links[link].map_or(GROUND, |link| &link.identifier.name)
    }

    /// The points of a link, in its frame.
    pub(super) fn points(&self, link: usize) -> &'d [(Identifier, [crate::parser::Formula; 2])] {
        self.links[link].map_or(&[], |link| &link.points)
    }

    /// A point in the frame of its link.
    pub(super) fn local(&self, id: PointId) -> [crate::parser::Formula; 2] {
        self.points(id.link)[id.point].1.clone()
    }

    /// The name of a point in its link.
    pub(super) fn point_name(&self, id: PointId) -> &'d str {
        &self.points(id.link)[id.point].0.name
    }

    /// The name of a point with that of its link, `LINK.POINT`.
    pub(super) fn full_name(&self, id: PointId) -> String {
        format!("{}.{}", self.name(id.link), self.point_name(id))
    }

    /// All points of all links.
    pub(super) fn all_points(&self) -> impl Iterator<Item = PointId> {
        (0..self.links.len()).flat_map(|link| (0..self.points(link).len()).map(move |point| PointId { link, point }))
    }

    /// The location of a link in the text.
    pub(super) fn span(&self, link: usize) -> Span {
        self.links[link].map_or(0..0, |link| link.identifier.span.clone())
    }
}

/// Reports entries of the ground other than points.
fn check_ground(ground: &LinkSyntax, findings: &mut Vec<Diagnostic>) {
    let has_more = ground.mass.is_some()
        || ground.inertia.is_some()
        || ground.com.is_some()
        || ground.coordinate.is_some()
        || ground.angle.is_some()
        || ground.rate.is_some();
    if has_more {
        let error = Diagnostic::error("the ground does not move", ground.identifier.span.clone(), "has points alone");
        findings.push(error.help("take out all keys but `points`, or give the link another name"));
    }
}

fn unknown(what: &str, identifier: &Identifier, names: &[&str]) -> Diagnostic {
    let help = suggestion(&identifier.name, names.iter().copied(), || format!("known {what}s: {}", names.join(", ")));
    Diagnostic::error(format!("unknown {what} `{}`", identifier.name), identifier.span.clone(), "not known").help(help)
}
