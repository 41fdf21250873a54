//! The spanning tree: how the place of each link follows from that of another one.

use super::graph::{Graph, Joint, PointId};

/// How the place of a link is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placement {
    /// The link is the ground.
    Ground,
    /// One of its points is that of a link before it.
    Pin {
        /// The joint.
        joint: usize,
        /// The point of the link before it.
        at: PointId,
        /// The point of the link that the pin places.
        own: PointId,
    },
    /// One of its points is at a distance from that of a link before it, which is a coordinate.
    Slider {
        /// The joint.
        joint: usize,
        /// The point of the link before it.
        at: PointId,
        /// The point of the link that the slider places.
        own: PointId,
    },
    /// No joint places it: its origin has two coordinates.
    Free,
}

/// The spanning tree with the fewest coordinates: sliders are in it only where no pin is.
pub(super) struct Tree {
    /// By the number of the link.
    pub(super) placements: Vec<Placement>,
    /// The links, each after the one that places it.
    pub(super) order: Vec<usize>,
}

impl Tree {
    pub(super) fn new(graph: &Graph) -> Self {
        let mut depths: Vec<Option<usize>> = vec![None; graph.links.len()];
        let mut tree = Self { placements: vec![Placement::Ground; graph.links.len()], order: vec![0] };
        depths[0] = Some(0);
        while let Some(free) = depths.iter().position(Option::is_none) {
            let (link, placement, depth) = nearest(graph, &depths).unwrap_or((free, Placement::Free, 1));
            tree.placements[link] = placement;
            tree.order.push(link);
            depths[link] = Some(depth);
        }
        tree
    }

    /// A link and all links that are placed by it.
    pub(super) fn beyond(&self, link: usize) -> Vec<usize> {
        let mut links = vec![link];
        for &other in &self.order {
            if let Placement::Pin { at, .. } | Placement::Slider { at, .. } = self.placements[other]
                && links.contains(&at.link)
                && !links.contains(&other)
            {
                links.push(other);
            }
        }
        links
    }

    /// Whether a joint places this end by another end of it.
    pub(super) fn places(&self, joint: usize, end: PointId) -> bool {
        self.bearer(joint, end).is_some()
    }

    /// The end of a joint by which it places this one.
    pub(super) fn bearer(&self, joint: usize, end: PointId) -> Option<PointId> {
        match self.placements[end.link] {
            Placement::Pin { joint: own, at, .. } | Placement::Slider { joint: own, at, .. } => {
                (own == joint).then_some(at)
            }
            Placement::Ground | Placement::Free => None,
        }
    }
}

/// The link that is placed next, by the joint with the fewest coordinates, and of those by the shortest way to the
/// ground.
fn nearest(graph: &Graph, depths: &[Option<usize>]) -> Option<(usize, Placement, usize)> {
    let mut candidates = Vec::new();
    for (joint, Joint { syntax, ends, .. }) in graph.joints.iter().enumerate() {
        if !syntax.kind.is_pin() && !syntax.kind.is_slider() {
            continue;
        }
        let placed = ends.iter().filter_map(|end| Some((depths[end.link]?, *end))).min();
        let own = ends.iter().find(|end| depths[end.link].is_none());
        if let (Some((depth, at)), Some(own)) = (placed, own) {
            candidates.push((syntax.kind.is_slider(), depth, joint, at, *own));
        }
    }
    let (is_slider, depth, joint, at, own) = candidates.into_iter().min()?;
    let placement = if is_slider { Placement::Slider { joint, at, own } } else { Placement::Pin { joint, at, own } };
    Some((own.link, placement, depth + 1))
}
