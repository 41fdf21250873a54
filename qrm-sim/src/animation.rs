//! A recorded run as what an animation shows.

use qrm_scene::scene::{LoadKind, OutputKind, Scene};
use qrm_view::motion::{Arrow, Motion, Plot, PlotCurve, Shape, Track};

use crate::album::Album;
use crate::drawing::draw;
use crate::figures::groups;
use crate::stage::Stage;

/// The motion of a scene whose parameters have these values.
///
/// # Errors
/// Something that is to be drawn has no finite place.
pub(crate) fn motion(scene: &Scene, parameters: &[f64], album: &Album) -> Result<Motion, String> {
    let mut stage = Stage::new(scene, parameters, &album.frames);
    let shapes = draw(&mut stage);
    untrace_leaps(&mut stage);
    let arrows = reactions(&mut stage, album).into_iter().chain(loads(&mut stage)).collect();
    let times: Vec<f64> = album.frames.iter().map(|frame| frame[0]).collect();
    let nodes = stage.nodes.iter().flat_map(|node| [&node.x, &node.y].map(|track| (node.name.as_str(), track)));
    let turns = shapes.iter().filter_map(|shape| match shape {
        Shape::Block { name, angle, .. } => Some((name.as_str(), angle)),
        _ => None,
    });
    for (name, track) in nodes.chain(turns) {
        if let Some(frame) = track.iter().position(|value| !value.is_finite()) {
            let what = if name.is_empty() { "a place in [drawing]".to_owned() } else { format!("`{name}`") };
            return Err(format!(
                "{what} has no finite place at t = {} s, so the motion cannot be drawn\n  \
                 = help: look for divisions by zero, roots and logarithms in its formula",
                times[frame.min(times.len() - 1)]
            ));
        }
    }
    Ok(Motion {
        title: scene.name.clone(),
        doc: scene.doc.clone(),
        times,
        nodes: stage.nodes,
        shapes,
        arrows,
        plots: plots(scene, album),
    })
}

/// The forces of constraints that the scene asks for.
fn reactions(stage: &mut Stage, album: &Album) -> Vec<Arrow> {
    let scene = stage.scene;
    let mut arrows = Vec::new();
    for output in &scene.outputs {
        let OutputKind::ReactionForce { point, along, .. } = &output.kind else { continue };
        let Some(column) = album.place(&output.name) else { continue };
        let component = |axis: usize| -> Track {
            let each = stage.states.iter().zip(&album.frames).map(|(state, frame)| {
                let [x, y] = [state.value(&along[0]), state.value(&along[1])];
                // The output is force times direction, whatever the direction's length.
                frame[column] * [x, y][axis] / (x * x + y * y).max(f64::MIN_POSITIVE)
            });
            each.collect()
        };
        let [x, y] = [component(0), component(1)];
        let node = stage.point(*point);
        arrows.push(Arrow { name: output.name.clone(), doc: output.doc.clone(), is_reaction: true, node, x, y });
    }
    arrows
}

/// The forces that act on the mechanism.
fn loads(stage: &mut Stage) -> Vec<Arrow> {
    let scene = stage.scene;
    let mut arrows = Vec::new();
    for load in &scene.loads {
        let LoadKind::Force { force, at } = &load.kind else { continue };
        let [x, y] = [stage.track(&force[0]), stage.track(&force[1])];
        let node = stage.place(at);
        arrows.push(Arrow { name: load.name.clone(), doc: String::new(), is_reaction: false, node, x, y });
    }
    arrows
}

fn plots(scene: &Scene, album: &Album) -> Vec<Plot> {
    let curve = |name: &String| {
        let column = album.place(name)?;
        Some(PlotCurve { name: name.clone(), values: album.frames.iter().map(|frame| frame[column]).collect() })
    };
    let plot = |group: crate::figures::Group| Plot {
        curves: group.curves.iter().filter_map(|(name, _)| curve(name)).collect(),
        title: group.title,
        unit: group.unit,
    };
    groups(scene).into_iter().map(plot).collect()
}

/// A path is drawn through the frames; where a point leaps from one to the next, that would be no path.
fn untrace_leaps(stage: &mut Stage) {
    let span = |tracks: &mut dyn Iterator<Item = f64>| {
        let (low, high) = tracks.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let width = span(&mut stage.nodes.iter().flat_map(|node| node.x.iter().copied()));
    let height = span(&mut stage.nodes.iter().flat_map(|node| node.y.iter().copied()));
    let size = width.max(height);
    for node in stage.nodes.iter_mut().filter(|node| node.is_traced) {
        let leaps = |track: &Track| track.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > LEAP * size).count();
        node.is_traced = leaps(&node.x).max(leaps(&node.y)) * 10 < stage.states.len();
    }
}

/// A way between two frames that is this part of the picture is a leap.
const LEAP: f64 = 0.05;
