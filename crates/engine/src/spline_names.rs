//! Names of splines and of their derivatives in the engine.

use std::sync::Arc;

use qrm_scene::expression::Node;
use qrm_scene::resolve::all_values;
use qrm_scene::scene::Scene;
use qrm_scene::spline::Spline;

/// The order of the last nonzero derivative.
pub(super) const ORDERS: usize = 3;

/// The name of the derivative of a spline.
pub(super) fn spline_name(place: usize, order: usize) -> String {
    format!("spline{place}d{order}")
}

/// The index of the spline and the order of the derivative with this name.
pub(super) fn parse_name(name: &str) -> Option<(usize, usize)> {
    let (place, order) = name.strip_prefix("spline")?.split_once('d')?;
    Some((place.parse().ok()?, order.parse().ok()?))
}

/// The splines of a scene, without duplicates.
pub(super) fn splines_of(scene: &Scene) -> Vec<Arc<Spline>> {
    let mut splines: Vec<Arc<Spline>> = Vec::new();
    for node in all_values(scene).into_iter().flat_map(|value| value.nodes()) {
        if let Node::Spline(spline, _) = node
            && !splines.contains(spline)
        {
            splines.push(Arc::clone(spline));
        }
    }
    splines
}
