//! Values that are known from elsewhere.

use super::{Context, Resolver, near_or_all};
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier};
use crate::scene::{Known, Reference};

impl Resolver<'_> {
    pub(super) fn references(&mut self, document: &Document) -> Vec<Reference> {
        let mut references = Vec::new();
        for syntax in &document.references {
            let t = self.value(&syntax.t, Context::Constant);
            let accuracy = self.value(&syntax.accuracy, Context::Constant);
            let mut values = Vec::new();
            for (identifier, value) in &syntax.values {
                let value = self.value(value, Context::Constant);
                values.extend(self.known(document, identifier).map(|known| (known, value)));
            }
            let (name, doc) = (syntax.identifier.name.clone(), syntax.doc.clone());
            references.push(Reference { name, doc, t, accuracy, values });
        }
        references
    }

    pub(super) fn known(&mut self, document: &Document, identifier: &Identifier) -> Option<Known> {
        let coordinates: Vec<&str> = document.coordinates.iter().map(|c| c.identifier.name.as_str()).collect();
        let outputs: Vec<&str> = document.outputs.iter().map(|o| o.identifier.name.as_str()).collect();
        let place = |names: &[&str], name: &str| names.iter().position(|other| *other == name);
        let name = identifier.name.as_str();
        let rate = || name.strip_suffix("_dot").and_then(|base| place(&coordinates, base));
        let found = place(&coordinates, name)
            .map(Known::Coordinate)
            .or_else(|| place(&outputs, name).map(Known::Output))
            .or_else(|| rate().map(Known::Rate));
        if found.is_none() && !self.lost_names {
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
