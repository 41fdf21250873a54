//! The locations of a TOML value's characters in the file: strings may contain escapes, numbers underscores.

use crate::diagnostic::Span;

/// The file offset of each byte of a value's text, and one more for the end.
pub(super) struct Places(Vec<usize>);

impl Places {
    /// Creates the offsets of a string with value `text`, written as `raw` with its quotes, at byte `start` of the
    /// file.
    pub(super) fn from_string(raw: &str, start: usize, text: &str) -> Self {
        let bytes = raw.as_bytes();
        let mut at = 1;
        if raw.starts_with("'''") || raw.starts_with("\"\"\"") {
            // A line end directly after three quotes belongs to them.
            at = ["\r\n", "\n"].iter().find(|end| raw[3..].starts_with(**end)).map_or(3, |end| 3 + end.len());
        }
        let mut places = Vec::with_capacity(text.len() + 1);
        for character in text.chars() {
            let mut length = character.len_utf8();
            if bytes[0] == b'"' {
                at = after_continued_lines(bytes, at);
                if bytes.get(at) == Some(&b'\\') {
                    length = match bytes.get(at + 1) {
                        Some(b'x') => 4,
                        Some(b'u') => 6,
                        Some(b'U') => 10,
                        _ => 2,
                    };
                }
            }
            if character == '\n' && raw.get(at..at + 2) == Some("\r\n") {
                at += 1;
            }
            places.extend((0..character.len_utf8()).map(|i| start + at + i));
            at += length;
        }
        places.push(start + at);
        Self(places)
    }

    /// Returns a number's text without underscores, and its offsets; the number is written as `raw`.
    pub(super) fn from_number(raw: &str, start: usize) -> (String, Self) {
        let kept = raw.char_indices().filter(|(_, character)| *character != '_');
        let (mut places, text): (Vec<usize>, String) = kept.map(|(at, character)| (start + at, character)).unzip();
        places.push(start + raw.len());
        (text, Self(places))
    }

    /// The location of a part of the text in the file.
    pub(super) fn span(&self, part: &Span) -> Span {
        let place = |at: usize| self.0[at.min(self.0.len() - 1)];
        let start = place(part.start);
        start..if part.is_empty() { start } else { place(part.end - 1) + 1 }
    }

    /// The location of the whole text in the file.
    pub(super) fn whole(&self) -> Span {
        self.span(&(0..self.0.len() - 1))
    }
}

/// Skips backslashes at ends of lines and the whitespace after them.
fn after_continued_lines(bytes: &[u8], mut at: usize) -> usize {
    let is_blank = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_whitespace);
    while bytes.get(at) == Some(&b'\\') && is_blank(at + 1) {
        at += 1;
        while is_blank(at) {
            at += 1;
        }
    }
    at
}
