//! Extreme variants of a mechanism.

use super::Resolver;
use super::context::Context;
use crate::diagnostic::Diagnostic;
use crate::document::{Document, ExtremeSyntax};
use crate::scene::{Extreme, Scene};

impl Resolver<'_> {
    pub(super) fn extremes(&mut self, document: &Document) -> Vec<Extreme> {
        document.extremes.iter().map(|syntax| self.extreme(document, syntax)).collect()
    }

    fn extreme(&mut self, document: &Document, syntax: &ExtremeSyntax) -> Extreme {
        let parameters: Vec<&str> = document.parameters.iter().map(|p| p.identifier.name.as_str()).collect();
        let mut set = Vec::new();
        for (identifier, value) in &syntax.set {
            let value = self.value(value, Context::Constant);
            set.extend(self.find("parameter", identifier, &parameters).map(|place| (place, value)));
        }
        let mut constant = |formula: &Option<_>| formula.as_ref().map(|f| self.value(f, Context::Constant));
        let (end_time, accuracy) = (constant(&syntax.end_time), constant(&syntax.accuracy));
        let values = self.known_values(document, &syntax.values);
        let (name, doc) = (syntax.identifier.name.clone(), syntax.doc.clone());
        Extreme { name, doc, set, end_time, accuracy, values }
    }

    /// Checks extreme variants after parameters have their values.
    pub(super) fn check_extremes(&mut self, document: &Document, scene: &Scene, replace: &dyn Fn(&str) -> Option<f64>) {
        for (i, syntax) in document.extremes.iter().enumerate() {
            let name = &syntax.identifier.name;
            let mut wrong = |span: &std::ops::Range<usize>, title: String, label: &str, help: &str| {
                self.findings.push(Diagnostic::error(title, span.clone(), label).help(help));
            };
            if document.extremes[..i].iter().any(|other| other.identifier.name == *name) {
                let title = format!("a second extreme is called `{name}`");
                wrong(&syntax.identifier.span, title, "tables would not tell them apart", "choose another name");
            }
            if syntax.set.is_empty() {
                let title = format!("extreme `{name}` changes no parameter");
                wrong(&syntax.identifier.span, title, "is the scene itself", "add `set = { NAME = ... }`");
            }
            for (identifier, _) in &syntax.set {
                let parameter = scene.parameters.iter().find(|p| p.name == identifier.name);
                if parameter.is_some_and(|p| p.left_out && replace(&p.name).is_none()) {
                    let title = format!("parameter `{}` is left out of the generated code", identifier.name);
                    let help = format!("add `runtime = true` to `{}` in [parameters]", identifier.name);
                    wrong(&identifier.span, title, "is exactly zero in the scene", &help);
                }
            }
            if let Some((identifier, _)) = syntax.values.first() {
                let title = |what: &str| format!("extreme `{name}` has values but no `{what}`");
                if syntax.end_time.is_none() {
                    wrong(&identifier.span, title("end_time"), "known when?", "add `end_time = ...`");
                }
                if syntax.accuracy.is_none() {
                    let help = "add `accuracy = ...`: the largest error of the values";
                    wrong(&identifier.span, title("accuracy"), "known how well?", help);
                }
            }
        }
    }
}
