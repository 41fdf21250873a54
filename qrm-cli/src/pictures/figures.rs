//! The figures of a run, chosen from the coordinates and outputs of its scene.

use qrm_scene::scene::{OutputKind, Scene};
use qrm_sim::columns::{Column, Kind};
use qrm_sim::run::Outcome;
use qrm_view::figure::{Abscissa, Curve, Extremes, Figure, Panel, Scale};

use crate::format;
use crate::recording::Recording;
use crate::setup::Setup;

/// The figures of a run under the names of their files, without extensions.
pub(crate) fn figures(setup: &Setup, outcome: &Outcome, recording: &Recording) -> Vec<(String, Figure)> {
    let groups = groups(&setup.scene, recording).into_iter();
    let mut figures: Vec<(String, Figure)> =
        groups.map(|group| (group.file.clone(), group.figure(recording))).collect();
    let title = format!(
        "health of the run: {}, closure tolerance {:e}",
        format::method(setup.settings.method.name, setup.settings.tolerance(), outcome.step),
        setup.settings.projection_tolerance.residual
    );
    let is_conservative = outcome.energy_drift.is_some();
    figures.push((HEALTH.to_owned(), health(&setup.scene, recording, title, is_conservative)));
    figures
}

/// Curves that belong in one picture: one unit, one kind.
pub(super) struct Group {
    /// The name of the picture's file, without its extension.
    file: String,
    pub(super) title: String,
    /// The quantity of the ordinate.
    quantity: String,
    pub(super) unit: String,
    pub(super) curves: Vec<Member>,
}

/// A column in a group.
pub(super) struct Member {
    pub(super) name: String,
    doc: String,
    pub(super) kind: Kind,
}

/// Most curves in one picture; more could not be told apart.
const MAX_CURVES: usize = 6;

/// The rates of the coordinates, each output by itself, all reactions together; what differs in unit stands apart.
pub(super) fn groups(scene: &Scene, recording: &Recording) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    // Groups that take up further curves, under the name of their file.
    let mut joined: Vec<(&str, usize)> = Vec::new();
    let mut add = |file: Option<&'static str>, (title, quantity): (&str, &str), column: &Column, doc: &str| {
        let unit = column.unit.replace("^2", "²").replace("^3", "³");
        let curve = Member { name: column.name.clone(), doc: doc.to_owned(), kind: column.kind };
        let same = joined.iter().filter(|(other, place)| Some(*other) == file && groups[*place].unit == unit);
        let places: Vec<usize> = same.map(|(_, place)| *place).collect();
        if let Some(place) = places.last().filter(|place| groups[**place].curves.len() < MAX_CURVES) {
            groups[*place].curves.push(curve);
            return;
        }
        joined.extend(file.map(|file| (file, groups.len())));
        let number = if places.is_empty() { String::new() } else { format!(" ({})", places.len() + 1) };
        let file = unused(file.unwrap_or(&column.name), &groups);
        let (title, quantity) = (format!("{title}{number}"), quantity.to_owned());
        groups.push(Group { file, title, quantity, unit, curves: vec![curve] });
    };
    for column in recording.columns() {
        match column.kind {
            Kind::Rate(i) => {
                let coordinate = &scene.coordinates[i];
                let is_angle = coordinate.unit == "rad";
                let titles = if is_angle { ("angular speeds", "angular speed") } else { ("speeds", "speed") };
                add(Some("rates"), titles, column, &coordinate.doc);
            }
            Kind::Output(i) => match scene.outputs[i].kind {
                OutputKind::ReactionForce { .. } => {
                    add(Some("reactions"), ("reaction forces", "force"), column, &column.doc);
                }
                OutputKind::ReactionMoment { .. } => {
                    add(Some("moments"), ("reaction moments", "moment"), column, &column.doc);
                }
                _ if column.doc.is_empty() => add(None, (&column.name, &column.name), column, ""),
                _ => {
                    let title = format!("{}: {}", column.name, column.doc);
                    add(None, (&title, &column.name), column, &column.doc);
                }
            },
            _ => {}
        }
    }
    groups
}

/// A file name that no group has yet, not even in capitals: some file systems do not tell them apart.
fn unused(wish: &str, groups: &[Group]) -> String {
    let is_taken = |name: &str| {
        name.eq_ignore_ascii_case(HEALTH) || groups.iter().any(|group| group.file.eq_ignore_ascii_case(name))
    };
    let numbered = (2..).map(|number| format!("{wish}-{number}"));
    std::iter::once(wish.to_owned()).chain(numbered).find(|name| !is_taken(name)).unwrap_or_default()
}

impl Group {
    /// The picture of the group.
    fn figure(&self, recording: &Recording) -> Figure {
        let curve = |member: &Member| Curve {
            name: member.name.clone(),
            doc: member.doc.clone(),
            points: recording.series(member.kind),
            extremes: recording
                .extremes(member.kind)
                .map(|e| Extremes { minimum: (e.minimum.1, e.minimum.0), maximum: (e.maximum.1, e.maximum.0) }),
            has_dots: false,
        };
        let panel = Panel {
            quantity: self.quantity.clone(),
            unit: self.unit.clone(),
            scale: Scale::Linear,
            curves: self.curves.iter().map(curve).collect(),
            floor: None,
        };
        Figure { title: self.title.clone(), abscissa: Abscissa::time(), panels: vec![panel] }
    }
}

/// The name of the sheet that shows how far a run can be trusted.
const HEALTH: &str = "health";

/// Residuals, energy and corrections over time.
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
