//! The parts of a picture that a scene defines.

use std::f64::consts::{PI, TAU};

use num_dual::Dual64;
use qrm_scene::evaluate::{State, constant, evaluate};
use qrm_scene::scene::{DrawnKind, Quantity, Value};
use qrm_view::motion::{Shape, Track};

use crate::force_elements::part;
use crate::pose::Pose;

/// Creates the shapes of all parts.
pub(super) fn parts(pose: &mut Pose) -> Vec<Shape> {
    let scene = pose.scene;
    let mut shapes = Vec::new();
    for drawn in &scene.drawing {
        let name = drawn.name.clone();
        let shape = match &drawn.kind {
            DrawnKind::Link(places) => Shape::Link { name, nodes: places.iter().map(|p| pose.place(p)).collect() },
            DrawnKind::Guide(places) => {
                Shape::Guide { nodes: places.iter().map(|p| pose.place(p)).collect(), is_channel: false }
            }
            DrawnKind::Rod(ends) => Shape::Rod { name, nodes: ends.iter().map(|p| pose.place(p)).collect() },
            DrawnKind::ForceElement(kind, ends) => {
                let nodes = ends.iter().map(|p| pose.place(p)).collect();
                Shape::ForceElement { name, nodes, parts: vec![part(*kind)] }
            }
            DrawnKind::Pivot(at) => Shape::Pivot { node: pose.place(at) },
            DrawnKind::Block { at, angle, on } => {
                if let Some(on) = on {
                    shapes.push(rail(pose, at, on, angle.as_ref()));
                }
                let angle = pose.angle(angle.as_ref());
                Shape::Block { name, node: pose.place(at), angle }
            }
            DrawnKind::Gear { at, radius, angle, is_internal } => {
                let is_fixed = pose.is_fixed(at) && angle.as_ref().is_none_or(|angle| pose.never_changes(angle));
                let (radius, is_internal) = (constant(radius, pose.parameters).abs(), *is_internal);
                let (node, angle) = (pose.place(at), pose.angle(angle.as_ref()));
                let name = if is_fixed { String::new() } else { name };
                Shape::Gear { name, node, angle, radius, teeth: 1, phase: 0.0, is_internal }
            }
            DrawnKind::Rack { on, wheel, radius, angle } => rack(pose, name, [on, wheel], radius, angle.as_ref()),
            DrawnKind::Belt { at, radii, is_crossed, angle } => {
                let nodes = at.iter().map(|p| pose.place(p)).collect();
                let radii = [0, 1].map(|pulley| constant(&radii[pulley], pose.parameters).abs());
                Shape::Belt { name, nodes, radii, is_crossed: *is_crossed, angle: pose.angle(angle.as_ref()) }
            }
            DrawnKind::Cam { at, angle, profile, is_flat } => {
                let (node, angle) = (pose.place(at), pose.angle(angle.as_ref()));
                let [x, y] = outline(pose.parameters, profile, *is_flat);
                Shape::Outline { name, node, angle, x, y }
            }
            DrawnKind::Path(point) => {
                let node = pose.point(*point);
                pose.nodes[node].is_traced = true;
                continue;
            }
        };
        shapes.push(shape);
    }
    shapes
}

/// The number of corners of a cam's outline.
const CORNERS: u32 = 180;

/// The corners of a cam. A flat face touches the cam where the face's normal has the same direction, shifted sideways
/// by the derivative of the distance.
fn outline(parameters: &[f64], profile: &Value, is_flat: bool) -> [Track; 2] {
    let corner = |number: u32| {
        let theta = TAU * f64::from(number) / f64::from(CORNERS);
        let radius = evaluate(profile, |quantity| match quantity {
            Quantity::Parameter(i) => Dual64::from(parameters[*i]),
            Quantity::Stretch => Dual64::new(theta, 1.0),
            _ => Dual64::from(PI),
        });
        let (sin, cos) = theta.sin_cos();
        let beside = if is_flat { radius.eps } else { 0.0 };
        (radius.re * cos - beside * sin, radius.re * sin + beside * cos)
    };
    let (x, y) = (0..CORNERS).map(corner).unzip();
    [x, y]
}

/// The line along which something slides, as long as the motion needs.
fn rail(pose: &mut Pose, at: &[Value; 2], on: &[Value; 2], angle: Option<&Value>) -> Shape {
    let [low, high] = way(pose, on, at, angle);
    let reach = (0.15 * (high - low)).max(0.05 * pose.size());
    let is_fixed = pose.is_fixed(on) && angle.is_none_or(|angle| pose.never_changes(angle));
    // A moving line includes its own point.
    let [low, high] = if is_fixed { [low, high] } else { [low.min(0.0), high.max(0.0)] };
    let along = [low - reach, high + reach];
    if let Some(state) = pose.states.first().filter(|_| is_fixed) {
        let ([x, y], (sin, cos)) = (at_state(state, on), angle.map_or(0.0, |angle| state.value(angle)).sin_cos());
        let ends = along.map(|along| [x + along * cos, y + along * sin]);
        return Shape::Guide { nodes: ends.into_iter().map(|end| pose.fixed(end)).collect(), is_channel: true };
    }
    Shape::Rail { node: pose.place(on), angle: pose.angle(angle), along }
}

/// A rack, as long as its gear rolls.
fn rack(pose: &mut Pose, name: String, ends: [&[Value; 2]; 2], radius: &Value, angle: Option<&Value>) -> Shape {
    let [on, wheel] = ends;
    let [low, high] = way(pose, on, wheel, angle);
    let radius = constant(radius, pose.parameters);
    let reach = 1.2 * radius.abs();
    let first = pose.states.first();
    let across = first.map_or(0.0, |state| in_frame(state, on, wheel, angle)[1]) - radius;
    let is_fixed = pose.is_fixed(on) && angle.is_none_or(|angle| pose.never_changes(angle));
    let name = if is_fixed { String::new() } else { name };
    let (node, angle) = (pose.place(on), pose.angle(angle));
    // The teeth of the gear need room beyond that.
    let along = [low - reach, high + reach];
    Shape::Rack { name, node, angle, along, across, pitch: 0.2 * PI * radius, phase: 0.0 }
}

/// The smallest and the largest position of a point along a line.
fn way(pose: &Pose, on: &[Value; 2], at: &[Value; 2], angle: Option<&Value>) -> [f64; 2] {
    let places = pose.states.iter().map(|state| in_frame(state, on, at, angle)[0]);
    let grown = |[low, high]: [f64; 2], place: f64| [low.min(place), high.max(place)];
    let [low, high] = places.fold([f64::INFINITY, f64::NEG_INFINITY], grown);
    if low <= high { [low, high] } else { [0.0; 2] }
}

/// A position in the frame at another position.
fn in_frame(state: &State<f64>, origin: &[Value; 2], at: &[Value; 2], angle: Option<&Value>) -> [f64; 2] {
    let angle = angle.map_or(0.0, |angle| state.value(angle));
    seen_from(at_state(state, origin), angle, at_state(state, at))
}

/// A position in the frame with this origin and angle.
pub(super) fn seen_from([ox, oy]: [f64; 2], angle: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [(x - ox) * cos + (y - oy) * sin, (y - oy) * cos - (x - ox) * sin]
}

fn at_state(state: &State<f64>, place: &[Value; 2]) -> [f64; 2] {
    [state.value(&place[0]), state.value(&place[1])]
}
