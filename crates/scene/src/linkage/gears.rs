//! Gears that mesh: their axes, and the forces of their teeth.

use super::constants::Constants;
use super::graph::{Graph, Joint, PointId};
use super::resolved::Linkage;
use super::terms::{difference, divide, dot, multiply, negate, rotated, subtract, whole};
use crate::document::{Identifier, JointKind};
use crate::parser::Formula;

/// Two gears whose teeth mesh.
pub(super) struct Mesh {
    /// The axes of the gears, as points of the carrier.
    pub(super) axes: [PointId; 2],
    /// The end whose gear is a ring, with teeth inside.
    pub(super) ring: Option<usize>,
}

impl Mesh {
    /// The gears of a joint; `None` if they do not mesh, or have no separate axes on the carrier.
    pub(super) fn new(graph: &Graph, constants: &Constants, joint: &Joint) -> Option<Self> {
        if joint.syntax.kind != JointKind::Gear || joint.syntax.radii.is_some() {
            return None;
        }
        let axis = |end: usize| axis(graph, constants, joint.ends[end].link, joint.carrier);
        let axes = [axis(0)?, axis(1)?];
        if axes[0].link == axes[1].link && constants.are_same(&graph.local(axes[0]), &graph.local(axes[1])) {
            return None;
        }
        let ratio = constants.value(joint.syntax.size.as_ref()?);
        let ring = (ratio > 0.0).then_some(usize::from(ratio > 1.0));
        (ratio != 1.0 && ratio != 0.0).then_some(Self { axes, ring })
    }
}

/// The point of the carrier, or of a link welded to it, about which a link turns. The point belongs to a pin between
/// the two, or to pins of both at one point of a third link.
pub(super) fn axis(graph: &Graph, constants: &Constants, link: usize, carrier: usize) -> Option<PointId> {
    let [own, carrier] =
        [link, carrier].map(|link| graph.joined(vec![link], |_, joint| joint.syntax.kind == JointKind::Weld));
    if let Some((_, on_carrier)) = pins(graph, &own, &carrier).next() {
        return Some(on_carrier);
    }
    let others: Vec<usize> =
        (0..graph.links.len()).filter(|other| !own.contains(other) && !carrier.contains(other)).collect();
    pins(graph, &own, &others).find_map(|(_, at)| {
        let is_here = |to: &PointId| to.link == at.link && constants.are_same(&graph.local(at), &graph.local(*to));
        pins(graph, &carrier, &[at.link]).find(|(_, to)| is_here(to)).map(|(on_carrier, _)| on_carrier)
    })
}

/// The pairs of points of two groups of links that pins hold together.
fn pins<'g>(
    graph: &'g Graph,
    first: &'g [usize],
    second: &'g [usize],
) -> impl Iterator<Item = (PointId, PointId)> + 'g {
    let joints = graph.joints.iter().filter(|joint| joint.syntax.kind == JointKind::Revolute);
    joints.filter_map(move |joint| {
        let end = |links: &[usize]| joint.ends.iter().find(|end| links.contains(&end.link)).copied();
        end(first).zip(end(second))
    })
}

/// The contribution of teeth to the force that a pin or a weld exerts on the link of one of its ends, along a
/// direction. It consists of multiples of gear multipliers.
///
/// A gear constraint with the ratio `i` acts by moments; the first gear's is `-lambda`. Real teeth act by a force
/// `-lambda (1 - i)/a` on the first gear, perpendicular to the line between the axes, which are `a` apart; the joints
/// between gear and carrier balance it. The force along that line, by which teeth push gears apart, does no work and is
/// neglected.
pub(super) fn forces_of_teeth(
    linkage: &Linkage,
    number: usize,
    on: PointId,
    direction: [i32; 2],
) -> Vec<(Identifier, Formula)> {
    work_of_teeth(linkage, number, on, |_| direction.map(whole))
}

/// The contribution of teeth to the moment that a weld exerts on the link of one of its ends, about its point.
pub(super) fn moments_of_teeth(linkage: &Linkage, number: usize, on: PointId) -> Vec<(Identifier, Formula)> {
    let span = &linkage.graph.joints[number].syntax.identifier.span;
    let place = |point: PointId| linkage.places.components(point, span);
    work_of_teeth(linkage, number, on, |axis| {
        let [x, y] = difference(place(axis), place(on));
        [negate(y), x]
    })
}

