//! Links that cannot turn relative to each other share one angle.

use super::graph::Graph;
use super::terms::{add, name, negate, whole};
use crate::diagnostic::{Diagnostic, Span};
use crate::document::JointKind;
use crate::parser::Formula;

/// The angles of all links.
pub(super) struct Angles {
    /// The angle coordinates, each with the link that owns it. They are numbered from 1; number 0 is the angle of the
    /// ground.
    pub(super) coordinates: Vec<(String, usize)>,
    of_links: Vec<Angle>,
}

/// The angle of a link.
#[derive(Clone)]
pub(super) struct Angle {
    /// The number of the link's angle coordinate; 0 for links that cannot turn relative to the ground.
    pub(super) class: usize,
    /// The rotation of the link relative to its angle coordinate.
    pub(super) offset: Formula,
}

impl Angles {
    pub(super) fn new(graph: &Graph) -> Self {
        let mut of_links: Vec<Option<Angle>> = vec![None; graph.links.len()];
        let mut coordinates = Vec::new();
        for link in 0..graph.links.len() {
            if of_links[link].is_some() {
                continue;
            }
            let class = if link == 0 { 0 } else { coordinates.len() + 1 };
            of_links[link] = Some(Angle { class, offset: whole(0) });
            spread(graph, &mut of_links);
            if link > 0 {
                let is_own = |other: &usize| of_links[*other].as_ref().is_some_and(|angle| angle.class == class);
                let members = (0..graph.links.len()).filter(is_own);
                let own =
                    members.filter_map(|member| Some(graph.links[member]?.coordinate.as_ref()?.name.clone())).next();
                coordinates.push((own.unwrap_or_else(|| format!("phi_{}", graph.name(link))), link));
            }
        }
        let of_links =
            of_links.into_iter().map(|angle| angle.unwrap_or(Angle { class: 0, offset: whole(0) })).collect();
        Self { coordinates, of_links }
    }

    /// Reports gears whose links cannot turn relative to each other. Warns of redundant joints that hold an angle at
    /// conflicting values, as far as the formulae show it.
    pub(super) fn check(&self, graph: &Graph, findings: &mut Vec<Diagnostic>) {
        for joint in graph.joints.iter().filter(|joint| joint.syntax.kind == JointKind::Gear) {
            let links = [joint.ends[0].link, joint.ends[1].link];
            if self.turn_together([links[0], links[1], joint.carrier]) {
                let own = &joint.syntax.identifier;
                let title = format!("joint `{}` couples the angles of links that cannot turn", own.name);
                let [first, second] = links.map(|link| graph.name(link));
                let label = format!("other joints hold `{first}` and `{second}` at one angle");
                let help = "join them by pins; a constraint couples sliders: `residual = 's_A - 2*s_B'`";
                findings.push(Diagnostic::error(title, own.span.clone(), label).help(help));
            }
        }
        for joint in graph.joints.iter().filter(|joint| joint.syntax.kind.holds_angle()) {
            let [first, second] = [0, 1].map(|end| self.angle(joint.ends[end].link).offset.clone());
            let rotation = joint.syntax.rotation.clone().unwrap_or_else(|| whole(0));
            let is_held = |a: &Formula, b: &Formula, turn: Formula| add(a.clone(), turn).nodes() == b.nodes();
            if !is_held(&second, &first, rotation.clone()) && !is_held(&first, &second, negate(rotation)) {
                let name = &joint.syntax.identifier.name;
                findings.push(Diagnostic::warning(
                    format!("other joints hold the angle of joint `{name}` too, so that its `rotation` has no effect"),
                    joint.syntax.identifier.span.clone(),
                    "one joint too many",
                ));
            }
        }
    }

    /// Whether links turn together, or not at all.
    pub(super) fn turn_together(&self, links: [usize; 3]) -> bool {
        links.iter().all(|link| self.angle(*link).class == self.angle(links[0]).class)
    }

    /// The angle of a link as a coordinate and an offset.
    pub(super) fn angle(&self, link: usize) -> &Angle {
        &self.of_links[link]
    }

    /// The angle of a link as a formula.
    pub(super) fn formula(&self, link: usize, span: &Span) -> Formula {
        let Angle { class, offset } = &self.of_links[link];
        match class {
            0 => offset.clone(),
            class => add(name(&self.coordinates[class - 1].0, span), offset.clone()),
        }
    }
}

/// Gives an angle to all links that are held by a link with a known angle.
fn spread(graph: &Graph, of_links: &mut [Option<Angle>]) {
    loop {
        let mut is_done = true;
        for joint in graph.joints.iter().filter(|joint| joint.syntax.kind.holds_angle()) {
            let (first, second) = (joint.ends[0].link, joint.ends[1].link);
            let rotation = joint.syntax.rotation.clone().unwrap_or_else(|| whole(0));
            let (known, other, turn) = match (&of_links[first], &of_links[second]) {
                (None, Some(known)) => (known.clone(), first, rotation),
                (Some(known), None) => (known.clone(), second, negate(rotation)),
                _ => continue,
            };
            of_links[other] = Some(Angle { class: known.class, offset: add(known.offset, turn) });
            is_done = false;
        }
        if is_done {
            return;
        }
    }
}
