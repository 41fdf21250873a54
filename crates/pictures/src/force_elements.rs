//! Springs, dampers and actuators of loads.

use qrm_scene::document::ForceElementKind;
use qrm_scene::evaluate::constant;
use qrm_scene::scene::{LoadKind, Quantity, Value};
use qrm_view::motion::{ForceElementPart, Shape};

use crate::pose::Pose;

/// The drawing of a kind of force element.
pub(super) fn part(kind: ForceElementKind) -> ForceElementPart {
    match kind {
        ForceElementKind::Spring => ForceElementPart::Spring,
        ForceElementKind::Damper => ForceElementPart::Damper,
        ForceElementKind::Actuator => ForceElementPart::Actuator,
    }
}

/// Adds all loads that act between two points, unless such an element is already drawn there; adds a bearing at an end
/// on the ground if nothing else is drawn there.
pub(super) fn add_force_elements(pose: &mut Pose, shapes: &mut Vec<Shape>) {
    let scene = pose.scene;
    for load in &scene.loads {
        let Some(ends) = load.kind.between() else { continue };
        let parts = parts(pose, &load.kind);
        let nodes = ends.map(|point| pose.point(point));
        let is_there = |shape: &Shape| match shape {
            Shape::ForceElement { nodes: own, .. } => nodes.iter().all(|node| own.contains(node)),
            _ => false,
        };
        if parts.is_empty() || shapes.iter().any(is_there) {
            continue;
        }
        // A bar between them is removed, since it would look rigid.
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
        shapes.push(Shape::ForceElement { name: load.name.clone(), nodes: nodes.into(), parts });
    }
}

/// The parts that represent a load; a zero coefficient adds none.
fn parts(pose: &Pose, load: &LoadKind) -> Vec<ForceElementPart> {
    let LoadKind::Spring { stiffness, damping, potential, force, friction, .. } = load else { return Vec::new() };
    let acts = |value: &&Value| {
        let is_constant = value.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi));
        !is_constant || constant(value, pose.parameters) != 0.0
    };
    let has = |values: [Option<&Value>; 2]| values.into_iter().flatten().any(|value| acts(&value));
    let spring = has([stiffness.as_ref(), potential.as_ref()]).then_some(ForceElementPart::Spring);
    let damper = has([damping.as_ref(), friction.as_ref().map(|own| &own.size)]).then_some(ForceElementPart::Damper);
    let actuator = has([force.as_ref(), None]).then_some(ForceElementPart::Actuator);
    [spring, damper, actuator].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use qrm_scene::resolve;

    const SCENE: &str = r#"
name = "tied"
coordinates = ["phi"]
[parameters]
none = { value = 0, runtime = true }
[points]
O = [0, 0]
A = ['cos(phi)', 'sin(phi)']
S = [2, 0]
[bodies]
bar = { mass = 1, com = "A" }
[loads]
both = { between = ["A", "S"], spring = 3, rest = 1, damper = 2 }
push = { along = 'sqrt((A.x - O.x)^2 + (O.y - A.y)^2)', force = '5*t' }
beside = { along = 'sqrt((A.x - O.x)^2 + (O.y - S.y)^2)', damper = 1 }
idle = { between = ["O", "S"], damper = 'none' }
turn = { along = 'phi', spring = 3 }
[initial]
given = { phi = 0.5, phi_dot = 1 }
[run]
step = 1
end_time = 2
[drawing]
tie = { link = ["A", "S"] }
"#;

    /// The shapes of a drawing with additional lines.
    fn shapes(more: &str) -> Vec<Shape> {
        let text = format!("{SCENE}{more}");
        let (scene, _) = resolve::read("tied.toml", &text).expect("the scene is right");
        let parameters: Vec<f64> = scene.parameters.iter().map(|parameter| parameter.value).collect();
        let states = [0.0, 1.0].map(|t| (t, vec![0.5 + t], vec![1.0]));
        let mut pose = Pose::new(&scene, &parameters, &states);
        crate::drawing::draw(&mut pose)
    }

    fn names(shapes: &[Shape]) -> Vec<(&str, &[ForceElementPart])> {
        let mut names = Vec::new();
        for shape in shapes {
            if let Shape::ForceElement { name, parts, .. } = shape {
                names.push((name.as_str(), &parts[..]));
            }
        }
        names
    }

    #[test]
    fn loads_between_points_are_drawn_as_what_they_are() {
        use ForceElementPart::{Actuator, Damper, Spring};
        let shapes = shapes("");
        assert_eq!(names(&shapes), [("both", &[Spring, Damper][..]), ("push", &[Actuator])]);
        // The bar in place of the spring is gone, and its end on the ground has a bearing.
        assert!(!shapes.iter().any(|shape| matches!(shape, Shape::Link { .. })), "{shapes:?}");
        assert_eq!(shapes.iter().filter(|shape| matches!(shape, Shape::Pivot { .. })).count(), 2, "{shapes:?}");
    }

    #[test]
    fn what_the_scene_draws_is_not_drawn_again() {
        let shapes = shapes("coil = { spring = [\"S\", \"A\"] }\nO = { pivot = \"O\" }\n");
        assert_eq!(
            names(&shapes),
            [("coil", &[ForceElementPart::Spring][..]), ("push", &[ForceElementPart::Actuator])]
        );
        assert_eq!(shapes.iter().filter(|shape| matches!(shape, Shape::Pivot { .. })).count(), 1, "{shapes:?}");
    }
}
