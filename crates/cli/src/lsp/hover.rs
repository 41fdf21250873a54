//! Hover: the description of the word at a position.

use serde_json::{Value, json};

use super::declaration::{declarations, stem};
use super::place::Within;
use super::text::Text;
use super::values::Values;
use crate::keys::{Key, section};

/// The description of the word at a byte: a key of the reference, or a name with its declaration and its value at the
/// start.
pub(super) fn hover(text: &Text, values: &Values, byte: usize) -> Option<Value> {
    let word = text.word(byte);
    let name = text.source.get(word.clone()).filter(|name| !name.is_empty())?;
    let place = text.place(word.start);
    let found = match place.within {
        Within::Comment => None,
        Within::Header => section(name).map(|section| section.doc.clone()),
        Within::LineKey | Within::InlineKey if key(place.section, name).is_some() && !is_declared(text, word.start) => {
            key(place.section, name)
        }
        _ => described(text, values, name),
    };
    let found = found.filter(|text| !text.is_empty())?;
    Some(json!({ "contents": { "kind": "markdown", "value": found }, "range": text.range(&word) }))
}

fn is_declared(text: &Text, byte: usize) -> bool {
    declarations(&text.source).iter().any(|declaration| declaration.span.contains(&byte))
}

fn key(section_name: &str, name: &str) -> Option<String> {
    let keys = &section(section_name)?.keys;
    let texts: Vec<String> = keys.iter().filter(|key| key.name == name).map(Key::text).collect();
    (!texts.is_empty()).then(|| texts.join("\n\n---\n\n"))
}

/// The declaration of a name, and its values.
fn described(text: &Text, values: &Values, name: &str) -> Option<String> {
    let declarations = declarations(&text.source);
    let stem = stem(name, &declarations)?;
    let mut found = Vec::new();
    for declaration in declarations.iter().filter(|declaration| declaration.name == stem) {
        let line = &text.source[text.line_begin(declaration.span.start)..];
        let line = line.lines().next().unwrap_or_default().trim();
        found.push(format!("{} `{stem}`\n\n```toml\n{line}\n```", declaration.kind.word()));
    }
    let numbers = values.describe(name, stem);
    if !numbers.is_empty() {
        found.push(format!("at the start: {}", numbers.join(", ")));
    }
    Some(found.join("\n\n"))
}
