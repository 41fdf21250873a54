//! Which pictures a scene gets, from its coordinates and outputs alone.

use qrm_scene::scene::{OutputKind, Scene};
use qrm_view::figure::{Abscissa, Curve, Extremes, Figure, Panel, Scale};

use crate::album::Album;

/// Curves that belong in one picture: one unit, one kind.
pub(crate) struct Group {
    /// The name of the picture's file, without its extension.
    pub(crate) file: String,
    pub(crate) title: String,
    /// What the ordinate shows.
    quantity: String,
    pub(crate) unit: String,
    /// Names of columns, and what they are.
    pub(crate) curves: Vec<(String, String)>,
}

/// More curves than this are told apart badly.
const MOST_CURVES: usize = 6;

/// The rates of the coordinates, each output by itself, all reactions together; what differs in unit stands apart.
pub(crate) fn groups(scene: &Scene) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    // What joins others does so under the name of their file.
    let mut joined: Vec<(&str, usize)> = Vec::new();
    let mut add = |kind: Option<&'static str>, name: &str, (title, quantity): (&str, &str), unit: &str, doc: &str| {
        let unit = unit.replace("^2", "²").replace("^3", "³");
        let curve = (name.to_owned(), doc.to_owned());
        let same = joined.iter().filter(|(other, place)| Some(*other) == kind && groups[*place].unit == unit);
        let places: Vec<usize> = same.map(|(_, place)| *place).collect();
        if let Some(place) = places.last().filter(|place| groups[**place].curves.len() < MOST_CURVES) {
            groups[*place].curves.push(curve);
            return;
        }
        joined.extend(kind.map(|kind| (kind, groups.len())));
        let number = if places.is_empty() { String::new() } else { format!(" ({})", places.len() + 1) };
        let file = unused(kind.unwrap_or(name), &groups);
        let (title, quantity) = (format!("{title}{number}"), quantity.to_owned());
        groups.push(Group { file, title, quantity, unit, curves: vec![curve] });
    };
    for coordinate in &scene.coordinates {
        let titles = match coordinate.unit.as_str() {
            "rad" => ("angular speeds", "angular speed"),
            _ => ("speeds", "speed"),
        };
        let unit = format!("{}/s", coordinate.unit);
        add(Some("rates"), &format!("{}_dot", coordinate.name), titles, &unit, &coordinate.doc);
    }
    for output in &scene.outputs {
        let (name, doc, unit) = (&output.name, &output.doc, &output.unit);
        match output.kind {
            OutputKind::ReactionForce { .. } => {
                add(Some("reactions"), name, ("reaction forces", "force"), unit, doc);
            }
            OutputKind::ReactionMoment { .. } => {
                add(Some("moments"), name, ("reaction moments", "moment"), unit, doc);
            }
            _ => {
                let title = if doc.is_empty() { name.clone() } else { format!("{name}: {doc}") };
                add(None, name, (&title, name), unit, doc);
            }
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

/// The picture of a group.
pub(crate) fn figure(group: &Group, album: &Album) -> Figure {
    let curve = |(name, doc): &(String, String)| Curve {
        name: name.clone(),
        doc: doc.clone(),
        points: album.course(name),
        extremes: album
            .extremes(name)
            .map(|e| Extremes { minimum: (e.minimum.1, e.minimum.0), maximum: (e.maximum.1, e.maximum.0) }),
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

/// The name of the sheet that shows how far a run can be trusted.
pub(crate) const HEALTH: &str = "health";

/// Residuals, energy and corrections over time.
pub(crate) fn health(scene: &Scene, album: &Album, title: String, is_conservative: bool) -> Figure {
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
        let [position, velocity] = ["residual_position", "residual_velocity"].map(|name| album.course(name));
        panels.push(panel("residual", unit, Scale::Logarithmic, "residual_position", position));
        panels.push(panel("its rate", &rate, Scale::Logarithmic, "residual_velocity", velocity));
    }
    let energy = album.course("energy");
    let first = energy.first().map_or(0.0, |point| point.1);
    panels.push(match is_conservative {
        true => {
            let change = energy.into_iter().map(|(t, e)| (t, e - first)).collect();
            panel("change of energy", "J", Scale::Linear, "energy", change)
        }
        false => panel("energy", "J", Scale::Linear, "energy", energy),
    });
    if !scene.constraints.is_empty() {
        panels.push(panel("corrections", "", Scale::Linear, "corrections", album.corrections()));
    }
    Figure { title, abscissa: Abscissa::time(), panels }
}
