//! Resolves reference values.

use super::Resolver;
use super::context::Context;
use super::values::near_or_all;
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier};
use crate::parser::Formula;
use crate::scene::{Known, Reference, Value};

impl Resolver<'_> {
    pub(super) fn references(&mut self, document: &Document) -> Vec<Reference> {
        let mut references = Vec::new();
        for syntax in &document.references {
            let t = self.value(&syntax.t, Context::Constant);
            let accuracy = self.value(&syntax.accuracy, Context::Constant);
            let values = self.known_values(document, &syntax.values);
            let (name, doc) = (syntax.identifier.name.clone(), syntax.doc.clone());
            references.push(Reference { name, doc, t, accuracy, values });
        }
        references
    }

    /// Resolves values of coordinates, rates and outputs; reports other names.
    pub(super) fn known_values(
        &mut self,
        document: &Document,
        values: &[(Identifier, Formula)],
    ) -> Vec<(Known, Value)> {
        let mut found = Vec::new();
        for (identifier, value) in values {
            let value = self.value(value, Context::Constant);
            found.extend(self.known(document, identifier).map(|known| (known, value)));
        }
        found
    }

    fn known(&mut self, document: &Document, identifier: &Identifier) -> Option<Known> {
        let coordinates: Vec<&str> = document.coordinates.iter().map(|c| c.identifier.name.as_str()).collect();
        let outputs: Vec<&str> = document.outputs.iter().map(|o| o.identifier.name.as_str()).collect();
        let place = |names: &[&str], name: &str| names.iter().position(|other| *other == name);
        let name = identifier.name.as_str();
        let rate = || name.strip_suffix("_dot").and_then(|base| place(&coordinates, base));
        let found = place(&coordinates, name)
            .map(Known::Coordinate)
            .or_else(|| place(&outputs, name).map(Known::Output))
            .or_else(|| rate().map(Known::Rate));
        if found.is_none() && !self.has_unread_declarations {
            let rates: Vec<String> = coordinates.iter().map(|name| format!("{name}_dot")).collect();
            let names: Vec<&str> =
                coordinates.iter().copied().chain(rates.iter().map(String::as_str)).chain(outputs).collect();
            let title = format!("`{name}` is neither a coordinate, a rate nor an output");
            let help = near_or_all("output", name, &names);
            self.findings.push(Diagnostic::error(title, identifier.span.clone(), "not known").help(help));
        }
        found
    }
}
