//! The surroundings of a position: its section, its key and the kind of text around it.

use std::ops::Range;

use super::text::Text;

/// The surroundings of a position.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Place<'t> {
    /// The section: `links`; empty before the first one.
    pub(super) section: &'t str,
    /// The text around the position.
    pub(super) within: Within,
    /// The key of the value around the position; empty outside of values.
    pub(super) key: &'t str,
    /// The keys before the position in the same inline table.
    pub(super) keys: Vec<&'t str>,
}

/// The kind of text around a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Within {
    Comment,
    /// The name of a section, in brackets.
    Header,
    /// A key at the begin of a line.
    LineKey,
    /// A key in an inline table.
    InlineKey,
    /// Text in double quotes.
    Name,
    /// Text in single quotes.
    Formula,
    /// A value without quotes.
    Value,
}

impl Text {
    /// The surroundings of a byte.
    pub(super) fn place(&self, byte: usize) -> Place<'_> {
        let begin = self.line_begin(byte);
        let section = self.source[..begin].lines().rev().find_map(header).unwrap_or_default();
        let line = &self.source[begin..byte];
        if line.trim_start().starts_with('[') && !line.contains('=') {
            return Place { section, within: Within::Header, key: "", keys: Vec::new() };
        }
        let (mut quote, mut keys, mut tables) = (None, vec![Vec::new()], 0_usize);
        let mut word = begin;
        let mut after_equals = false;
        for (i, c) in line.char_indices() {
            let at = begin + i;
            match (quote, c) {
                (Some(open), c) if c == open => quote = None,
                (Some(_), _) => {}
                (None, '"' | '\'') => quote = Some(c),
                (None, '#') => return Place { section, within: Within::Comment, key: "", keys: Vec::new() },
                (None, '=') => {
                    let key = self.source[word..at].trim();
                    keys.last_mut().map(|keys: &mut Vec<&str>| keys.push(key)).unwrap_or_default();
                    (after_equals, word) = (true, at + 1);
                }
                (None, '{') => {
                    tables += 1;
                    keys.push(Vec::new());
                    (after_equals, word) = (false, at + 1);
                }
                (None, '}') => {
                    tables = tables.saturating_sub(1);
                    keys.pop();
                    after_equals = true;
                }
                (None, ',') if tables > 0 && line[..i].matches('[').count() == line[..i].matches(']').count() => {
                    (after_equals, word) = (false, at + 1);
                }
                _ => {}
            }
        }
        let within = match quote {
            Some('"') => Within::Name,
            Some(_) => Within::Formula,
            None if after_equals => Within::Value,
            None if tables > 0 => Within::InlineKey,
            None => Within::LineKey,
        };
        let keys = keys.pop().unwrap_or_default();
        let key = if matches!(within, Within::Name | Within::Formula | Within::Value) {
            keys.last().copied().unwrap_or_default()
        } else {
            ""
        };
        Place { section, within, key, keys }
    }

    /// The word around a byte, with its place; a word may contain letters, digits and `_`.
    pub(super) fn word(&self, byte: usize) -> Range<usize> {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let begin = self.source[..byte]
            .rfind(|c| !is_word(c))
            .map_or(0, |i| i + self.source[i..].chars().next().map_or(1, char::len_utf8));
        let end = self.source[byte..].find(|c| !is_word(c)).map_or(self.source.len(), |i| byte + i);
        begin..end
    }

    /// The identifiers of the text outside comments, descriptions and units.
    pub(super) fn identifiers(&self) -> Vec<Range<usize>> {
        let mut found = Vec::new();
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let mut at = 0;
        while let Some(i) = self.source[at..].find(|c| is_word(c) || c == '#') {
            let begin = at + i;
            if self.source[begin..].starts_with('#') && !self.is_quoted(begin) {
                at = self.source[begin..].find('\n').map_or(self.source.len(), |i| begin + i);
                continue;
            }
            let word = if self.source[begin..].starts_with('#') { begin..begin + 1 } else { self.word(begin) };
            at = word.end;
            let place = self.place(begin);
            let is_text = place.within == Within::Name && ["doc", "unit"].contains(&place.key);
            if !is_text && !self.source[word.clone()].starts_with(|c: char| c.is_ascii_digit() || c == '#') {
                found.push(word);
            }
        }
        found
    }

    /// Whether a byte lies between quotes.
    fn is_quoted(&self, byte: usize) -> bool {
        matches!(self.place(byte).within, Within::Name | Within::Formula)
    }
}

/// The section that a line begins.
fn header(line: &str) -> Option<&str> {
    let name = line.trim_start().strip_prefix('[')?.split(']').next()?;
    let name = name.trim_start_matches('[').split('.').next()?.trim();
    let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    is_name.then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_keys_and_quotes_are_told_apart() {
        let source = "name = \"a\"\n[links]\ncrank = { bar = [\"A\", \"B\"], length = 'L', ma\n[joints] # pins\nA = {";
        let text = Text::new(source.to_owned());
        let at = |part: &str| {
            let place = text.place(source.find(part).expect("the part") + part.len());
            (place.section, place.within, place.key)
        };
        assert_eq!(at("name = \"a"), ("", Within::Name, "name"));
        assert_eq!(at("cra"), ("links", Within::LineKey, ""));
        assert_eq!(at("[\"A"), ("links", Within::Name, "bar"));
        assert_eq!(at("length = 'L"), ("links", Within::Formula, "length"));
        assert_eq!(at("length ="), ("links", Within::Value, "length"));
        assert_eq!(at("', ma"), ("links", Within::InlineKey, ""));
        assert_eq!(at("# pi"), ("links", Within::Header, ""));
        assert_eq!(at("A = {"), ("joints", Within::InlineKey, ""));
        let place = text.place(source.find("', ma").expect("the part") + 5);
        assert_eq!(place.keys, ["bar", "length"]);
        let words: Vec<&str> = text.identifiers().into_iter().map(|word| &source[word]).collect();
        assert_eq!(words, ["name", "a", "links", "crank", "bar", "A", "B", "length", "L", "ma", "joints", "A"]);
    }
}
