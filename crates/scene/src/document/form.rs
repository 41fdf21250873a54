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
            findings.push(
                value_error(source, &span)
                    .unwrap_or_else(|| Diagnostic::error(message, span, "not valid TOML here").help(HELP)),
            );
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

/// An error about a value that is not TOML, but whose meaning is clear: a number with a unit, a formula, or a number
/// with a decimal comma.
fn value_error(source: &str, at: &Span) -> Option<Diagnostic> {
    let line = source[..at.start].rfind('\n').map_or(0, |end| end + 1);
    let begin = line + source[line..at.start].rfind('=')? + 1;
    let begin = begin + source[begin..].find(|c: char| c != ' ')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let value = &source[begin..];
    let value = &value[..value.find(['}', ']', '\n', '#']).unwrap_or(value.len())];
    let mut parts = value.split(',');
    let first = parts.next()?.trim_end();
    if let Some(decimals) = parts.next().map(str::trim_end)
        && is_number(first.trim_start_matches('-'))
        && is_number(decimals)
    {
        let span = begin..begin + first.len() + 1 + decimals.len();
        let error = Diagnostic::error("a decimal has a point, not a comma", span, "two values");
        return Some(error.help(format!("write `{first}.{decimals}`")));
    }
    let is_bare = first.starts_with(|c: char| c.is_alphanumeric() || matches!(c, '-' | '('));
    let span = begin..begin + first.len();
    if !is_bare || !span.contains(&at.start) {
        return None;
    }
    let error = Diagnostic::error("a value other than a number needs quotes", span, "without quotes");
    Some(error.help(format!("write `'{first}'`")))
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
