//! The text of an open file.

use std::ops::Range;

use serde_json::{Value, json};

/// The text of an open file, with the begin of each line.
pub(super) struct Text {
    pub(super) source: String,
    lines: Vec<usize>,
}

impl Text {
    pub(super) fn new(source: String) -> Self {
        let lines = std::iter::once(0).chain(source.match_indices('\n').map(|(i, _)| i + 1)).collect();
        Self { source, lines }
    }

    /// The byte at a position of the protocol: `{ line, character }`.
    pub(super) fn byte(&self, position: &Value) -> Option<usize> {
        let [line, character] = ["line", "character"].map(|key| position[key].as_u64().map(|n| n as usize));
        let begin = *self.lines.get(line?)?;
        let line = self.source[begin..].lines().next().unwrap_or_default();
        let mut left = character?;
        for (i, c) in line.char_indices() {
            if left < c.len_utf16() {
                return Some(begin + i);
            }
            left -= c.len_utf16();
        }
        Some(begin + line.len())
    }

    /// The position of a byte.
    pub(super) fn position(&self, byte: usize) -> Value {
        let byte = self.boundary(byte);
        let line = self.lines.partition_point(|begin| *begin <= byte) - 1;
        let character = self.source[self.lines[line]..byte].encode_utf16().count();
        json!({ "line": line, "character": character })
    }

    /// A range of bytes as one of positions.
    pub(super) fn range(&self, span: &Range<usize>) -> Value {
        json!({ "start": self.position(span.start), "end": self.position(span.end) })
    }

    /// The begin of the line of a byte.
    pub(super) fn line_begin(&self, byte: usize) -> usize {
        self.source[..self.boundary(byte)].rfind('\n').map_or(0, |i| i + 1)
    }

    /// The last boundary of characters up to a byte.
    fn boundary(&self, byte: usize) -> usize {
        let mut byte = byte.min(self.source.len());
        while !self.source.is_char_boundary(byte) {
            byte -= 1;
        }
        byte
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_utf16() {
        let text = Text::new("a = 1\n# 𝑥 é\nb".to_owned());
        for (byte, line, character) in [(0, 0, 0), (4, 0, 4), (6, 1, 0), (8, 1, 2), (12, 1, 4), (13, 1, 5), (16, 2, 0)]
        {
            let position = json!({ "line": line, "character": character });
            assert_eq!((text.position(byte), text.byte(&position)), (position.clone(), Some(byte)));
        }
        assert_eq!(text.byte(&json!({ "line": 0, "character": 99 })), Some(5));
        assert_eq!(text.byte(&json!({ "line": 9, "character": 0 })), None);
    }
}
