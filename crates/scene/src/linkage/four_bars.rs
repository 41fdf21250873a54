//! Loops of four links and four pins.

use super::angles::Angles;
use super::graph::{Graph, PointId};
use super::places::Places;
use crate::document::{FourBar, JointKind};

/// The ground.
const GROUND: usize = 0;

/// Finds the loops of four pins that contain the ground.
pub(super) fn four_bars(graph: &Graph, angles: &Angles, places: &Places) -> Vec<FourBar> {
    let pins = pins(graph);
    let from = |link: usize| pins.iter().filter(move |pin| pin.from.link == link);
    let mut found: Vec<FourBar> = Vec::new();
    for first in from(GROUND) {
        for second in from(first.to.link) {
            for third in from(second.to.link) {
                for last in from(third.to.link).filter(|pin| pin.to.link == GROUND) {
                    let links = [GROUND, first.to.link, second.to.link, third.to.link];
                    let joints = [first, second, third, last].map(|pin| pin.joint);
                    let classes = links.map(|link| angles.angle(link).class);
                    // Each loop is found in both directions.
                    if links[1] > links[3] || has_twice(&joints) || has_twice(&classes) {
                        continue;
                    }
                    let sides = [[last, first], [first, second], [second, third], [third, last]];
                    let name = |id: PointId| places.name(id).to_owned();
                    found.push(FourBar {
                        links: links.map(|link| graph.name(link).to_owned()),
                        sides: sides.map(|[before, after]| [name(before.to), name(after.from)]),
                        angles: [1, 3].map(|place| angles.coordinates[classes[place] - 1].0.clone()),
                    });
                }
            }
        }
    }
    found
}

/// A pin between two links.
struct Pin {
    joint: usize,
    from: PointId,
    to: PointId,
}

fn pins(graph: &Graph) -> Vec<Pin> {
    let joints = graph.joints.iter().enumerate().filter(|(_, joint)| joint.syntax.kind == JointKind::Revolute);
    let pairs = joints.flat_map(|(number, joint)| {
        let from = move |from: &PointId| {
            let from = *from;
            let others = joint.ends.iter().filter(move |to| to.link != from.link);
            others.map(move |to| Pin { joint: number, from, to: *to })
        };
        joint.ends.iter().flat_map(from)
    });
    pairs.collect()
}

fn has_twice(numbers: &[usize; 4]) -> bool {
    (1..4).any(|i| numbers[..i].contains(&numbers[i]))
}
