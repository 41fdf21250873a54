//! The figures of a run, chosen from the coordinates and outputs of its scene.

use qrm_pictures::{Group, HEALTH, Member, Recording, groups};
use qrm_scene::scene::{OutputKind, Scene};
use qrm_sim::columns::Kind;
use qrm_sim::run::Outcome;
use qrm_view::figure::{Abscissa, Curve, Extremes, Figure, Panel, Scale};

use crate::format;
use crate::setup::Setup;

/// The figures of a run, with file names without extensions.
pub(crate) fn figures(setup: &Setup, outcome: &Outcome, recording: &Recording) -> Vec<(String, Figure)> {
    let groups = groups(&setup.scene, recording).into_iter();
    let mut figures: Vec<(String, Figure)> =
        groups.map(|group| (group.file.clone(), figure(&group, recording))).collect();
    figures.extend(polar_diagrams(&setup.scene, recording));
    let title = format!(
        "health of the run: {}, closure tolerance {:e}",
        format::method(setup.settings.method.name, setup.settings.tolerance(), outcome.step),
        setup.settings.projection_tolerance.residual
    );
    let is_conservative = outcome.energy_drift.is_some();
    figures.push((HEALTH.to_owned(), health(&setup.scene, recording, title, is_conservative)));
    figures
}

/// Draws the figure of a group.
fn figure(group: &Group, recording: &Recording) -> Figure {
    let curve = |member: &Member| Curve {
        name: member.name.clone(),
        doc: member.doc.clone(),
        points: recording.series(member.kind),
        extremes: extremes(recording, member.kind),
        has_dots: false,
    };
    let panel = Panel {
        quantity: group.quantity.clone(),
        unit: group.unit.clone(),
        scale: Scale::Linear,
        curves: group.curves.iter().map(curve).collect(),
        floor: None,
    };
    Figure { title: group.title.clone(), abscissa: Abscissa::time(), panels: vec![panel] }
}

/// The extremes of a column over time; `None` for checks, and where the column is unbounded.
pub(crate) fn extremes(recording: &Recording, kind: Kind) -> Option<Extremes> {
    let swapped = |(value, t)| (t, value);
    let bounded = recording.extremes(kind).filter(|e| e.minimum.0.is_finite() && e.maximum.0.is_finite());
    bounded.map(|e| Extremes { minimum: swapped(e.minimum), maximum: swapped(e.maximum) })
}

/// Draws the tip of each force with two components.
fn polar_diagrams(scene: &Scene, recording: &Recording) -> Vec<(String, Figure)> {
    let mut diagrams = Vec::new();
    for output in &scene.outputs {
        let OutputKind::Norm { components: [x, y], .. } = output.kind else { continue };
        let [x, y] = [x, y].map(|i| (&scene.outputs[i], recording.values(Kind::Output(i))));
        let points = x.1.into_iter().zip(y.1).collect();
        let curve =
            Curve { name: output.name.clone(), doc: output.doc.clone(), points, extremes: None, has_dots: false };
        let panel = Panel {
            quantity: y.0.name.clone(),
            unit: y.0.unit.clone(),
            scale: Scale::Linear,
            curves: vec![curve],
            floor: None,
        };
        let (quantity, unit) = (x.0.name.clone(), x.0.unit.clone());
        let abscissa = Abscissa { quantity, unit, scale: Scale::Linear, is_isometric: true, has_origin: true };
        let doc = if output.doc.is_empty() { String::new() } else { format!(": {}", output.doc) };
        let title = format!("polar diagram of {}{doc}", output.name);
        diagrams.push((format!("{}-polar", output.name), Figure { title, abscissa, panels: vec![panel] }));
    }
    diagrams
}

/// Draws residuals, energy and corrections over time.
fn health(scene: &Scene, recording: &Recording, title: String, is_conservative: bool) -> Figure {
    let panel = |quantity: &str, unit: &str, scale, name: &str, points| Panel {
        quantity: quantity.to_owned(),
        unit: unit.to_owned(),
        scale,
        curves: vec![Curve { name: name.to_owned(), doc: String::new(), points, extremes: None, has_dots: false }],
        floor: None,
    };
    let mut panels = Vec::new();
    if let Some(first) = scene.constraints.first() {
        let is_same = scene.constraints.iter().all(|c| c.unit == first.unit);
        let unit = if is_same { first.unit.as_str() } else { "" };
        let rate = format!("{}/s", if unit.is_empty() { "1" } else { unit });
        let [position, velocity] = [Kind::Residual, Kind::ResidualRate].map(|kind| recording.series(kind));
        panels.push(panel("residual", unit, Scale::Logarithmic, "residual_position", position));
        panels.push(panel("its rate", &rate, Scale::Logarithmic, "residual_velocity", velocity));
    }
    let energy = recording.series(Kind::Energy);
    let first = energy.first().map_or(0.0, |point| point.1);
    panels.push(match is_conservative {
        true => {
            let change = energy.into_iter().map(|(t, e)| (t, e - first)).collect();
            panel("change of energy", "J", Scale::Linear, "energy", change)
        }
        false => panel("energy", "J", Scale::Linear, "energy", energy),
    });
    if !scene.constraints.is_empty() {
        panels.push(panel("corrections", "", Scale::Linear, "corrections", recording.corrections()));
    }
    Figure { title, abscissa: Abscissa::time(), panels }
}
