//! Reference values of a mechanism: `[reference]` and `[[extreme]]`.

use super::reader::{self, Reader};
use super::{ExtremeSyntax, Identifier, ReferenceSyntax};
use crate::parser::Formula;

pub(super) fn reference(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<ReferenceSyntax> {
    let table = r.table(&format!("reference `{}`", identifier.name), value)?;
    let t = table.required(r, "t").map_or_else(reader::placeholder, |v| r.quantity(v, "s"));
    let accuracy = table.required(r, "accuracy").map_or_else(reader::placeholder, |v| r.formula(v));
    let values = table.required(r, "values").map(|v| values(r, "values", v)).unwrap_or_default();
    let doc = table.string(r, "doc");
    table.finish(r);
    Some(ReferenceSyntax { identifier, doc, t, accuracy, values })
}

pub(super) fn extreme(r: &mut Reader, value: reader::Value) -> Option<ExtremeSyntax> {
    let table = r.table("an extreme", value)?;
    let identifier = table.required(r, "name").and_then(|v| r.text(v));
    let doc = table.string(r, "doc");
    let set = table.required(r, "set").map(|v| values(r, "set", v));
    let end_time = table.optional("end_time").map(|v| r.quantity(v, "s"));
    let accuracy = table.optional("accuracy").map(|v| r.formula(v));
    let values = table.optional("values").map(|v| values(r, "values", v)).unwrap_or_default();
    table.finish(r);
    Some(ExtremeSyntax { identifier: identifier?, doc, set: set?, end_time, accuracy, values })
}

/// Reads a table of numbers by name, in the units of the names.
pub(super) fn values(r: &mut Reader, what: &str, value: reader::Value) -> Vec<(Identifier, Formula)> {
    let Some(table) = r.table(what, value) else { return Vec::new() };
    let number = |(identifier, value): (Identifier, reader::Value)| {
        let unit = r.declarations.unit(&identifier.name);
        (identifier, r.number_in(value, unit.as_ref()))
    };
    table.all().into_iter().map(number).collect()
}
