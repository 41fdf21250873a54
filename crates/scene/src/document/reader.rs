//! Reads TOML values as texts, formulae and numbers; wrong types are reported with their locations.

use num_rational::BigRational;
use toml::Spanned;
use toml::de::DeValue;

use super::characters;
use super::identifier::Identifier;
use super::places::Places;
use crate::declarations::Declarations;
use crate::diagnostic::{Diagnostic, Span};
use crate::dimension::{Dimension, Source, unknown_dimension};
use crate::expression::Node;
use crate::parser::{Condition, Formula, parse_condition, parse_quantity};
use crate::unit::Unit;

/// The text of the file and the errors found in it.
pub(super) struct Reader<'s> {
    source: &'s str,
    pub(super) findings: Vec<Diagnostic>,
    /// The names that formulae may contain.
    pub(super) declarations: Declarations,
    /// Whether a part that may declare names could not be read.
    pub(super) has_unread_declarations: bool,
    /// The number of findings about the inside of a formula.
    pub(super) unreadable: usize,
}

impl<'s> Reader<'s> {
    pub(super) fn new(source: &'s str) -> Self {
        Self {
            source,
            findings: Vec::new(),
            declarations: Declarations::default(),
            has_unread_declarations: false,
            unreadable: 0,
        }
    }

    pub(super) fn wrong_type(&mut self, value: Value, expected: &str) {
        let label = format!("this is {}", value.kind());
        self.findings.push(Diagnostic::error(format!("expected {expected}"), value.span(), label));
    }

