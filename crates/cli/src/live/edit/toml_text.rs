//! Values in the text of a scene.

use toml_edit::{Array, DocumentMut, Item, RawString, TableLike, Value};

/// A value of a scene: its keys, and its place in a list.
pub(super) type Place<'a> = (&'a [&'a str], Option<usize>);

/// The value at a place.
pub(super) fn value_mut<'d>(document: &'d mut DocumentMut, (keys, index): Place) -> Option<&'d mut Value> {
    let mut item = document.as_item_mut();
    for key in keys {
        item = item.as_table_like_mut()?.get_mut(key)?;
    }
    let value = item.as_value_mut()?;
    match index {
        None => Some(value),
        Some(index) => value.as_array_mut()?.get_mut(index),
    }
}

/// Replaces a value; the space around it stays.
pub(super) fn replace(value: &mut Value, mut new: Value) {
    *new.decor_mut() = value.decor().clone();
    *value = new;
}

/// Changes a table. If it stands in one line, the space before its brace stays.
///
/// Returns `None` if the item is no table.
pub(super) fn change_table<T>(item: &mut Item, change: impl FnOnce(&mut dyn TableLike) -> T) -> Option<T> {
    let space = item.as_inline_table().map(|table| {
        let last = table.iter().last().and_then(|(_, value)| value.decor().suffix()?.as_str());
        last.filter(|space| space.chars().all(|c| c == ' ')).unwrap_or(" ").to_owned()
    });
    let changed = change(item.as_table_like_mut()?);
    if let (Some(table), Some(space)) = (item.as_inline_table_mut(), space) {
        let last = table.len().saturating_sub(1);
        for (place, (_, value)) in table.iter_mut().enumerate() {
            let own = value.decor().suffix().and_then(RawString::as_str).unwrap_or_default();
            if own.chars().all(|c| c == ' ') {
                value.decor_mut().set_suffix(if place == last { space.as_str() } else { "" });
            }
        }
    }
    Some(changed)
}

/// A formula as a value.
pub(super) fn formula(text: &str) -> Value {
    format!("'{text}'").parse().unwrap_or_else(|_| text.into())
}

/// A list of texts in one line.
pub(super) fn texts(values: impl IntoIterator<Item = impl Into<String>>) -> Array {
    values.into_iter().map(Into::into).collect()
}
