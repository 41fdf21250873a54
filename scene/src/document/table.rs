//! Typed access to TOML values that reports wrong types, missing keys and unknown keys with their places.

use std::cell::RefCell;
use std::sync::Arc;

use num_rational::BigRational;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::places::Places;
use super::{Identifier, Target, characters, form};
use crate::diagnostic::{Diagnostic, Span};
use crate::expression::Node;
use crate::names::{closest, suggestion};
use crate::parser::{Condition, Formula, parse_condition, parse_formula};
use crate::spline::Spline;

type Key<'s> = Spanned<DeString<'s>>;

/// Reads a text that begins at a byte of the file and may call lookup tables.
type Parse<T> = fn(&str, usize, &[Arc<Spline>]) -> Result<T, Diagnostic>;

/// The name in messages of the table that is the whole file.
const SCENE: &str = "the scene";

/// A parsed file.
pub(super) struct Root<'s>(Spanned<DeTable<'s>>);

/// Parses the file's form.
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

    pub(super) fn is_text(&self) -> bool {
        matches!(self.0.get_ref(), DeValue::String(_))
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
        if !self.known.borrow().iter().any(|known| known == key) {
            self.known.borrow_mut().push(key.to_owned());
        }
        self.get(key)
    }

    /// Whether there is such a key, whoever asks for it.
    pub(super) fn is_there(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    fn get(&self, key: &str) -> Option<Value<'t, 's>> {
        self.entries.iter().find(|(k, _)| k.get_ref() == key).map(|(_, value)| Value(value))
    }

    pub(super) fn required(&self, r: &mut Reader, key: &str) -> Option<Value<'t, 's>> {
        let value = self.optional(key);
        // A mistyped key is reported as unknown: that says more.
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

    /// A key that looks like one of `keys` and is none.
    fn mistyped<'k>(&self, keys: &[&'k str]) -> Option<(&'t Key<'s>, &'k str)> {
        let mut others = self.entries.keys().filter(|key| !keys.contains(&key.get_ref().as_ref()));
        others.find_map(|key| Some((key, closest(key.get_ref(), keys.iter().copied())?)))
    }

    /// The text under a key, or an empty text. Line breaks in a unit are reported.
    pub(super) fn string(&self, r: &mut Reader, key: &str) -> String {
        if let ("unit", Some(value)) = (key, self.get(key))
            && let DeValue::String(text) = value.0.get_ref()
        {
            r.check_characters(value, text, |c| !matches!(c, '\n' | '\r' | '\t'));
        }
        self.optional(key).and_then(|v| r.text(v)).map(|text| text.name).unwrap_or_default()
    }

    /// The entries of the table under a key, in the order of the file; none if there is no such key.
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

    /// The one of these keys that is there; `help` says more about them.
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

    /// `at = "point"` or `on = "body"`.
    pub(super) fn target(&self, r: &mut Reader) -> Option<Target> {
        match self.one_of(r, &["at", "on"], "name a point with `at`, or a body with `on`")? {
            "at" => self.optional("at").and_then(|v| r.text(v)).map(Target::Point),
            _ => self.optional("on").and_then(|v| r.text(v)).map(Target::Body),
        }
    }

    fn unknown(&self, key: &Key) -> Diagnostic {
        Diagnostic::error(format!("unknown key `{}` in {}", key.get_ref(), self.what), key.span(), "not known")
    }

    /// Reports keys that nothing asked for.
    pub(super) fn finish(self, r: &mut Reader) {
        let known = self.known.take();
        for (key, value) in self.entries.iter().filter(|(key, _)| !known.iter().any(|k| k == key.get_ref())) {
            let error = self.unknown(key);
            // A whole section may have been meant to declare names.
            r.lost |= self.what == SCENE && (Value(value).is_table() || Value(value).is_array());
            let names = known.iter().map(String::as_str);
            let help = suggestion(key.get_ref(), names, || format!("known keys: {}", known.join(", ")));
            r.findings.push(error.help(help));
        }
    }
}

/// How a missing key is written.
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

/// The file's text and what has been found wrong in it.
pub(super) struct Reader<'s> {
    source: &'s str,
    pub(super) findings: Vec<Diagnostic>,
    /// The lookup tables that formulae may call besides the built-in functions.
    pub(super) lookup_tables: Vec<Arc<Spline>>,
    /// Whether something that may declare names could not be read.
    pub(super) lost: bool,
    /// How many of the findings are about the inside of a formula.
    pub(super) unreadable: usize,
}

impl<'s> Reader<'s> {
    pub(super) fn new(source: &'s str) -> Self {
        Self { source, findings: Vec::new(), lookup_tables: Vec::new(), lost: false, unreadable: 0 }
    }

