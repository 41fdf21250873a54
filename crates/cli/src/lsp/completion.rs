//! Completion: the keys, names, functions and units that fit at a position.

use qrm_scene::function::Function;
use serde_json::{Value, json};

use super::declaration::{Declaration, Kind, declarations};
use super::place::{Place, Within};
use super::text::Text;
use crate::keys::{SECTIONS, section};

/// Units for the key `unit`.
const UNITS: [&str; 18] = [
    "rad",
    "m",
    "kg",
    "s",
    "N",
    "N m",
    "J",
    "W",
    "rad/s",
    "m/s",
    "rad/s^2",
    "m/s^2",
    "kg m^2",
    "N/m",
    "N s/m",
    "N m/rad",
    "N m s/rad",
    "Pa",
];

/// Kinds of completion items in the protocol.
const FUNCTION: u32 = 3;
const VARIABLE: u32 = 6;
const MODULE: u32 = 9;
const PROPERTY: u32 = 10;
const UNIT: u32 = 11;

/// The items that can stand at a byte.
pub(super) fn completion(text: &Text, byte: usize) -> Vec<Value> {
    let place = text.place(byte);
    match place.within {
        Within::Comment | Within::Value => Vec::new(),
        Within::Header => {
            let names = SECTIONS.iter().filter(|section| !["", "coordinates"].contains(&section.name));
            names.map(|section| item(section.name, MODULE, &section.doc)).collect()
        }
        Within::LineKey | Within::InlineKey => keys(&place),
        Within::Name if place.key == "unit" => UNITS.iter().map(|unit| item(unit, UNIT, "")).collect(),
        Within::Name if place.key == "doc" => Vec::new(),
        Within::Name => names(&declarations(&text.source), place.section),
        Within::Formula => formula(&declarations(&text.source)),
    }
}

fn item(label: &str, kind: u32, doc: &str) -> Value {
    json!({ "label": label, "kind": kind, "documentation": { "kind": "markdown", "value": doc } })
}

/// Adds an item, unless there is one with its label.
fn push_new(items: &mut Vec<Value>, item: Value) {
    if items.iter().all(|known| known["label"] != item["label"]) {
        items.push(item);
    }
}

/// The keys of a section that are not yet there.
fn keys(place: &Place) -> Vec<Value> {
    let is_plain = ["", "run", "initial"].contains(&place.section);
    if place.within == Within::LineKey && !is_plain {
        return Vec::new();
    }
    let Some(section) = section(place.section) else { return Vec::new() };
    let mut items: Vec<Value> = Vec::new();
    for key in section.keys.iter().filter(|key| !place.keys.contains(&key.name)) {
        let mut item = item(key.name, PROPERTY, &key.text());
        item["insertText"] = json!(format!("{} = ", key.name));
        push_new(&mut items, item);
    }
    items
}

/// Names in double quotes: links and points in `[links]` and `[joints]`, and what a key can refer to elsewhere.
fn names(declarations: &[Declaration], section: &str) -> Vec<Value> {
    let kinds: &[Kind] = match section {
        "links" => &[Kind::Point],
        "joints" => &[Kind::Link, Kind::Point],
        "bodies" | "drawing" => &[Kind::Point, Kind::Body],
        _ => &[Kind::Point, Kind::Link, Kind::Body, Kind::Joint, Kind::Constraint, Kind::Load, Kind::Output],
    };
    listed(declarations, kinds)
}

/// Names and functions in formulae.
fn formula(declarations: &[Declaration]) -> Vec<Value> {
    let mut items = listed(declarations, &[Kind::Parameter, Kind::Coordinate, Kind::Table]);
    for Declaration { name, kind, .. } in declarations {
        let others: &[String] = match kind {
            Kind::Coordinate => &[format!("{name}_dot")],
            Kind::Link if name != "ground" => &[format!("phi_{name}"), format!("phi_{name}_dot")],
            Kind::Point => &[format!("{name}.x"), format!("{name}.y")],
            _ => &[],
        };
        for other in others {
            push_new(&mut items, item(other, VARIABLE, ""));
        }
    }
    items.extend(Function::ALL.iter().map(|function| item(function.name(), FUNCTION, "")));
    items.extend([item("pi", VARIABLE, ""), item("t", VARIABLE, "time, in s")]);
    items
}

fn listed(declarations: &[Declaration], kinds: &[Kind]) -> Vec<Value> {
    let mut items: Vec<Value> = Vec::new();
    for Declaration { name, kind, .. } in declarations.iter().filter(|declaration| kinds.contains(&declaration.kind)) {
        push_new(&mut items, item(name, VARIABLE, kind.word()));
    }
    items
}
