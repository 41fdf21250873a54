//! `qrm schema`

use std::path::PathBuf;

use clap::Args;
use qrm_core::Model;
use serde_json::{Map, Value, json};

use crate::error::Error;
use crate::keys::{Key, SECTIONS, Section, section};
use crate::output::{print, save};

#[derive(Args)]
pub(crate) struct Options {
    /// The file, instead of the terminal
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes a JSON schema of scene files.
pub(crate) fn run(_models: &'static [Model], options: &Options) -> Result<(), Error> {
    let text = format!("{:#}\n", schema());
    match &options.out {
        Some(path) => save(path, text.as_bytes()),
        None => {
            print(text.trim_end());
            Ok(())
        }
    }
}

/// The schema of a scene file.
fn schema() -> Value {
    let mut properties = properties(section("").map_or(&[], |root| &root.keys));
    for section in SECTIONS.iter().filter(|section| !section.name.is_empty()) {
        let mut value = section_schema(section);
        value["description"] = json!(section.doc);
        properties.insert(section.name.to_owned(), value);
    }
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "qrm scene",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "required": ["name", "run"],
        "anyOf": [{ "required": ["links"] }, { "required": ["coordinates", "initial"] }],
    })
}

fn section_schema(section: &Section) -> Value {
    let table = json!({ "type": "object", "properties": properties(&section.keys), "additionalProperties": false });
    let named = |entry: Value| json!({ "type": "object", "additionalProperties": entry });
    match section.name {
        "initial" | "run" => table,
        "coordinates" => json!({ "type": "array", "items": { "anyOf": [{ "type": "string" }, table] } }),
        "extreme" => json!({ "type": "array", "items": table }),
        "points" => named(pair()),
        "parameters" | "outputs" => named(json!({ "anyOf": [formula(), table] })),
        _ => named(table),
    }
}

/// A formula or a number.
fn formula() -> Value {
    json!({ "type": ["number", "string"] })
}

fn pair() -> Value {
    json!({ "type": "array", "items": formula(), "minItems": 2, "maxItems": 2 })
}

/// The schemas of keys by name; several keys of one name may hold what any of them may.
fn properties(keys: &[Key]) -> Map<String, Value> {
    let mut properties = Map::new();
    for key in keys {
        let mut others: Vec<&Key> = keys.iter().filter(|other| other.name == key.name).collect();
        others.dedup_by(|a, b| value(a) == value(b));
        let mut schema = match &others[..] {
            [one] => value(one),
            several => json!({ "anyOf": several.iter().map(|key| value(key)).collect::<Vec<_>>() }),
        };
        let texts: Vec<String> = keys.iter().filter(|other| other.name == key.name).map(Key::text).collect();
        schema["description"] = json!(texts.join("\n\n"));
        properties.insert(key.name.to_owned(), schema);
    }
    properties
}

/// The values of a key, by its type in the reference.
fn value(key: &Key) -> Value {
    let kind = key.kind.as_str();
    let begins = |words: &[&str]| words.iter().any(|word| kind.starts_with(word));
    if kind.starts_with("`true`") {
        json!({ "type": "boolean" })
    } else if kind.starts_with('`') {
        let quoted = kind.split('`').skip(1).step_by(2).map(|value| value.trim_matches('"'));
        json!({ "enum": quoted.collect::<Vec<_>>() })
    } else if kind.contains(", or two ") || begins(&["place"]) || key.name == "friction" || key.name == "coordinates" {
        json!({ "type": ["string", "number", "array", "object"] })
    } else if begins(&["list", "two "]) {
        json!({ "type": "array" })
    } else if begins(&["table"]) {
        json!({ "type": "object" })
    } else if begins(&["text", "name"]) {
        json!({ "type": "string" })
    } else {
        formula()
    }
}

impl Key {
    /// The key in a few lines of Markdown.
    pub(crate) fn text(&self) -> String {
        let Self { name, of, kind, unit, default, meaning, example } = self;
        let of = if of.is_empty() { String::new() } else { format!(" {of}") };
        let unit = if unit == "-" { String::new() } else { format!(", in {unit}") };
        format!("**`{name}`**{of}: {kind}{unit} (default: {default})\n\n{meaning}\n\n{example}")
    }
}