    pub(super) fn wrong_type(&mut self, value: Value, expected: &str) {
        let label = format!("this is {}", value.kind());
        self.findings.push(Diagnostic::error(format!("expected {expected}"), value.span(), label));
    }

    pub(super) fn table<'t, 'v>(&mut self, what: &str, value: Value<'t, 'v>) -> Option<Table<'t, 'v>> {
        if let DeValue::Table(entries) = value.0.get_ref() {
            return Some(Table::new(what.to_owned(), entries, value.span()));
        }
        self.lost = true;
        self.wrong_type(value, &format!("a table for {what}"));
        None
    }

    pub(super) fn array<'t, 'v>(&mut self, value: Value<'t, 'v>) -> Vec<Value<'t, 'v>> {
        if let DeValue::Array(items) = value.0.get_ref() {
            return items.iter().map(Value).collect();
        }
        self.lost = true;
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
            self.check_characters(value, text, |c| matches!(c, '\n' | '\r' | '\t'));
            let span = if text.is_empty() { value.span() } else { self.places(value, text).whole() };
            return Some(Identifier { name: text.to_string(), span });
        }
        self.wrong_type(value, "a string");
        None
    }

    /// Reports characters that cannot be seen, or that turn the text around them: neither Rust nor XML accepts them.
    fn check_characters(&mut self, value: Value, text: &str, allowed: fn(char) -> bool) {
        let bad = text.char_indices().find(|(_, c)| !allowed(*c) && characters::is_refused(*c));
        let Some((at, character)) = bad else { return };
        let span = self.places(value, text).span(&(at..at + character.len_utf8()));
        // As such in the file it has been found already.
        if !self.source[span.clone()].contains(character) || character.is_control() {
            self.findings.push(characters::refusal(character, span));
        }
    }

    fn places(&self, value: Value, text: &str) -> Places {
        Places::from_string(&self.source[value.span()], value.span().start, text)
    }

    pub(super) fn formula(&mut self, value: Value) -> Formula {
        self.parse(value, parse_formula, |formula| formula).unwrap_or_else(placeholder)
    }

    pub(super) fn condition(&mut self, value: Value) -> Option<Condition<String>> {
        self.parse(value, parse_condition, |condition| &mut condition.difference)
    }

    /// A number as it is written.
    pub(super) fn number(&mut self, value: Value) -> Option<BigRational> {
        if matches!(value.0.get_ref(), DeValue::Integer(_) | DeValue::Float(_)) {
            return match self.parse(value, parse_formula, |formula| formula)?.nodes() {
                [Node::Number(number)] => Some(number.exact.clone()),
                [Node::Number(number), Node::Negate(_)] => Some(-number.exact.clone()),
                _ => None,
            };
        }
        self.wrong_type(value, "a number");
        None
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

    fn parse<T>(&mut self, value: Value, parse: Parse<T>, formula: fn(&mut T) -> &mut Formula) -> Option<T> {
        let raw = &self.source[value.span()];
        let (text, places) = match value.0.get_ref() {
            DeValue::String(text) => (text.to_string(), self.places(value, text)),
            DeValue::Integer(_) | DeValue::Float(_) if is_decimal(raw) => Places::from_number(raw, value.span().start),
            DeValue::Integer(_) | DeValue::Float(_) => {
                let error = Diagnostic::error(format!("`{raw}` cannot be used"), value.span(), "not a finite decimal");
                self.findings.push(error.help("write a decimal like `0.5` or `1.5e-3`"));
                return None;
            }
            _ => {
                self.wrong_type(value, "a number or a formula in a string");
                return None;
            }
        };
        let result = parse(&text, 0, &self.lookup_tables).map(|mut parsed| {
            formula(&mut parsed).move_spans(|span| places.span(span));
            parsed
        });
        let place = |finding: Diagnostic| Diagnostic { span: finding.span.map(|span| places.span(&span)), ..finding };
        self.unreadable += usize::from(result.is_err());
        result.map_err(|finding| self.findings.push(place(finding))).ok()
    }
}

/// Whether a number of TOML is neither hexadecimal, octal or binary, nor infinite or undefined.
fn is_decimal(raw: &str) -> bool {
    raw.chars().all(|c| c.is_ascii_digit() || "+-._eE".contains(c))
}

/// Stands for a formula that could not be read, so that the rest of the file is still checked.
pub(super) fn placeholder() -> Formula {
    let mut formula = Formula::new();
    formula.push(Node::Name(String::new()), 0..0);
    formula
}