    pub(super) fn array<'t, 'v>(&mut self, value: Value<'t, 'v>) -> Vec<Value<'t, 'v>> {
        if let DeValue::Array(items) = value.0.get_ref() {
            return items.iter().map(Value).collect();
        }
        self.has_unread_declarations = true;
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

    /// Reports invisible characters and characters that change the direction of text: neither Rust nor XML accepts
    /// them.
    pub(super) fn check_characters(&mut self, value: Value, text: &str, allowed: fn(char) -> bool) {
        let bad = text.char_indices().find(|(_, c)| !allowed(*c) && characters::is_refused(*c));
        let Some((at, character)) = bad else { return };
        let span = self.places(value, text).span(&(at..at + character.len_utf8()));
        // If the file contains the character literally, it has been reported already.
        if !self.source[span.clone()].contains(character) || character.is_control() {
            self.findings.push(characters::refusal(character, span));
        }
    }

    fn places(&self, value: Value, text: &str) -> Places {
        Places::from_string(&self.source[value.span()], value.span().start, text)
    }

    /// Reads a formula whose unit is not known.
    pub(super) fn formula(&mut self, value: Value) -> Formula {
        let (formula, dimension) = self.with_dimension(value, None);
        self.check_dimension(&formula, &dimension, None);
        formula
    }

    /// Reads a formula for a quantity in this unit.
    pub(super) fn quantity(&mut self, value: Value, unit: &str) -> Formula {
        let (formula, dimension) = self.with_dimension(value, None);
        self.check_dimension(&formula, &dimension, Unit::parse(unit).as_ref());
        formula
    }

    /// Reads a formula with its dimension. `unit` is the unit to which the value will be converted.
    pub(super) fn with_dimension(&mut self, value: Value, unit: Option<&Unit>) -> (Formula, Dimension) {
        let parse = |text: &str, declarations: &Declarations| parse_quantity(text, 0, declarations, unit);
        let parsed = self.parse(value, parse, |(formula, _)| formula);
        let (formula, mut dimension) = parsed.unwrap_or_else(|| (placeholder(), Dimension::default()));
        if let Some(ambiguity) = &mut dimension.ambiguity {
            ambiguity.span = Some(formula.whole_span());
        }
        (formula, dimension)
    }

    /// Reads a formula for a number in this unit. Bare numbers are in this unit, and other formulae are converted to
    /// it.
    pub(super) fn number_in(&mut self, value: Value, unit: Option<&Unit>) -> Formula {
        let (mut formula, dimension) = self.with_dimension(value, None);
        self.check_dimension(&formula, &dimension, unit);
        let Some(unit) = unit.filter(|unit| unit.is_scaled()) else { return formula };
        // Unreadable formulae have been reported.
        if formula.names().any(String::is_empty) {
            return formula;
        }
        let span = formula.whole_span();
        if dimension.is_bare {
            if unit.is_number() && formula.names().next().is_some() {
                let error = Diagnostic::error("`pi` is no number of this unit", span, "in radians?");
                self.findings.push(error.help("write the number in the unit, or leave the unit out"));
            }
            return formula;
        }
        if dimension.unit.is_none() && dimension.source < Source::Conversion {
            self.findings.push(unknown_dimension(span.clone()));
        }
        let last = formula.nodes().len() - 1;
        unit.append_inverse(&mut formula, last, &span);
        formula
    }

    /// Reports a formula that cannot have this unit, or words in it that may be units or names.
    pub(super) fn check_dimension(&mut self, formula: &Formula, dimension: &Dimension, unit: Option<&Unit>) {
        let error = match unit {
            // A parameter alone has the unit that it was given.
            Some(unit) if dimension.source == Source::Declaration && matches!(formula.nodes(), [Node::Name(_)]) => {
                dimension.clone().converted().misfit(unit, formula.whole_span())
            }
            Some(unit) => dimension.misfit(unit, formula.whole_span()),
            None => dimension.ambiguity.as_deref().cloned(),
        };
        self.findings.extend(error);
    }

    /// Reads a formula for an angle. A number without a unit is in radians, and at most a turn.
    pub(super) fn angle(&mut self, value: Value) -> Formula {
        let formula = self.quantity(value, "rad");
        let number = match formula.nodes() {
            [Node::Number(number)] | [Node::Number(number), Node::Negate(_)] => number.value,
            _ => return formula,
        };
        let text = self.source[value.span()].trim_matches(['\'', '"']).trim();
        if number > std::f64::consts::TAU && !text.ends_with("rad") {
            self.findings.push(Diagnostic::angle_without_unit(text, value.span()));
        }
        formula
    }

    pub(super) fn condition(&mut self, value: Value) -> Option<Condition<String>> {
        let parse = |text: &str, declarations: &Declarations| parse_condition(text, 0, declarations);
        self.parse(value, parse, |condition| &mut condition.difference)
    }

    /// Reads a number, exactly as written.
    pub(super) fn number(&mut self, value: Value) -> Option<BigRational> {
        if matches!(value.0.get_ref(), DeValue::Integer(_) | DeValue::Float(_)) {
            return match self.formula(value).nodes() {
                [Node::Number(number)] => Some(number.exact.clone()),
                [Node::Number(number), Node::Negate(_)] => Some(-number.exact.clone()),
                _ => None,
            };
        }
        self.wrong_type(value, "a number");
        None
    }

    /// Reads two formulae in this unit in an array.
    pub(super) fn pair(&mut self, value: Value, unit: &str) -> [Formula; 2] {
        let items = if value.is_array() { self.array(value) } else { Vec::new() };
        if let [x, y] = items[..] {
            return [self.quantity(x, unit), self.quantity(y, unit)];
        }
        self.wrong_type(value, "an array of two formulae, `['x', 'y']`");
        [placeholder(), placeholder()]
    }

    fn parse<T>(
        &mut self,
        value: Value,
        parse: impl FnOnce(&str, &Declarations) -> Result<T, Diagnostic>,
        formula: fn(&mut T) -> &mut Formula,
    ) -> Option<T> {
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
        let result = parse(&text, &self.declarations).map(|mut parsed| {
            formula(&mut parsed).move_spans(|span| places.span(span));
            parsed
        });
        let place = |finding: Diagnostic| Diagnostic {
            span: finding.span.map(|span| places.span(&span)),
            context: finding.context.map(|(span, label)| (places.span(&span), label)),
            ..finding
        };
        self.unreadable += usize::from(result.is_err());
        result.map_err(|finding| self.findings.push(place(finding))).ok()
    }
}

/// A value and its location.
#[derive(Clone, Copy)]
pub(super) struct Value<'t, 's>(pub(super) &'t Spanned<DeValue<'s>>);

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

/// Whether a TOML number is a finite decimal.
fn is_decimal(raw: &str) -> bool {
    raw.chars().all(|c| c.is_ascii_digit() || "+-._eE".contains(c))
}

/// Replaces an unreadable formula, so that the rest of the file is still checked.
pub(super) fn placeholder() -> Formula {
    let mut formula = Formula::new();
    formula.push(Node::Name(String::new()), 0..0);
    formula
}
