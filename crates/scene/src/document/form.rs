//! Errors of the TOML parser, without those that only follow from earlier ones.

use std::collections::HashMap;
use std::iter::once;

use toml::de::{DeTable, Error};

use crate::diagnostic::{Diagnostic, Span};

/// Findings for the errors of a TOML parser that goes on after each of them.
pub(super) fn findings(source: &str, errors: &[Error]) -> Vec<Diagnostic> {
    let mut findings: Vec<Diagnostic> = Vec::new();
    let mut lines = Lines::new(source);
    for error in errors {
        let Some(span) = error.span() else {
            findings.push(Diagnostic::whole_file(error.message()).help(HELP));
            continue;
        };
        if error.message() == "duplicate key" {
            findings.push(written_twice(source, span));
        } else if let Some(message) = lines.message(error.message(), span.start) {
            findings.push(Diagnostic::error(message, span, "not valid TOML here").help(HELP));
        }
    }
    findings
}

const HELP: &str = "look here and at the end of the line above for a quote, comma or bracket too few or too many";

fn written_twice(source: &str, span: Span) -> Diagnostic {
    let key = source.get(span.clone()).unwrap_or_default();
    Diagnostic::error(format!("`{key}` is written twice"), span, "already written above")
        .help("keep one of the two, or choose another name")
}

/// The lines that the parser stumbles over. After a missing bracket these are sound lines too, and each more than once:
/// of later errors those count that a line has by itself, and of one line the first.
struct Lines<'s> {
    source: &'s str,
    starts: Vec<usize>,
    /// The errors that a line has by itself; none once one of them counts.
    own: HashMap<usize, Vec<Error>>,
}

impl<'s> Lines<'s> {
    fn new(source: &'s str) -> Self {
        let ends = source.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self { source, starts: once(0).chain(ends.map(|(end, _)| end + 1)).collect(), own: HashMap::new() }
    }

    /// The message for an error at this place; `None` if the error does not count.
    fn message(&mut self, message: &str, at: usize) -> Option<String> {
        let is_first = self.own.is_empty();
        let line = self.starts.partition_point(|start| *start <= at);
        let start = self.starts[line - 1];
        let end = self.starts.get(line).copied().unwrap_or(self.source.len());
        let own = self.own.entry(line).or_insert_with(|| errors_of_line(&self.source[start..end]));
        let place = own.iter().position(|error| error.span().is_some_and(|span| span.start == at - start));
        let message = if is_first { message.to_owned() } else { own[place?].message().to_owned() };
        own.clear();
        Some(message)
    }
}

/// The errors of a line that is read by itself.
fn errors_of_line(line: &str) -> Vec<Error> {
    DeTable::parse_recoverable(line.trim_end()).1
}
