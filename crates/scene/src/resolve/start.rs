//! Coordinates, and their values at the start.

use std::collections::HashMap;

use super::Resolver;
use super::context::Context;
use super::values::near_or_all;
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier};
use crate::scene::{Coordinate, Start};

impl Resolver<'_> {
    pub(super) fn coordinates(&mut self, document: &Document) -> Vec<Coordinate> {
        let found = self.findings.len();
        let mut starts: HashMap<&str, Start> = HashMap::new();
        for (identifier, formula) in &document.given {
            let value = self.value(formula, Context::Constant);
            self.check_start_name(document, identifier);
            starts.insert(&identifier.name, Start::Given(value));
        }
        for (identifier, formula) in &document.solve {
            let value = self.value(formula, Context::Constant);
            self.check_start_name(document, identifier);
            if starts.insert(&identifier.name, Start::Guess(value)).is_some() {
                let given = document.given.iter().find(|(given, _)| given.name == identifier.name);
                let span = given.map_or(document.given_span.clone(), |(given, _)| given.span.clone());
                self.findings.push(
                    Diagnostic::error(
                        format!("`{}` is both given and solved for", identifier.name),
                        identifier.span.clone(),
                        "solved for here",
                    )
                    .context(span, "given here")
                    .help("take one of the two out"),
                );
            }
        }
        self.is_well_formed &= self.findings.len() == found;
        let coordinate = |syntax: &crate::document::CoordinateSyntax| {
            let name = syntax.identifier.name.clone();
            let unit = if syntax.unit.is_empty() { "rad".to_owned() } else { syntax.unit.clone() };
            Coordinate {
                position: starts.get(name.as_str()).cloned().unwrap_or(Start::Free),
                rate: starts.get(format!("{name}_dot").as_str()).cloned().unwrap_or(Start::Free),
                unit,
                doc: syntax.doc.clone(),
                span: syntax.identifier.span.clone(),
                name,
            }
        };
        document.coordinates.iter().map(coordinate).collect()
    }

    fn check_start_name(&mut self, document: &Document, identifier: &Identifier) {
        let names: Vec<String> = document
            .coordinates
            .iter()
            .flat_map(|c| [c.identifier.name.clone(), format!("{}_dot", c.identifier.name)])
            .collect();
        if !names.contains(&identifier.name) && !self.has_unread_declarations {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            self.findings.push(
                Diagnostic::error(
                    format!("`{}` is neither a coordinate nor the rate of one", identifier.name),
                    identifier.span.clone(),
                    "not known",
                )
                .help(near_or_all("coordinate", &identifier.name, &names)),
            );
        }
    }
}
