//! A recorded run as what an animation shows.

use qrm_codegen::scene::{LoadKind, OutputKind, Scene};
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
    let arrows = reactions(&mut stage, album).into_iter().chain(loads(&mut stage)).collect();
    let values = stage.nodes.iter().flat_map(|node| node.x.iter().chain(&node.y));
    let turns =
        shapes.iter().flat_map(|shape| if let Shape::Block { angle, .. } = shape { angle.as_slice() } else { &[] });
    if !values.chain(turns).all(|value| value.is_finite()) {
        return Err("a formula of [drawing] or [points] has no finite value at some moment of the motion\n  \
                    = help: look for divisions by zero, roots and logarithms in it"
            .to_owned());
    }
    Ok(Motion {
        title: scene.name.clone(),
        doc: scene.doc.clone(),
        times: album.frames.iter().map(|frame| frame[0]).collect(),
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
