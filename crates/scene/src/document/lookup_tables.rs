//! Entries of `[tables]`.

use std::sync::Arc;

use toml::Spanned;
use toml::de::DeValue;

use super::Identifier;
use super::reader::{self, Reader};
use crate::declarations::LookupTable;
use crate::diagnostic::{Diagnostic, Span};
use crate::dimension::Dimension;
use crate::evaluate::evaluate;
use crate::expression::{Node, to_f64};
use crate::function::Function;
use crate::parser::Formula;
use crate::spline::Spline;

/// The largest number of points of a table: each is a term of the generated code, and the time of an evaluation grows
/// with their number.
const MOST_POINTS: usize = 2000;

/// Whether entries of a table are formulae.
pub(super) fn has_formulae(value: reader::Value) -> bool {
    let DeValue::Table(table) = value.0.get_ref() else { return false };
    let has_text = |value: &Spanned<DeValue>| match value.get_ref() {
        DeValue::Array(items) => items.iter().any(|item| reader::Value(item).is_text()),
        _ => false,
    };
    ["x", "y"].into_iter().filter_map(|axis| table.get(axis)).any(has_text)
}

/// Reads a function given by points: lines between them, or a spline.
pub(super) fn lookup_table(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<LookupTable> {
    let name = identifier.name.as_str();
    let what = format!("table `{name}`");
    let meaning = match name {
        name if Function::named(name).is_some() => Some("a function"),
        "t" => Some("time"),
        "pi" => Some("the number pi"),
        "s" | "s_dot" => Some("the length that a load acts along, or its rate"),
        _ => None,
    };
    if let Some(meaning) = meaning {
        let title = format!("`{name}` already means {meaning}");
        let error = Diagnostic::error(title, identifier.span, "cannot be a table").help("choose another name");
        r.findings.push(error);
        return None;
    }
    let table = r.table(&what, value)?;
    table.string(r, "doc");
    let mut axis = |key: &str| -> Option<Vec<Entry>> {
        let value = table.required(r, key)?;
        let items = r.array(value);
        if items.len() > MOST_POINTS {
            let title = format!("{what} has {} points, more than {MOST_POINTS}", items.len());
            let error = Diagnostic::error(title, value.span(), "too many");
            r.findings.push(error.help("leave out points, or join fewer of them by `spline = \"natural\"`"));
            return None;
        }
        items.into_iter().map(|item| Entry::read(r, item)).collect()
    };
    let (x, y) = (axis("x"), axis("y"));
    let kind = table.optional("spline").map(|v| (v.span(), r.text(v)));
    table.finish(r);
    // Avoids further errors in the formulae that use an unreadable table.
    let placeholder = || Spline::natural(name, &[0.0, 1.0], &[0.0, 0.0]).map(LookupTable::from);
    let Some((x, y)) = x.zip(y) else { return placeholder() };
    if let Some(entry) = x.iter().find(|entry| matches!(entry.value, EntryValue::Formula(_))) {
        report_abscissa(r, &entry.span);
        return placeholder();
    }
    let dimensions = [&x, &y].map(|axis| dimension(r, axis));
    let x: Vec<f64> = x.iter().map(Entry::number).collect();
    let wrong = match x.windows(2).position(|pair| pair[0] >= pair[1]) {
        _ if x.len() != y.len() => {
            Some((format!("{} abscissae and {} ordinates", x.len(), y.len()), "give one `y` for each `x`"))
        }
        _ if x.len() < 2 => {
            Some(("a line needs two points or more".to_owned(), "give the points that lines are drawn through"))
        }
        Some(i) => Some((
            format!("abscissa {} does not lie above the one before", i + 2),
            "write the points from left to right; doubles have 16 digits",
        )),
        None => None,
    };
    if let Some((label, help)) = wrong {
        r.findings.push(Diagnostic::error(format!("{what} is no function"), value.span(), label).help(help));
        return placeholder();
    }
    let table = table_through(r, &identifier, kind, &x, y).or_else(placeholder)?;
    Some(LookupTable { dimensions, ..table })
}

/// A coordinate of a point of a table.
struct Entry {
    value: EntryValue,
    span: Span,
    dimension: Dimension,
}

/// The value of a coordinate of a point of a table.
enum EntryValue {
    Number(f64),
    /// A formula of parameters.
    Formula(Formula),
}

impl Entry {
    /// Reads a number, a quantity with its unit, or a formula of parameters.
    fn read(r: &mut Reader, item: reader::Value) -> Option<Self> {
        let span = item.span();
        if !item.is_text() {
            let value = EntryValue::Number(to_f64(&r.number(item)?));
            return Some(Self { value, span, dimension: Dimension::bare() });
        }
        let (formula, dimension) = r.with_dimension(item, None);
        let unknown = formula.nodes().iter().enumerate().find_map(|(id, node)| match node {
            Node::Name(name) if name != "pi" && !r.declarations.is_parameter(name) => Some((name, formula.span(id))),
            _ => None,
        });
        let Some((name, place)) = unknown else {
            let is_known = formula.names().all(|name| name == "pi");
            let value = match is_known {
                true => EntryValue::Number(evaluate(&formula, |_| std::f64::consts::PI)),
                false => EntryValue::Formula(formula),
            };
            return Some(Self { value, span, dimension });
        };
        // Unreadable formulae and declarations have been reported.
        if !name.is_empty() && !r.has_unread_declarations {
            let error = Diagnostic::error(format!("`{name}` is no parameter"), place, "stands in a table");
            r.findings.push(error.help("entries of tables contain numbers and parameters"));
        }
        None
    }

    /// Whether two entries are the same.
    fn is_same_as(&self, other: &Self) -> bool {
        match (&self.value, &other.value) {
            (EntryValue::Number(a), EntryValue::Number(b)) => a == b,
            (EntryValue::Formula(a), EntryValue::Formula(b)) => a.nodes() == b.nodes(),
            _ => false,
        }
    }

    /// The number; zero in place of a formula.
    fn number(&self) -> f64 {
        match self.value {
            EntryValue::Number(number) => number,
            EntryValue::Formula(_) => 0.0,
        }
    }
}

/// The dimension of all entries of an axis; `None` if none has a unit. Entries of another dimension are reported.
fn dimension(r: &mut Reader, entries: &[Entry]) -> Option<Dimension> {
    let has_unit = |entry: &&Entry| !entry.dimension.is_bare && entry.dimension.unit.is_some();
    let surest =
        entries.iter().filter(has_unit).reduce(|a, b| if b.dimension.source > a.dimension.source { b } else { a })?;
    let unit = surest.dimension.unit.as_ref()?;
    if surest.dimension.is_certain() {
        for entry in entries {
            if entry.dimension.is_bare && entry.number() != 0.0 {
                let title = format!("an entry has no unit, and {} is expected", unit.quantity());
                let error = Diagnostic::error(title, entry.span.clone(), "in which unit?");
                r.findings.push(error.help(format!("write it with a unit, such as `{}`", unit.base())));
            } else if !entry.dimension.is_bare {
                r.findings.extend(entry.dimension.misfit(unit, entry.span.clone()));
            }
        }
    }
    Some(surest.dimension.clone())
}

/// Reports an abscissa that is a formula.
fn report_abscissa(r: &mut Reader, span: &Span) {
    let title = "the abscissa of a table depends on a parameter";
    let error = Diagnostic::error(title, span.clone(), "not a number");
    r.findings.push(error.help("write a number here; to stretch a table, divide its argument: `NAME(x/length)`"));
}

/// The table through points whose ordinates may be formulae.
fn table_through(
    r: &mut Reader,
    identifier: &Identifier,
    kind: Option<(Span, Option<Identifier>)>,
    x: &[f64],
    y: Vec<Entry>,
) -> Option<LookupTable> {
    let numbers: Vec<f64> = y.iter().map(Entry::number).collect();
    let is_periodic = kind.as_ref().is_some_and(|(_, kind)| kind.as_ref().is_some_and(|kind| kind.name == "periodic"));
    let last = y.len() - 1;
    let spline = spline_through(r, identifier, kind.clone(), [x, &numbers], y[0].is_same_as(&y[last]))?;
    let mut table = LookupTable::from(spline);
    for (place, ordinate) in y.into_iter().enumerate() {
        let EntryValue::Formula(formula) = ordinate.value else { continue };
        // The first and the last point of a period are one.
        if is_periodic && place == last {
            continue;
        }
        let is_one = |i: usize| i == place || (is_periodic && place == 0 && i == last);
        let cardinal: Vec<f64> = (0..x.len()).map(|i| f64::from(u8::from(is_one(i)))).collect();
        // Lines end at the neighbours.
        let near = if kind.is_none() { place.saturating_sub(1)..(place + 2).min(x.len()) } else { 0..x.len() };
        let own = Identifier { name: format!("{}_{}", identifier.name, place + 1), span: identifier.span.clone() };
        let cardinal = spline_through(r, &own, kind.clone(), [&x[near.clone()], &cardinal[near]], true)?;
        table.parts.push((formula, Arc::new(cardinal)));
    }
    let terms: usize = table.parts.iter().map(|(_, spline)| spline.piece_count()).sum();
    if terms > MOST_POINTS {
        let title = format!("table `{}` has {} entries with parameters", identifier.name, table.parts.len());
        let error =
            Diagnostic::error(title, identifier.span.clone(), format!("{terms} terms, more than {MOST_POINTS}"));
        r.findings.push(error.help("leave out points, or multiply a table of numbers by the parameter"));
        return None;
    }
    Some(table)
}

/// The spline of a table: lines, or the kind that the table names.
fn spline_through(
    r: &mut Reader,
    identifier: &Identifier,
    kind: Option<(Span, Option<Identifier>)>,
    [x, y]: [&[f64]; 2],
    ends_where_it_begins: bool,
) -> Option<Spline> {
    let name = &identifier.name;
    let natural = Spline::natural(name, x, y);
    let (span, kind) = match &kind {
        None => (&identifier.span, None),
        Some((span, kind)) => (span, Some(kind.as_ref()?.name.as_str())),
    };
    let linear = Spline::linear(name, x, y);
    let (wrong, label, help) = match kind {
        None if linear.is_some() => return linear,
        None => ("points that no lines join", "too close together, or too large", "doubles have 16 digits"),
        _ if natural.is_none() => {
            ("points that no spline passes through", "too close together, or too large", "doubles have 16 digits")
        }
        Some("natural") => return natural,
        Some("periodic") if x.len() < 4 => {
            ("too few points", "needs four or more", "the last point repeats the first one")
        }
        Some("periodic") if !ends_where_it_begins => {
            ("a last point that is not the first one", "does not come back", "repeat the first `y` after a period")
        }
        Some("periodic") => return Spline::periodic(name, x, y).or(natural),
        _ => ("an unknown kind of spline", "not known", "write `spline = \"periodic\"` or `spline = \"natural\"`"),
    };
    r.findings.push(Diagnostic::error(format!("table `{name}` has {wrong}"), span.clone(), label).help(help));
    // Avoids further errors in the formulae that use it.
    natural
}
