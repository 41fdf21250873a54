//! Typed access to TOML values that reports wrong types, missing keys and unknown keys with their places.

use std::cell::RefCell;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Identifier, Target};
use crate::diagnostic::{Diagnostic, Span};
use crate::expression::{Node, Number};
use crate::names::closest;
use crate::parser::{Condition, Formula, parse_condition, parse_formula};

/// A parsed file.
pub(super) struct Root<'s>(Spanned<DeTable<'s>>);

/// Parses the file's form.
pub(super) fn parse<'s>(source: &'s str, findings: &mut Vec<Diagnostic>) -> Root<'s> {
    let (table, errors) = DeTable::parse_recoverable(source);
    findings.extend(errors.iter().map(|error| match error.span() {
        Some(span) => Diagnostic::error(error.message(), span, "not valid TOML here"),
        None => Diagnostic::whole_file(error.message()),
    }));
    Root(table)
}

impl<'s> Root<'s> {
    pub(super) fn table(&self) -> Table<'_, 's> {
        Table::new("the scene".to_owned(), self.0.get_ref(), self.0.span())
    }
}

/// A value and its place.
#[derive(Clone, Copy)]
pub(super) struct Value<'t, 's>(&'t Spanned<DeValue<'s>>);

impl Value<'_, '_> {
    pub(super) fn span(&self) -> Span {
        self.0.span()
    }

    pub(super) fn is_table(&self) -> bool {
        matches!(self.0.get_ref(), DeValue::Table(_))
    }

    pub(super) fn is_array(&self) -> bool {
        matches!(self.0.get_ref(), DeValue::Array(_))
    }

    fn kind(&self) -> &'static str {
        match self.0.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        }
    }
}

/// A table, and which of its keys have been asked for.
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
        self.known.borrow_mut().push(key.to_owned());
        self.entries.iter().find(|(k, _)| k.get_ref() == key).map(|(_, value)| Value(value))
    }

    pub(super) fn required(&self, r: &mut Reader, key: &str) -> Option<Value<'t, 's>> {
        let value = self.optional(key);
        if value.is_none() {
            let title = format!("{} has no `{key}`", self.what);
            r.findings.push(if self.what == "the scene" {
                Diagnostic::whole_file(title)
            } else {
                Diagnostic::error(title, self.span.clone(), format!("`{key}` is missing"))
            });
        }
        value
    }

    /// The text under a key, empty if there is none.
    pub(super) fn string(&self, r: &mut Reader, key: &str) -> String {
        self.optional(key).and_then(|v| r.text(v)).map(|text| text.name).unwrap_or_default()
    }

    /// The entries of the table under a key, in the order of the file; none if there is no such key.
    pub(super) fn entries(&self, r: &mut Reader, key: &str) -> Vec<(Identifier, Value<'t, 's>)> {
        let Some(value) = self.optional(key) else { return Vec::new() };
        let Some(table) = r.table(&format!("[{key}]"), value) else { return Vec::new() };
        let entries = table.all();
        for (identifier, _) in &entries {
            r.check_name(identifier, key.trim_end_matches('s'));
        }
        entries
    }

    pub(super) fn all(&self) -> Vec<(Identifier, Value<'t, 's>)> {
        let identifier = |key: &Spanned<toml::de::DeString>| Identifier {
            name: key.get_ref().to_string(),
            span: key.span(),
        };
        self.entries.iter().map(|(key, value)| (identifier(key), Value(value))).collect()
    }

    /// Which one of these keys is there.
    pub(super) fn one_of(&self, r: &mut Reader, keys: &[&'static str], also: &str) -> Option<&'static str> {
        let present: Vec<&'static str> = keys.iter().copied().filter(|key| self.optional(key).is_some()).collect();
        if let [key] = present[..] {
            return Some(key);
        }
        let said = if present.is_empty() { "none is given".to_owned() } else { format!("`{}` are given", present.join("`, `")) };
        let mut error = Diagnostic::error(
            format!("{} needs exactly one of `{}`", self.what, keys.join("`, `")),
            self.span.clone(),
            said,
        );
        if !also.is_empty() {
            error = error.help(format!("a spring or damper is written `{also}`"));
        }
        r.findings.push(error);
        None
    }

    /// `at = "point"` or `on = "body"`.
    pub(super) fn target(&self, r: &mut Reader) -> Option<Target> {
        match self.one_of(r, &["at", "on"], "")? {
            "at" => self.optional("at").and_then(|v| r.text(v)).map(Target::Point),
            _ => self.optional("on").and_then(|v| r.text(v)).map(Target::Body),
        }
    }

    /// Reports keys that nothing asked for.
    pub(super) fn finish(self, r: &mut Reader) {
        let known = self.known.into_inner();
        for key in self.entries.keys().filter(|key| !known.iter().any(|k| k == key.get_ref())) {
            let error =
                Diagnostic::error(format!("unknown key `{}` in {}", key.get_ref(), self.what), key.span(), "not known");
            let near = closest(key.get_ref(), known.iter().map(String::as_str));
            r.findings.push(match near {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("known keys: {}", known.join(", "))),
            });
        }
    }
}

