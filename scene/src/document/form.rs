//! What the TOML parser finds wrong, without the errors that only follow from earlier ones.

use toml::de::{DeTable, Error};

use crate::diagnostic::{Diagnostic, Span};

/// Findings for the errors of a TOML parser that goes on after each of them.
pub(super) fn findings(source: &str, errors: &[Error]) -> Vec<Diagnostic> {
    let mut findings: Vec<Diagnostic> = Vec::new();
    let mut lines: Vec<Span> = Vec::new();
    for error in errors {
        let Some(span) = error.span() else {
            findings.push(Diagnostic::whole_file(error.message()).help(HELP));
            continue;
        };
        let line = line_around(source, span.start);
        if error.message() == "duplicate key" {
            findings.push(written_twice(source, span));
            continue;
        }
        // After a missing bracket the parser stumbles over sound lines, and over each more than once: later errors
        // count if their line has them by itself.
        let message = match lines.is_empty() {
            true => Some(error.message().to_owned()),
            false if lines.contains(&line) => None,
            false => error_of_line(&source[line.clone()], span.start - line.start),
        };
        if let Some(message) = message {
            findings.push(Diagnostic::error(message, span, "not valid TOML here").help(HELP));
            lines.push(line);
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

fn line_around(source: &str, at: usize) -> Span {
    let bytes = source.as_bytes();
    let at = at.min(bytes.len());
    let start = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |end| end + 1);
    let end = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |length| at + length);
    start..end
}

/// What is wrong at a place of a line that is read by itself.
fn error_of_line(line: &str, at: usize) -> Option<String> {
    let (_, errors) = DeTable::parse_recoverable(line.trim_end());
    let here = errors.iter().find(|error| error.span().is_some_and(|span| span.start == at))?;
    Some(here.message().to_owned())
}
