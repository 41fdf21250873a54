//! The spanning tree: each link's position follows from that of another link.

use super::graph::{Graph, Joint, PointId};

/// The way in which the position of a link is determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placement {
    /// The link is the ground.
    Ground,
    /// One of its points coincides with a point of an earlier link.
    Pin {
        /// The joint.
        joint: usize,
        /// The point of the earlier link.
        at: PointId,
        /// The point of the link that the pin places.
        own: PointId,
    },
    /// One of its points lies at a distance from a point of an earlier link; the distance is a coordinate.
    Slider {
        /// The joint.
        joint: usize,
        /// The point of the earlier link.
        at: PointId,
        /// The point of the link that the slider places.
        own: PointId,
    },
    /// No joint places it: its origin has two coordinates.
    Free,
}

/// The spanning tree with the fewest coordinates: it uses sliders only where there is no pin.
pub(super) struct Tree {
    /// The placement of each link, by its number.
    pub(super) placements: Vec<Placement>,
    /// The links, each after the link that places it.
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

    /// A link and all links placed by it, directly or not.
    pub(super) fn placed_through(&self, link: usize) -> Vec<usize> {
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

    /// Whether a joint places this end by another of its ends.
    pub(super) fn places(&self, joint: usize, end: PointId) -> bool {
        self.placing_end(joint, end).is_some()
    }

    /// The end of a joint by which the joint places this end.
    pub(super) fn placing_end(&self, joint: usize, end: PointId) -> Option<PointId> {
        match self.placements[end.link] {
            Placement::Pin { joint: own, at, .. } | Placement::Slider { joint: own, at, .. } => {
                (own == joint).then_some(at)
            }
            Placement::Ground | Placement::Free => None,
        }
    }
}

/// Chooses the link that is placed next: the joint with the fewest coordinates, then the shortest path to the ground.
fn nearest(graph: &Graph, depths: &[Option<usize>]) -> Option<(usize, Placement, usize)> {
    let mut candidates = Vec::new();
    for (joint, Joint { syntax, ends, .. }) in graph.joints.iter().enumerate() {
        // A joint that may let go is a constraint.
        if !(syntax.kind.is_pin() || syntax.kind.is_slider()) || syntax.one_sided.is_some() {
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
