//! The columns of a run, grouped for display.

use qrm_scene::scene::Scene;
use qrm_sim::columns::{Column, Kind};

use crate::recording::Recording;

/// The name of the sheet about the trustworthiness of a run; no group has it.
pub const HEALTH: &str = "health";

/// Curves shown in one picture: with one unit and of one kind.
pub struct Group {
    /// The name of the picture's file, without its extension.
    pub file: String,
    /// The title of the picture.
    pub title: String,
    /// The quantity of the ordinate.
    pub quantity: String,
    /// The unit of the ordinate.
    pub unit: String,
    /// The curves of the picture.
    pub curves: Vec<Member>,
}

/// A column in a group.
pub struct Member {
    /// The name of the column.
    pub name: String,
    /// A description of the quantity in the column.
    pub doc: String,
    /// The kind of quantity in the column.
    pub kind: Kind,
}

/// The largest number of curves in one picture; more could not be distinguished.
pub const MAX_CURVES: usize = 6;

/// The rates of the coordinates, each output separately, the components of each force together, and all other reactions
/// together; different units are separated.
pub fn groups<'s>(scene: &'s Scene, recording: &Recording) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    // Groups that accept further curves, by the name of their file.
    let mut joined: Vec<(&str, usize)> = Vec::new();
    let mut add = |file: Option<&'s str>, (title, quantity): (&str, &str), column: &Column, doc: &str| {
        let unit = printed_unit(&column.unit);
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
            Kind::Output(i) => match &scene.outputs[i].kind {
                kind if kind.is_reaction() && (kind.is_moment() || column.unit.ends_with("N m")) => {
                    add(Some("moments"), ("reaction moments", "moment"), column, &column.doc);
                }
                kind if kind.is_reaction() => match vector_of(scene, i) {
                    Some(name) => add(Some(name), (&format!("force {name}"), "force"), column, &column.doc),
                    None => add(Some("reactions"), ("reaction forces", "force"), column, &column.doc),
                },
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

/// The name of the force whose size or component an output is: `NAME`, with `NAME_x` and `NAME_y`.
fn vector_of(scene: &Scene, output: usize) -> Option<&str> {
    let name = scene.outputs[output].name.as_str();
    let name = name.strip_suffix("_x").or_else(|| name.strip_suffix("_y")).unwrap_or(name);
    let is_there = |suffix| scene.outputs.iter().any(|other| other.name.strip_suffix(suffix) == Some(name));
    ["", "_x", "_y"].into_iter().all(is_there).then_some(name)
}

/// The form of a unit in pictures.
pub fn printed_unit(unit: &str) -> String {
    unit.replace("^2", "²").replace("^3", "³")
}

/// A file name that no group has yet, ignoring case, since some file systems do not distinguish it.
fn unused(wish: &str, groups: &[Group]) -> String {
    let is_taken = |name: &str| {
        name.eq_ignore_ascii_case(HEALTH) || groups.iter().any(|group| group.file.eq_ignore_ascii_case(name))
    };
    let numbered = (2..).map(|number| format!("{wish}-{number}"));
    std::iter::once(wish.to_owned()).chain(numbered).find(|name| !is_taken(name)).unwrap_or_default()
}