/// The work of teeth in a virtual displacement of all links that a pin or a weld holds on the side of one of its ends.
/// The displacement is given for each axis.
fn work_of_teeth(
    linkage: &Linkage,
    number: usize,
    on: PointId,
    displacement: impl Fn(PointId) -> [Formula; 2],
) -> Vec<(Identifier, Formula)> {
    let Linkage { graph, constants, .. } = linkage;
    if !graph.joints[number].syntax.kind.is_pin() {
        return Vec::new();
    }
    let work = |joint: &Joint| {
        let Mesh { axes, .. } = Mesh::new(graph, constants, joint)?;
        let sides = [0, 1].map(|end| side(linkage, number, on, (joint, end, axes[end])));
        if sides == [0, 0] {
            return None;
        }
        let ([x, y], square) = apart(linkage, joint, axes);
        let across = [negate(y), x];
        let moved = |end: usize| dot(across.clone(), displacement(axes[end]));
        let work = match sides {
            [side, 0] => multiply(whole(side), moved(0)),
            [0, side] => multiply(whole(-side), moved(1)),
            [first, second] => subtract(multiply(whole(first), moved(0)), multiply(whole(second), moved(1))),
        };
        let factor = divide(subtract(whole(1), joint.syntax.size.clone()?), square);
        Some((joint.syntax.identifier.clone(), multiply(factor, work)))
    };
    graph.joints.iter().filter_map(work).collect()
}

/// The vector between two axes, and its squared length.
fn apart(linkage: &Linkage, joint: &Joint, axes: [PointId; 2]) -> ([Formula; 2], Formula) {
    let Linkage { graph, angles, places, .. } = linkage;
    let span = &joint.syntax.identifier.span;
    let square = |vector: &[Formula; 2]| dot(vector.clone(), vector.clone());
    if axes[0].link == axes[1].link {
        let local = difference(graph.local(axes[1]), graph.local(axes[0]));
        let square = square(&local);
        return (rotated(local, &angles.formula(axes[0].link, span)), square);
    }
    let vector = difference(places.components(axes[1], span), places.components(axes[0], span));
    let square = square(&vector);
    (vector, square)
}

/// The side of a joint between a gear and its carrier: 1 if the gear is on the side of this end, -1 if the carrier is,
/// 0 if both are on one side. Other connections of gear and carrier are pins on the axis, or welds anywhere.
fn side(linkage: &Linkage, number: usize, on: PointId, (joint, end, axis): (&Joint, usize, PointId)) -> i32 {
    let (gear, carrier) = (joint.ends[end].link, joint.carrier);
    let asked = &linkage.graph.joints[number];
    let pinned = on_axis(linkage, axis);
    let holds =
        |own: usize, joint: &Joint| own != number && (joint.syntax.kind == JointKind::Weld || pinned.contains(&own));
    let here = linkage.graph.joined(vec![on.link], holds);
    let others = asked.ends.iter().filter(|end| **end != on).map(|end| end.link);
    let there = linkage.graph.joined(others.collect(), holds);
    let is_between = |one: &[usize], other: &[usize]| one.contains(&gear) && other.contains(&carrier);
    i32::from(is_between(&here, &there)) - i32::from(is_between(&there, &here))
}

/// The numbers of the pins on an axis.
fn on_axis(linkage: &Linkage, axis: PointId) -> Vec<usize> {
    let Linkage { graph, constants, .. } = linkage;
    let is_same = |a: &PointId, b: &PointId| {
        a.link == b.link && (a == b || constants.are_same(&graph.local(*a), &graph.local(*b)))
    };
    let mut points = vec![axis];
    let mut pins = Vec::new();
    let mut next = 0;
    while next < points.len() {
        for (number, joint) in graph.joints.iter().enumerate() {
            if joint.syntax.kind.is_pin()
                && !pins.contains(&number)
                && joint.ends.iter().any(|end| is_same(end, &points[next]))
            {
                pins.push(number);
                points.extend(&joint.ends);
            }
        }
        next += 1;
    }
    pins
}
