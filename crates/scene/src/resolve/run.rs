//! Resolves the end of a run.

use super::Resolver;
use super::context::Context;
use crate::diagnostic::{Diagnostic, Span};
use crate::document::Document;
use crate::expression::Node;
use crate::parser::{Condition, Formula};
use crate::scene::{Quantity, Run, Value};

impl Resolver<'_> {
    pub(super) fn run(&mut self, document: &Document) -> Run {
        let run = &document.run;
        let missing = || {
            let mut value = Value::new();
            value.push(Node::Number(crate::expression::Number::whole(1)), run.span.clone());
            value
        };
        let mut constant = |f: &Option<Formula>| f.as_ref().map(|f| self.value(f, Context::Constant));
        let step = constant(&run.step).unwrap_or_else(missing);
        let (max_time, end_time) = (constant(&run.max_time), constant(&run.end_time));
        let until = run.until.as_ref().map(|condition| self.condition(condition));
        let wrong = match (&until, &max_time, &end_time) {
            (Some(_), _, Some(_)) => Some((
                "[run] has both `until` and `end_time`",
                "two ends",
                "`until` goes with `max_time`, `end_time` stands alone",
            )),
            (Some(_), None, None) => Some((
                "[run] has `until` but no `max_time`",
                "could run for ever",
                "add `max_time`: a mechanism that stalls never meets its stop condition",
            )),
            (None, Some(_), _) => Some((
                "[run] has `max_time` but no `until`",
                "nothing to wait for",
                "write `end_time` alone, or add `until = '...'` to `max_time`",
            )),
            (None, None, None) => Some((
                "[run] does not say when to end",
                "no end",
                "add `end_time = ...`, or `until = '...'` with `max_time = ...`",
            )),
            (Some(_), Some(_), None) | (None, None, Some(_)) => None,
        };
        if let (Some((title, label, help)), true) = (wrong, run.is_well_formed) {
            self.findings.push(Diagnostic::error(title, run.span.clone(), label).help(help));
        }
        Run {
            step,
            until,
            end_time: max_time.or(end_time).unwrap_or_else(missing),
            stiff: run.stiff.is_some(),
            inverse: run.inverse.is_some(),
            elimination: run.elimination.as_ref().map(|(form, _)| *form),
        }
    }

    pub(super) fn condition(&mut self, condition: &Condition<String>) -> Condition<Quantity> {
        let before = self.findings.len();
        let difference = self.value(&condition.difference, Context::Condition);
        let is_constant = difference.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi));
        if is_constant && self.findings.len() == before {
            self.findings.push(constant_condition(difference.whole_span()));
        }
        Condition { difference, comparison: condition.comparison }
    }
}

/// The finding of a condition on numbers that the motion does not change.
pub fn constant_condition(span: Span) -> Diagnostic {
    Diagnostic::error("the stop condition never changes", span, "nothing moves in it")
        .help("compare coordinates, points, their rates, outputs or the time `t`")
}
