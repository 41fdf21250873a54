//! Resolves the names in formulae.

use std::collections::HashSet;

use super::context::Context;
use super::points::point_value;
use super::{Resolver, check};
use crate::diagnostic::{Diagnostic, MAX_SHOWN, errors};
use crate::document::{Identifier, Position};
use crate::names::suggestion;
use crate::parser::Formula;
use crate::scene::{Body, Quantity, Scene, Value};

impl Resolver<'_> {
    /// Looks up every name of a formula and checks what its context forbids.
    pub(super) fn value(&mut self, formula: &Formula, context: Context) -> Value {
        let mut left = MAX_SHOWN.saturating_sub(errors(&self.findings));
        let (scope, findings, has_unknown) = (&self.scope, &mut self.findings, &mut self.has_unknown);
        let mut reported: HashSet<String> = HashSet::new();
        let value = formula.map(|name, span| {
            // Unreadable parts have been reported already, and long lists of errors are truncated.
            if name.is_empty() || left == 0 {
                *has_unknown |= left == 0;
                return Quantity::Unknown;
            }
            scope.look_up(name, span.clone(), context).unwrap_or_else(|finding| {
                *has_unknown = true;
                // A repeated name in one formula is reported once.
                if (scope.knows(name) || !self.has_unread_declarations) && reported.insert(name.clone()) {
                    findings.push(finding);
                    left -= 1;
                }
                Quantity::Unknown
            })
        });
        if !matches!(context, Context::Constant | Context::Profile | Context::Picture | Context::Condition) {
            check::differentiable(&value, context == Context::Geometry, &mut self.findings);
        }
        value
    }

    pub(super) fn find(&mut self, what: &str, identifier: &Identifier, names: &[&str]) -> Option<usize> {
        let place = names.iter().position(|name| *name == identifier.name);
        self.has_unknown |= place.is_none();
        if place.is_none() && !self.has_unread_declarations {
            let title = format!("unknown {what} `{}`", identifier.name);
            self.findings.push(Diagnostic::error(title, identifier.span.clone(), "not known").help(near_or_all(
                what,
                &identifier.name,
                names,
            )));
        }
        place
    }

    pub(super) fn point(&mut self, identifier: &Identifier) -> Option<usize> {
        let names: Vec<String> = self.scope.points().map(str::to_owned).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        self.find("point", identifier, &names)
    }

    pub(super) fn body_named(&mut self, scene: &Scene, identifier: &Identifier) -> Option<Body> {
        let names: Vec<&str> = scene.bodies.iter().map(|b| b.name.as_str()).collect();
        self.find("body", identifier, &names).map(|i| scene.bodies[i].clone())
    }

    pub(super) fn position(&mut self, position: &Position, context: Context) -> Option<[Value; 2]> {
        match position {
            Position::Point(point) => self.point(point).map(|i| point_value(i, point.span.clone())),
            Position::Pair([x, y]) => Some([self.value(x, context), self.value(y, context)]),
        }
    }
}

/// Help for an unknown name.
pub(super) fn near_or_all(what: &str, name: &str, known: &[&str]) -> String {
    suggestion(name, known.iter().copied(), || match known {
        [] => format!("the scene has no {what}"),
        _ => format!("known: {}", known.join(", ")),
    })
}
