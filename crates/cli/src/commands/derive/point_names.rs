//! The names of points of links in an expanded scene.

use std::collections::BTreeMap;

use toml_edit::{Item, TableLike, Value};

/// Replaces `LINK.POINT` by the name of the point in all texts of a section. `at = "POINT"` with `on = "LINK"` is
/// replaced too.
pub(super) fn replace(section: &mut Item, names: &BTreeMap<String, String>) {
    if let Some(entries) = section.as_table_like_mut() {
        replace_in_table(entries, names);
    }
}

fn replace_in_table(table: &mut dyn TableLike, names: &BTreeMap<String, String>) {
    let text = |key: &str| table.get(key).and_then(Item::as_str);
    let both = text("on").zip(text("at")).and_then(|(link, point)| names.get(&format!("{link}.{point}")));
    if let Some(name) = both.cloned() {
        table.insert("at", Item::Value(name.into()));
        table.remove("on");
    }
    for (_, item) in table.iter_mut() {
        match item {
            Item::Value(value) => replace_in_value(value, names),
            item => replace(item, names),
        }
    }
}

fn replace_in_value(value: &mut Value, names: &BTreeMap<String, String>) {
    match value {
        Value::String(text) => {
            if let Some(name) = names.get(text.value()) {
                *value = name.as_str().into();
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| replace_in_value(item, names)),
        Value::InlineTable(table) => replace_in_table(table, names),
        _ => {}
    }
}
