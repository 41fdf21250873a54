//! Springs, dampers and actuators of loads.

use qrm_scene::document::StrutKind;
use qrm_scene::evaluate::constant;
use qrm_scene::scene::{LoadKind, Quantity, Value};
use qrm_view::motion::{Shape, StrutPart};

use crate::pose::Pose;

/// What a strut is drawn as.
pub(super) fn part(kind: StrutKind) -> StrutPart {
    match kind {
        StrutKind::Spring => StrutPart::Spring,
        StrutKind::Damper => StrutPart::Damper,
        StrutKind::Actuator => StrutPart::Actuator,
    }
}

/// Adds all loads that act between two points, unless something of the kind is drawn there; where nothing else is drawn
/// at an end on the ground, a bearing holds it.
pub(super) fn add_struts(pose: &mut Pose, shapes: &mut Vec<Shape>) {
    let scene = pose.scene;
    for load in &scene.loads {
        let Some(ends) = load.kind.between() else { continue };
        let parts = parts(pose, &load.kind);
        let nodes = ends.map(|point| pose.point(point));
        let is_there = |shape: &Shape| match shape {
            Shape::Strut { nodes: own, .. } => nodes.iter().all(|node| own.contains(node)),
            _ => false,
        };
        if parts.is_empty() || shapes.iter().any(is_there) {
            continue;
        }
        // A bar between them stands for the load: it would not be rigid.
        let is_bar = |shape: &Shape| match shape {
            Shape::Link { nodes: own, .. } => own.len() == 2 && nodes.iter().all(|node| own.contains(node)),
            _ => false,
        };
        shapes.retain(|shape| !is_bar(shape));
        for (point, node) in ends.into_iter().zip(nodes) {
            let is_fixed = pose.is_fixed(&scene.points[point].position);
            if is_fixed && !shapes.iter().any(|shape| shape.nodes().contains(&node)) {
                shapes.push(Shape::Pivot { node });
            }
        }
        shapes.push(Shape::Strut { name: load.name.clone(), nodes: nodes.into(), parts });
    }
}

/// What a load is made of; a coefficient that is zero makes nothing.
fn parts(pose: &Pose, load: &LoadKind) -> Vec<StrutPart> {
    let LoadKind::Spring { stiffness, damping, potential, force, friction, .. } = load else { return Vec::new() };
    let acts = |value: &&Value| {
        let is_constant = value.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi));
        !is_constant || constant(value, pose.parameters) != 0.0
    };
    let has = |values: [Option<&Value>; 2]| values.into_iter().flatten().any(|value| acts(&value));
    let spring = has([stiffness.as_ref(), potential.as_ref()]).then_some(StrutPart::Spring);
    let damper = has([damping.as_ref(), friction.as_ref().map(|(size, _)| size)]).then_some(StrutPart::Damper);
    let actuator = has([force.as_ref(), None]).then_some(StrutPart::Actuator);
    [spring, damper, actuator].into_iter().flatten().collect()
}
