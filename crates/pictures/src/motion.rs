//! The motion of a recorded run, for animations.

use qrm_scene::scene::{LoadKind, Output, OutputKind, Scene};
use qrm_sim::columns::Kind;
use qrm_view::motion::{Arrow, Motion, Plot, PlotCurve, Track};

use crate::drawing::draw;
use crate::groups::{Group, Member, groups};
use crate::pose::{Pose, track};
use crate::recording::Recording;
use crate::source::{Source, Sources};

/// A drawn element has no finite position at a time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} has no finite place at t = {t} s, so the motion cannot be drawn")]
pub struct NoPlace {
    /// The name of the element.
    pub what: String,
    /// The time.
    pub t: f64,
}

/// Creates the motion of a scene with these parameter values, and the sources of its numbers.
///
/// # Errors
/// A drawn element has no finite position.
pub fn motion(scene: &Scene, parameters: &[f64], recording: &Recording) -> Result<(Motion, Sources), NoPlace> {
    let mut pose = Pose::recorded(scene, parameters, recording);
    let shapes = draw(&mut pose);
    hide_jumping_paths(&mut pose);
    let mut forces = reactions(&mut pose);
    forces.extend(loads(&mut pose));
    let groups = groups(scene, recording);
    let curves = || groups.iter().flat_map(|group| &group.curves).map(|member| Source::Column(member.kind));
    let of_arrows = forces.iter().flat_map(|force| force.sources.iter().cloned());
    let sources = pose.sources.iter().cloned().chain(of_arrows).chain(pose.angles.iter().cloned()).chain(curves());
    let sources = Sources(sources.collect());
    let arrows = forces.into_iter().map(|force| force.arrow(&pose, recording)).collect();
    let times: Vec<f64> = recording.values(Kind::Time);
    let nodes = pose.nodes.iter().flat_map(|node| [&node.x, &node.y].map(|track| (node.name.as_str(), track)));
    let turns = shapes.iter().filter_map(|shape| Some((shape.name(), shape.angle()?)));
    let unsized_shape = shapes.iter().find(|shape| shape.sizes().iter().any(|size| !size.is_finite()));
    if let (Some(shape), Some(t)) = (unsized_shape, times.first()) {
        return Err(NoPlace { what: named(shape.name()), t: *t });
    }
    for (name, track) in nodes.chain(turns) {
        if let Some(frame) = track.iter().position(|value| !value.is_finite()) {
            let t = times[frame.min(times.len() - 1)];
            return Err(NoPlace { what: named(name), t });
        }
    }
    let motion = Motion {
        title: scene.name.clone(),
        doc: scene.doc.clone(),
        times,
        nodes: pose.nodes,
        shapes,
        arrows,
        plots: plots(groups, recording),
    };
    Ok((motion, sources))
}

fn named(name: &str) -> String {
    if name.is_empty() { "a place in [drawing]".to_owned() } else { format!("`{name}`") }
}

/// An arrow without its numbers.
struct Force {
    name: String,
    doc: String,
    is_reaction: bool,
    node: usize,
    sources: [Source; 2],
}

impl Force {
    fn arrow(self, pose: &Pose, recording: &Recording) -> Arrow {
        let each = |source: &Source| {
            let frames = pose.states.iter().enumerate();
            track(frames.map(|(frame, state)| source.number(state, &|kind| recording.value(frame, kind))).collect())
        };
        let [x, y] = [0, 1].map(|axis| each(&self.sources[axis]));
        let Self { name, doc, is_reaction, node, .. } = self;
        Arrow { name, doc, is_reaction, node, x, y }
    }
}

/// The outputs of the scene that are forces of constraints and joints.
fn reactions(pose: &mut Pose) -> Vec<Force> {
    let scene = pose.scene;
    let mut forces = Vec::new();
    let is_component = |i: usize| {
        let has =
            |own: &Output| matches!(own.kind, OutputKind::Norm { components, at: Some(_) } if components.contains(&i));
        scene.outputs.iter().any(has)
    };
    for (i, output) in scene.outputs.iter().enumerate() {
        let (point, sources) = match &output.kind {
            OutputKind::Norm { components, at: Some(point) } => {
                (*point, components.map(|component| Source::Column(Kind::Output(component))))
            }
            // The output is force times direction, for any length of the direction.
            OutputKind::ReactionForce { point, along, .. } if !is_component(i) => {
                (*point, [0, 1].map(|axis| Source::Along(Kind::Output(i), along.clone(), axis)))
            }
            _ => continue,
        };
        let (name, doc, node) = (output.name.clone(), output.doc.clone(), pose.node_at_same_position(point));
        forces.push(Force { name, doc, is_reaction: true, node, sources });
    }
    forces
}

/// The forces that act on the mechanism.
fn loads(pose: &mut Pose) -> Vec<Force> {
    let scene = pose.scene;
    let mut forces = Vec::new();
    for load in &scene.loads {
        let LoadKind::Force { force, at, .. } = &load.kind else { continue };
        let (name, node) = (load.name.clone(), pose.place(at));
        let sources = force.clone().map(Source::Formula);
        forces.push(Force { name, doc: String::new(), is_reaction: false, node, sources });
    }
    forces
}

fn plots(groups: Vec<Group>, recording: &Recording) -> Vec<Plot> {
    let curve = |member: &Member| PlotCurve { name: member.name.clone(), values: recording.values(member.kind) };
    let plot =
        |group: Group| Plot { curves: group.curves.iter().map(curve).collect(), title: group.title, unit: group.unit };
    groups.into_iter().map(plot).collect()
}

/// Removes paths of points that leap from one frame to the next.
fn hide_jumping_paths(pose: &mut Pose) {
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

/// The distance between two frames, relative to the picture, above which a point leaps.
const LEAP: f64 = 0.05;
