//! The lengths and angles of links as parameters, so that a moved point needs no derivation.

use std::collections::BTreeMap;

use qrm_scene::unit::Unit;
use toml_edit::{InlineTable, Item, TableLike, Value};

use super::constant_term::constant;
use super::linkage::Linkage;
use super::number::{literal, parameter};
use super::toml_text::{Place, formula, replace, value_mut};

/// The beginning of the names of these parameters. Pages do not list them: `isListed` of `panel.js` has the same text.
const PREFIX: &str = "qrm_";

/// The text of a scene whose lengths and angles of links are parameters; `None` if it has no links.
pub(in crate::live) fn with_length_parameters(text: &str) -> Option<String> {
    let mut linkage = Linkage::parse(text).ok()?;
    let quantities = quantities(&linkage);
    if quantities.is_empty() {
        return None;
    }
    for Quantity { name, keys, index, value, unit, rest } in quantities {
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let place: Place = (&keys, index);
        replace(value_mut(&mut linkage.document, place)?, formula(format!("{name} {rest}").trim_end()));
        let mut parameter = InlineTable::new();
        parameter.insert("value", value.into());
        parameter.insert("unit", unit.into());
        parameter.insert("runtime", true.into());
        linkage.section("parameters").ok()?.insert(&name, Item::Value(parameter.into()));
    }
    Some(linkage.text())
}

/// The values of these parameters, and of those of the scene that are numbers.
pub(in crate::live) fn values(text: &str) -> BTreeMap<String, f64> {
    let Ok(linkage) = Linkage::parse(text) else { return BTreeMap::new() };
    let own = quantities(&linkage).into_iter().map(|quantity| (quantity.name, quantity.value));
    let of_scene = |(name, item): (&str, &Item)| {
        let value = item.as_table_like().map_or(Some(item), |table| table.get("value"))?.as_value()?;
        let number = literal(value)?;
        // Bare numbers have the unit of the parameter.
        let factor = if value.is_str() { parameter(&linkage.document, name)?.1 } else { 1.0 };
        Some((name.to_owned(), number / factor))
    };
    own.chain(linkage.entries("parameters").filter_map(of_scene)).collect()
}

/// A length or an angle that is written as a number.
struct Quantity {
    name: String,
    keys: Vec<String>,
    index: Option<usize>,
    value: f64,
    unit: &'static str,
    /// The formula after the number.
    rest: String,
}

/// The lengths of bars, triangles and rods, the points of links, the constants of drives and cylinders, and the angles
/// and places at the start.
fn quantities(linkage: &Linkage) -> Vec<Quantity> {
    let mut found = Vec::new();
    for (link, item) in linkage.entries("links") {
        for key in ["length", "sides"] {
            found.extend(quantities_in(item.get(key), &["links", link, key]));
        }
        let angle = item.get("angle").and_then(Item::as_value).and_then(literal);
        found.extend(angle.and_then(|angle| quantity(&["links", link, "angle"], None, angle, "rad", "")));
        let points = item.get("points").and_then(Item::as_table_like);
        for (point, item) in points.into_iter().flat_map(TableLike::iter) {
            found.extend(quantities_in(Some(item), &["links", link, "points", point]));
        }
    }
    for (joint, item) in linkage.entries("joints") {
        found.extend(quantities_in(item.get("near"), &["joints", joint, "near"]));
        if item.get("rod").is_some() {
            found.extend(quantities_in(item.get("length"), &["joints", joint, "length"]));
        }
        for (kind, key, unit) in [("revolute", "drive", "rad"), ("cylinder", "length", "m")] {
            let sum = item.get(key).and_then(Item::as_str).filter(|_| item.get(kind).is_some());
            if let Some((number, own, rest)) = sum.and_then(constant) {
                let factor = Unit::parse(own).map_or(1.0, |own| own.factor());
                found.extend(quantity(&["joints", joint, key], None, number * factor, unit, rest));
            }
        }
    }
    found
}

/// The numbers of an item, which may be a list.
fn quantities_in(item: Option<&Item>, keys: &[&str]) -> Vec<Quantity> {
    let Some(value) = item.and_then(Item::as_value) else { return Vec::new() };
    let one = |index: Option<usize>, value: &Value| quantity(keys, index, literal(value)?, "m", "");
    match value.as_array() {
        Some(array) => array.iter().enumerate().filter_map(|(index, value)| one(Some(index), value)).collect(),
        None => one(None, value).into_iter().collect(),
    }
}

fn quantity(keys: &[&str], index: Option<usize>, value: f64, unit: &'static str, rest: &str) -> Option<Quantity> {
    let mut name = format!("{PREFIX}{}", keys.join("_"));
    if let Some(index) = index {
        name += &format!("_{index}");
    }
    let keys = keys.iter().map(|key| (*key).to_owned()).collect();
    value.is_finite().then(|| Quantity { name, keys, index, value, unit, rest: rest.to_owned() })
}
