//! Characters that a scene cannot contain.

use crate::diagnostic::{Diagnostic, Span};

/// Finds characters that are refused anywhere in a file, even in comments: the generated code contains the whole text.
pub(super) fn findings(source: &str) -> Vec<Diagnostic> {
    let refused = source.char_indices().filter(|(_, c)| !c.is_control() && is_refused(*c));
    refused.map(|(at, character)| refusal(character, at..at + character.len_utf8())).collect()
}

/// Whether a character is a control character, changes the direction of the text, or is not a Unicode character.
pub(super) fn is_refused(character: char) -> bool {
    let turns =
        matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || character.is_control() || matches!(character, '\u{fffe}' | '\u{ffff}')
}

/// Creates the report about a character.
pub(super) fn refusal(character: char, span: Span) -> Diagnostic {
    let what = if character.is_control() { "control character" } else { "invisible character" };
    let title = format!("{what} U+{:04X}", u32::from(character));
    Diagnostic::error(title, span, "cannot be part of a scene").help("take it out, or write it as a word")
}
