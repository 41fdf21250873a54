//! The motion of a recorded run, for animations.

use qrm_scene::scene::{LoadKind, Output, OutputKind, Scene};
use qrm_sim::columns::Kind;
use qrm_view::motion::{Arrow, Motion, Plot, PlotCurve, Shape, Track};

use crate::drawing::draw;
use crate::groups::{Group, Member, groups};
use crate::pose::Pose;
use crate::recording::Recording;

/// Something that is to be drawn has no finite place at a time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} has no finite place at t = {t} s, so the motion cannot be drawn")]
pub struct NoPlace {
    /// Its name.
    pub what: String,
    /// The time.
    pub t: f64,
}

/// The motion of a scene whose parameters have these values.
///
/// # Errors
/// Something that is to be drawn has no finite place.
pub fn motion(scene: &Scene, parameters: &[f64], recording: &Recording) -> Result<Motion, NoPlace> {
    let mut pose = Pose::recorded(scene, parameters, recording);
    let shapes = draw(&mut pose);
    untrace_leaps(&mut pose);
    let arrows = reactions(&mut pose, recording).into_iter().chain(loads(&mut pose)).collect();
    let times: Vec<f64> = recording.values(Kind::Time);
    let nodes = pose.nodes.iter().flat_map(|node| [&node.x, &node.y].map(|track| (node.name.as_str(), track)));
    let turns = shapes.iter().filter_map(|shape| match shape {
        Shape::Block { name, angle, .. } => Some((name.as_str(), angle)),
        _ => None,
    });
    for (name, track) in nodes.chain(turns) {
        if let Some(frame) = track.iter().position(|value| !value.is_finite()) {
            let what = if name.is_empty() { "a place in [drawing]".to_owned() } else { format!("`{name}`") };
            let t = times[frame.min(times.len() - 1)];
            return Err(NoPlace { what, t });
        }
    }
    Ok(Motion {
        title: scene.name.clone(),
        doc: scene.doc.clone(),
        times,
        nodes: pose.nodes,
        shapes,
        arrows,
        plots: plots(scene, recording),
    })
}

/// The forces of constraints that the scene asks for.
fn reactions(pose: &mut Pose, recording: &Recording) -> Vec<Arrow> {
    let scene = pose.scene;
    let mut arrows = Vec::new();
    let is_component = |i: usize| {
        let has =
            |own: &Output| matches!(own.kind, OutputKind::Norm { components, at: Some(_) } if components.contains(&i));
        scene.outputs.iter().any(has)
    };
    for (i, output) in scene.outputs.iter().enumerate() {
        let arrow =
            |node, x, y| Arrow { name: output.name.clone(), doc: output.doc.clone(), is_reaction: true, node, x, y };
        if let OutputKind::Norm { components: [x, y], at: Some(point) } = output.kind {
            let [x, y] = [x, y].map(|i| recording.values(Kind::Output(i)));
            arrows.push(arrow(pose.point(point), x, y));
        }
        let OutputKind::ReactionForce { point, along, .. } = &output.kind else { continue };
        if is_component(i) {
            continue;
        }
        let values = recording.values(Kind::Output(i));
        let component = |axis: usize| -> Track {
            let each = pose.states.iter().zip(&values).map(|(state, value)| {
                let [x, y] = [state.value(&along[0]), state.value(&along[1])];
                // The output is force times direction, whatever the direction's length.
                value * [x, y][axis] / (x * x + y * y).max(f64::MIN_POSITIVE)
            });
            each.collect()
        };
        let [x, y] = [component(0), component(1)];
        arrows.push(arrow(pose.point(*point), x, y));
    }
    arrows
}

/// The forces that act on the mechanism.
fn loads(pose: &mut Pose) -> Vec<Arrow> {
    let scene = pose.scene;
    let mut arrows = Vec::new();
    for load in &scene.loads {
        let LoadKind::Force { force, at, .. } = &load.kind else { continue };
        let [x, y] = [pose.track(&force[0]), pose.track(&force[1])];
        let node = pose.place(at);
        arrows.push(Arrow { name: load.name.clone(), doc: String::new(), is_reaction: false, node, x, y });
    }
    arrows
}

fn plots(scene: &Scene, recording: &Recording) -> Vec<Plot> {
    let curve = |member: &Member| PlotCurve { name: member.name.clone(), values: recording.values(member.kind) };
    let plot =
        |group: Group| Plot { curves: group.curves.iter().map(curve).collect(), title: group.title, unit: group.unit };
    groups(scene, recording).into_iter().map(plot).collect()
}

/// A path is drawn through the frames; where a point leaps from one to the next, that would be no path.
fn untrace_leaps(pose: &mut Pose) {
    let span = |tracks: &mut dyn Iterator<Item = f64>| {
        let (low, high) = tracks.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let width = span(&mut pose.nodes.iter().flat_map(|node| node.x.iter().copied()));
    let height = span(&mut pose.nodes.iter().flat_map(|node| node.y.iter().copied()));
    let size = width.max(height);
    for node in pose.nodes.iter_mut().filter(|node| node.is_traced) {
        let leaps = |track: &Track| track.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > LEAP * size).count();
        node.is_traced = leaps(&node.x).max(leaps(&node.y)) * 10 < pose.states.len();
    }
}

/// A way between two frames that is this part of the picture is a leap.
const LEAP: f64 = 0.05;
