//! TOML tables: missing keys and unknown keys are reported with their locations.

use std::cell::RefCell;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::form;
use super::identifier::{Identifier, Target};
use super::reader::{Reader, Value};
use crate::diagnostic::{Diagnostic, Span};
use crate::names::{closest, suggestion};
use crate::unit::{Unit, unknown_unit};

type Key<'s> = Spanned<DeString<'s>>;

/// The name of the top-level table in messages.
const SCENE: &str = "the scene";

/// A parsed file.
pub(super) struct Root<'s>(Spanned<DeTable<'s>>);

/// Parses the TOML of a file.
pub(super) fn parse<'s>(source: &'s str, findings: &mut Vec<Diagnostic>) -> Root<'s> {
    let (table, errors) = DeTable::parse_recoverable(source);
    findings.extend(form::findings(source, &errors));
    Root(table)
}

impl<'s> Root<'s> {
    pub(super) fn table(&self) -> Table<'_, 's> {
        Table::new(SCENE.to_owned(), self.0.get_ref(), self.0.span())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.get_ref().is_empty()
    }
}

/// A table that tracks which of its keys were read.
pub(super) struct Table<'t, 's> {
    what: String,
    entries: &'t DeTable<'s>,
    span: Span,
    known: RefCell<Vec<String>>,
}

impl<'t, 's> Table<'t, 's> {
    fn new(what: String, entries: &'t DeTable<'s>, span: Span) -> Self {
        Self { what, entries, span, known: RefCell::new(Vec::new()) }
    }

    pub(super) fn optional(&self, key: &str) -> Option<Value<'t, 's>> {
        if !self.known.borrow().iter().any(|known| known == key) {
            self.known.borrow_mut().push(key.to_owned());
        }
        self.get(key)
    }

