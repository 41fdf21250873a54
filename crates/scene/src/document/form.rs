//! Errors of the TOML parser, without consequential ones.

use std::collections::HashMap;
use std::iter::once;

use toml::de::{DeTable, Error};

use crate::diagnostic::{Diagnostic, Span};

/// Converts the errors of a TOML parser that continues after errors.
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

const HELP: &str = "look for a missing or extra quote, comma or bracket here or at the end of the line above";

fn written_twice(source: &str, span: Span) -> Diagnostic {
    let key = source.get(span.clone()).unwrap_or_default();
    Diagnostic::error(format!("`{key}` is written twice"), span, "already written above")
        .help("keep one of the two, or choose another name")
}

/// The lines at which the parser reports errors. After a missing bracket it also reports correct lines, and lines
/// twice. Of the later errors only those count that a line causes when parsed separately, and of each line only the
/// first.
struct Lines<'s> {
    source: &'s str,
    starts: Vec<usize>,
    /// The errors of a line parsed separately; empty once one of them was reported.
    own: HashMap<usize, Vec<Error>>,
}

impl<'s> Lines<'s> {
    fn new(source: &'s str) -> Self {
        let ends = source.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self { source, starts: once(0).chain(ends.map(|(end, _)| end + 1)).collect(), own: HashMap::new() }
    }

    /// The message for an error at this position; `None` if the error is consequential.
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

/// The errors of a line parsed separately.
fn errors_of_line(line: &str) -> Vec<Error> {
    DeTable::parse_recoverable(line.trim_end()).1
}
