//! Gears that mesh: their axes, and the forces of their teeth.

use super::Linkage;
use super::constants::Constants;
use super::graph::{Graph, Joint, PointId};
use super::terms::{difference, divide, dot, multiply, negate, subtract, whole};
use crate::document::{Identifier, JointKind};
use crate::parser::Formula;

/// Two gears whose teeth mesh.
pub(super) struct Mesh {
    /// Their axes, as points of the carrier.
    pub(super) axes: [PointId; 2],
    /// Which of them is a ring, with teeth inside.
    pub(super) ring: Option<usize>,
}

impl Mesh {
    /// The gears of a joint; `None` if it turns its links in another way, or they have no axes apart from each other on
    /// the carrier.
    pub(super) fn new(graph: &Graph, constants: &Constants, joint: &Joint) -> Option<Self> {
        if joint.syntax.kind != JointKind::Gear || joint.syntax.radii.is_some() {
            return None;
        }
        let links = [joint.ends[0].link, joint.ends[1].link];
        let [Some(first), Some(second)] = links.map(|link| axis(graph, constants, link, joint.carrier)) else {
            return None;
        };
        if constants.are_same(&graph.local(first), &graph.local(second)) {
            return None;
        }
        let ratio = constants.value(joint.syntax.size.as_ref()?);
        let ring = usize::from(ratio > 1.0);
        let is_coaxial = |axis: PointId| {
            let is_same = |own: PointId| constants.are_same(&graph.local(own), &graph.local(axis));
            let carrier = joint.carrier;
            carrier != 0 && (links[ring] == 0 || pins(graph, carrier, 0).any(|(own, _)| is_same(own)))
        };
        let axes = [first, second];
        if ratio < 0.0 {
            Some(Self { axes, ring: None })
        } else if ratio > 0.0 && ratio != 1.0 && is_coaxial(axes[ring]) {
            Some(Self { axes, ring: Some(ring) })
        } else {
            None
        }
    }
}

/// The point of the carrier about which a link turns on it: that of a pin of both, or of pins of both in one place of a
/// third link.
pub(super) fn axis(graph: &Graph, constants: &Constants, link: usize, carrier: usize) -> Option<PointId> {
    if let Some((_, on_carrier)) = pins(graph, link, carrier).next() {
        return Some(on_carrier);
    }
    let others = (0..graph.links.len()).filter(|other| *other != link && *other != carrier);
    let shared = others.flat_map(|other| {
        let own = pins(graph, link, other);
        own.flat_map(move |(_, at)| pins(graph, carrier, other).map(move |(on_carrier, to)| (at, to, on_carrier)))
    });
    let mut shared = shared.filter(|(at, to, _)| constants.are_same(&graph.local(*at), &graph.local(*to)));
    shared.next().map(|(.., on_carrier)| on_carrier)
}

/// The points of two links that pins hold together.
fn pins<'g>(graph: &'g Graph, first: usize, second: usize) -> impl Iterator<Item = (PointId, PointId)> + 'g {
    let joints = graph.joints.iter().filter(|joint| joint.syntax.kind == JointKind::Revolute);
    joints.filter_map(move |joint| {
        let end = |link: usize| joint.ends.iter().find(|end| end.link == link).copied();
        end(first).zip(end(second))
    })
}

/// What the teeth of gears add to the force that a pin has on the link of one of its ends: multiples of the
/// multipliers of gears.
///
/// The constraint of gears with the ratio `i` turns them by moments: `-lambda` the first one. Teeth do so by a force
/// `-lambda (1 - i)/a` on the first gear, across the line of the axes, which are `a` apart; the pins between gear and
/// carrier hold it. The part along that line, by which teeth push gears apart, does no work and is left out.
pub(super) fn forces_of_teeth(
    linkage: &Linkage,
    number: usize,
    on: PointId,
    direction: [i32; 2],
) -> Vec<(Identifier, Formula)> {
    let Linkage { graph, places, constants, .. } = linkage;
    let pin = &graph.joints[number];
    if pin.syntax.kind != JointKind::Revolute {
        return Vec::new();
    }
    let here = in_one_place(linkage, number, &[on]);
    let others: Vec<PointId> = pin.ends.iter().copied().filter(|end| *end != on).collect();
    let there = in_one_place(linkage, number, &others);
    let force = |joint: &Joint| {
        let mesh = Mesh::new(graph, constants, joint)?;
        let between = |gear: usize| {
            let carried = |one: &[usize], other: &[usize]| one.contains(&gear) && other.contains(&joint.carrier);
            i32::from(carried(&here, &there)) - i32::from(carried(&there, &here))
        };
        let factor = between(joint.ends[0].link) - between(joint.ends[1].link);
        if factor == 0 {
            return None;
        }
        let span = &joint.syntax.identifier.span;
        let [first, second] = mesh.axes.map(|axis| places.components(axis, span));
        let apart = difference(second, first);
        let [x, y] = apart.clone();
        let across = dot([negate(y), x], direction.map(whole));
        let ratio = joint.syntax.size.clone()?;
        let size = multiply(multiply(whole(factor), subtract(whole(1), ratio)), across);
        Some((joint.syntax.identifier.clone(), divide(size, dot(apart.clone(), apart))))
    };
    graph.joints.iter().filter_map(force).collect()
}

/// The links that other pins than this one hold in one place with some of its ends.
fn in_one_place(linkage: &Linkage, but: usize, ends: &[PointId]) -> Vec<usize> {
    let Linkage { graph, constants, .. } = linkage;
    let pins =
        || graph.joints.iter().enumerate().filter(|(number, joint)| *number != but && joint.syntax.kind.is_pin());
    let is_same = |a: &PointId, b: &PointId| {
        a.link == b.link && (a == b || constants.are_same(&graph.local(*a), &graph.local(*b)))
    };
    let mut found = ends.to_vec();
    let mut next = 0;
    while next < found.len() {
        for (_, joint) in pins() {
            if joint.ends.iter().any(|end| is_same(end, &found[next])) {
                let more: Vec<PointId> = joint.ends.iter().copied().filter(|end| !found.contains(end)).collect();
                found.extend(more);
            }
        }
        next += 1;
    }
    found.into_iter().map(|end| end.link).collect()
}
