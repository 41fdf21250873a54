//! The outline of a plate.

use crate::motion::Node;

/// The nodes on the convex hull, in order. A single frame suffices, since bodies are rigid.
pub(super) fn hull(nodes: &[Node], ids: &[usize]) -> Vec<usize> {
    let at = |id: usize| [nodes[id].x[0], nodes[id].y[0]];
    let mut sorted = ids.to_vec();
    sorted.sort_by(|a, b| at(*a)[0].total_cmp(&at(*b)[0]).then(at(*a)[1].total_cmp(&at(*b)[1])));
    let turn = |a: usize, b: usize, c: usize| {
        let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(at);
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    };
    let side = |ids: &mut dyn Iterator<Item = usize>| {
        let mut chain: Vec<usize> = Vec::new();
        for id in ids {
            while let [.., a, b] = chain[..]
                && turn(a, b, id) <= 0.0
            {
                chain.pop();
            }
            chain.push(id);
        }
        chain.pop();
        chain
    };
    let mut ring = side(&mut sorted.iter().copied());
    ring.extend(side(&mut sorted.iter().rev().copied()));
    if ring.is_empty() { ids.to_vec() } else { ring }
}