/// The file's text and what has been found wrong in it.
pub(super) struct Reader<'s> {
    source: &'s str,
    pub(super) findings: Vec<Diagnostic>,
}

impl<'s> Reader<'s> {
    pub(super) fn new(source: &'s str) -> Self {
        Self { source, findings: Vec::new() }
    }

    fn wrong_type(&mut self, value: Value, expected: &str) {
        let label = format!("this is {}", value.kind());
        self.findings.push(Diagnostic::error(format!("expected {expected}"), value.span(), label));
    }

    pub(super) fn table<'t, 'v>(&mut self, what: &str, value: Value<'t, 'v>) -> Option<Table<'t, 'v>> {
        if let DeValue::Table(entries) = value.0.get_ref() {
            return Some(Table::new(what.to_owned(), entries, value.span()));
        }
        self.wrong_type(value, &format!("a table for {what}"));
        None
    }

    pub(super) fn array<'t, 'v>(&mut self, value: Value<'t, 'v>) -> Vec<Value<'t, 'v>> {
        if let DeValue::Array(items) = value.0.get_ref() {
            return items.iter().map(Value).collect();
        }
        self.wrong_type(value, "an array");
        Vec::new()
    }

    pub(super) fn boolean(&mut self, value: Value) -> bool {
        if let DeValue::Boolean(truth) = value.0.get_ref() {
            return *truth;
        }
        self.wrong_type(value, "`true` or `false`");
        false
    }

    pub(super) fn text(&mut self, value: Value) -> Option<Identifier> {
        if let DeValue::String(text) = value.0.get_ref() {
            return Some(Identifier { name: text.to_string(), span: self.inside(value, text) });
        }
        self.wrong_type(value, "a string");
        None
    }

    /// Where the characters of a string stand, its quotes left out.
    fn inside(&self, value: Value, text: &str) -> Span {
        let span = value.span();
        match self.source.get(span.clone()).and_then(|raw| raw.find(text)) {
            Some(at) if !text.is_empty() => span.start + at..span.start + at + text.len(),
            _ => span,
        }
    }

    pub(super) fn formula(&mut self, value: Value) -> Formula {
        self.parse(value, parse_formula).unwrap_or_else(placeholder)
    }

    pub(super) fn condition(&mut self, value: Value) -> Option<Condition<String>> {
        self.parse(value, parse_condition)
    }

    /// Two formulae in an array.
    pub(super) fn pair(&mut self, value: Value) -> [Formula; 2] {
        let items = if value.is_array() { self.array(value) } else { Vec::new() };
        if let [x, y] = items[..] {
            return [self.formula(x), self.formula(y)];
        }
        self.wrong_type(value, "an array of two formulae, `['x', 'y']`");
        [placeholder(), placeholder()]
    }

    fn parse<T>(&mut self, value: Value, parse: fn(&str, usize) -> Result<T, Diagnostic>) -> Option<T> {
        let span = value.span();
        let result = match value.0.get_ref() {
            DeValue::String(text) => {
                let inside = self.inside(value, text);
                let exact = self.source.get(inside.clone()) == Some(text.as_ref());
                parse(text, inside.start).map_err(|mut finding| {
                    if !exact {
                        // Escapes inside the string: its bytes are not the file's.
                        finding.span = Some(span.clone());
                    }
                    finding
                })
            }
            DeValue::Integer(_) | DeValue::Float(_) => {
                let raw = self.source.get(span.clone()).unwrap_or_default();
                if raw.ends_with("inf") || raw.ends_with("nan") {
                    Err(Diagnostic::error("number out of range", span.clone(), "a finite number is needed"))
                } else {
                    parse(&raw.replace('_', ""), span.start)
                }
            }
            _ => {
                self.wrong_type(value, "a number or a formula in a string");
                return None;
            }
        };
        result.map_err(|finding| self.findings.push(finding)).ok()
    }
}

/// Stands for a formula that could not be read, so that the rest of the file is still checked.
pub(super) fn placeholder() -> Formula {
    let mut formula = Formula::new();
    formula.push(Node::Number(Number::whole(1)), 0..0);
    formula
}