    /// Whether the key exists. Does not count as reading it.
    pub(super) fn is_there(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    fn get(&self, key: &str) -> Option<Value<'t, 's>> {
        self.entries.iter().find(|(k, _)| k.get_ref() == key).map(|(_, value)| Value(value))
    }

    pub(super) fn required(&self, r: &mut Reader, key: &str) -> Option<Value<'t, 's>> {
        let value = self.optional(key);
        // A mistyped key is reported as unknown instead, which is more specific.
        if value.is_none() && self.mistyped(&[key]).is_none() {
            let shown = if matches!(key, "initial" | "run") { format!("[{key}]") } else { format!("`{key}`") };
            let title = format!("{} has no {shown}", self.what);
            let error = if self.what == SCENE {
                Diagnostic::whole_file(title)
            } else {
                Diagnostic::error(title, self.span.clone(), format!("{shown} is missing"))
            };
            r.findings.push(error.help(format!("add {}", example(key))));
        }
        value
    }

    /// An unknown key that looks like one of `keys`.
    fn mistyped<'k>(&self, keys: &[&'k str]) -> Option<(&'t Key<'s>, &'k str)> {
        let mut others = self.entries.keys().filter(|key| !keys.contains(&key.get_ref().as_ref()));
        others.find_map(|key| Some((key, closest(key.get_ref(), keys.iter().copied())?)))
    }

    /// The text of a key; empty if it is missing. Line breaks in a unit are reported.
    pub(super) fn string(&self, r: &mut Reader, key: &str) -> String {
        if let ("unit", Some(value)) = (key, self.get(key))
            && let DeValue::String(text) = value.0.get_ref()
        {
            r.check_characters(value, text, |c| !matches!(c, '\n' | '\r' | '\t'));
        }
        self.optional(key).and_then(|v| r.text(v)).map(|text| text.name).unwrap_or_default()
    }

    /// The text of the key `unit`, and the unit; none if the key is missing, or the unit is not known and reported.
    pub(super) fn unit(&self, r: &mut Reader) -> (String, Option<Unit>) {
        let text = self.string(r, "unit");
        let unit = if text.is_empty() { None } else { Unit::parse(&text).filter(|unit| !unit.is_ambiguous()) };
        if let (false, None, Some(value)) = (text.is_empty(), &unit, self.get("unit")) {
            r.findings.push(unknown_unit(&text, value.span()));
        }
        (text, unit)
    }

    /// The entries of a subtable in the order of the file; none if the key is missing.
    pub(super) fn entries(&self, r: &mut Reader, key: &str) -> Vec<(Identifier, Value<'t, 's>)> {
        let Some(value) = self.optional(key) else { return Vec::new() };
        let Some(table) = r.table(&format!("[{key}]"), value) else { return Vec::new() };
        let entries = table.all();
        let what = if key == "bodies" { "body" } else { key.trim_end_matches('s') };
        for (identifier, _) in &entries {
            r.check_name(identifier, what);
        }
        entries
    }

    pub(super) fn all(&self) -> Vec<(Identifier, Value<'t, 's>)> {
        let identifier = |key: &Key| Identifier { name: key.get_ref().to_string(), span: key.span() };
        self.entries.iter().map(|(key, value)| (identifier(key), Value(value))).collect()
    }

    /// The single one of these keys that is present; `help` goes into the error message.
    pub(super) fn one_of(&self, r: &mut Reader, keys: &[&'static str], help: &str) -> Option<&'static str> {
        let present: Vec<&'static str> = keys.iter().copied().filter(|key| self.get(key).is_some()).collect();
        if let [key] = present[..] {
            return Some(key);
        }
        for key in &present {
            self.optional(key);
        }
        r.findings.push(match self.mistyped(keys) {
            Some((key, near)) if present.is_empty() => self.unknown(key).help(format!("did you mean `{near}`?")),
            _ => {
                let listed = |keys: &[&str], and: &str| format!("`{}`", keys.join(&format!("`{and}`")));
                let said = if present.is_empty() {
                    "none is given".to_owned()
                } else {
                    listed(&present, " and ") + " are given"
                };
                let title = format!("{} needs exactly one of {}", self.what, listed(keys, ", "));
                Diagnostic::error(title, self.span.clone(), said).help(help)
            }
        });
        None
    }

    /// Reads `at = "point"` or `on = "body"`; both name a point of a link.
    pub(super) fn target(&self, r: &mut Reader) -> Option<Target> {
        if self.is_there("at") && self.is_there("on") {
            let [at, on] = ["at", "on"].map(|key| self.optional(key).and_then(|v| r.text(v)));
            let (at, on) = at.zip(on)?;
            if at.name.contains('.') {
                let error = Diagnostic::error("`at` names a link, and so does `on`", on.span, "the second one");
                r.findings.push(error.help("take `on` out"));
                return None;
            }
            return Some(Target::Point(Identifier { name: format!("{}.{}", on.name, at.name), ..at }));
        }
        match self.one_of(r, &["at", "on"], "name a point with `at`, or a body with `on`")? {
            "at" => self.optional("at").and_then(|v| r.text(v)).map(Target::Point),
            _ => self.optional("on").and_then(|v| r.text(v)).map(Target::Body),
        }
    }

    fn unknown(&self, key: &Key) -> Diagnostic {
        Diagnostic::error(format!("unknown key `{}` in {}", key.get_ref(), self.what), key.span(), "not known")
    }

    /// Reports the keys that were not read.
    pub(super) fn finish(self, r: &mut Reader) {
        let known = self.known.take();
        for (key, value) in self.entries.iter().filter(|(key, _)| !known.iter().any(|k| k == key.get_ref())) {
            let error = self.unknown(key);
            // A whole section may have been intended to declare names.
            r.has_unread_declarations |= self.what == SCENE && (Value(value).is_table() || Value(value).is_array());
            let names = known.iter().map(String::as_str);
            let help = suggestion(key.get_ref(), names, || format!("known keys: {}", known.join(", ")));
            r.findings.push(error.help(help));
        }
    }
}

/// Shows how to write a missing key.
fn example(key: &str) -> String {
    let value = match key {
        "initial" => return "[initial] with `given = { NAME = ..., NAME_dot = ... }`".to_owned(),
        "run" => return "[run] with `step = ...` and `end_time = ...`".to_owned(),
        "coordinates" => "[\"NAME\", ...]",
        "set" => "{ NAME = ..., ... }",
        "given" => "{ NAME = ..., NAME_dot = ... }",
        "along" => "['x', 'y']",
        "name" | "on" => "\"NAME\"",
        "residual" => "'...'",
        _ => "...",
    };
    format!("`{key} = {value}`")
}

impl Reader<'_> {
    pub(super) fn table<'t, 'v>(&mut self, what: &str, value: Value<'t, 'v>) -> Option<Table<'t, 'v>> {
        if let DeValue::Table(entries) = value.0.get_ref() {
            return Some(Table::new(what.to_owned(), entries, value.span()));
        }
        self.has_unread_declarations = true;
        self.wrong_type(value, &format!("a table for {what}"));
        None
    }
}
