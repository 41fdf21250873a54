//! Widths of texts, and truncation.

/// An upper estimate of the width of a text in CSS pixels, since the font is unknown.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let of = |c: char| match c {
        'i' | 'j' | 'l' | '\'' | '\u{202f}' => 0.23,
        ' ' | 'f' | 't' | 'I' | '.' | ',' | ':' | ';' | '/' | '|' | '!' | '[' | ']' => 0.29,
        'r' | '(' | ')' | '-' | '⁻' | '⁰'..='⁹' | '¹' | '²' | '³' => 0.36,
        'c' | 'k' | 's' | 'v' | 'x' | 'y' | 'z' | 'J' => 0.5,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 0.9,
        'A'..='Z' => 0.7,
        _ if c < '\u{2e80}' => 0.57,
        _ => 1.05,
    };
    text.chars().map(of).sum::<f64>() * size * 1.04
}

/// The text, truncated to `most` CSS pixels.
pub(super) fn cut(text: &str, size: f64, most: f64) -> String {
    if width(text, size) <= most {
        return text.to_owned();
    }
    let mut kept = String::new();
    let mut taken = width("…", size);
    for c in text.chars() {
        taken += width(c.encode_utf8(&mut [0; 4]), size);
        if taken > most {
            break;
        }
        kept.push(c);
    }
    kept.trim_end().to_owned() + "…"
}

/// The text without characters that XML forbids; line breaks become spaces.
pub(super) fn clean(text: &str) -> String {
    let of = |c: char| match c {
        '\n' | '\r' | '\t' => ' ',
        _ if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => '\u{fffd}',
        _ => c,
    };
    text.chars().map(of).collect()
}

/// The text, escaped for an attribute or an element.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in clean(text).chars() {
        match c {
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '&' => out += "&amp;",
            '"' => out += "&quot;",
            _ => out.push(c),
        }
    }
    out
}
