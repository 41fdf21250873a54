//! Splits formulae into tokens with locations.

use crate::diagnostic::{Diagnostic, Span};
use crate::expression::Number;

/// The largest number of characters in a number. Numbers are kept exactly; all decimals that doubles can distinguish
/// are shorter.
const NUMBER_LENGTH: usize = 100;

/// A piece of a formula.
#[derive(Clone, Debug, PartialEq)]
pub enum Token {
    /// A decimal number.
    Number(Number),
    /// A name, possibly with a component: `phi2`, `A.x`.
    Name(String),
    /// One of `+ - * / ^ ( ) ,`.
    Symbol(char),
    /// `<=` or `>=`.
    Comparison(Comparison),
}

/// How a condition compares its two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Comparison {
    /// `<=`
    LessOrEqual,
    /// `>=`
    GreaterOrEqual,
}

impl Comparison {
    /// `1` if the condition becomes true when left minus right rises through zero, `-1` if it becomes true when that
    /// falls.
    pub fn sign(self) -> f64 {
        match self {
            Self::GreaterOrEqual => 1.0,
            Self::LessOrEqual => -1.0,
        }
    }
}

/// Splits `text`, which begins at byte `offset` of its file.
///
/// # Errors
/// A character that belongs to no token, or a number outside the range of doubles.
pub fn tokenize(text: &str, offset: usize) -> Result<Vec<(Token, Span)>, Diagnostic> {
    let bytes = text.as_bytes();
    let run = |from: usize, keep: fn(u8) -> bool| {
        bytes[from..].iter().position(|&b| !keep(b)).map_or(bytes.len(), |length| from + length)
    };
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let start = at;
        let token = match byte {
            b' ' | b'\t' | b'\n' | b'\r' => {
                at += 1;
                continue;
            }
            b'0'..=b'9' | b'.' => {
                at = run(at, |b| b.is_ascii_digit() || b == b'.');
                if matches!(bytes.get(at), Some(b'e' | b'E')) {
                    let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
                    if bytes.get(at + 1 + sign).is_some_and(u8::is_ascii_digit) {
                        at = run(at + 1 + sign, |b| b.is_ascii_digit());
                    }
                }
                let span = offset + start..offset + at;
                let decimal = &text[start..at];
                if decimal.matches('.').count() > 1 || decimal.starts_with('.') || decimal.ends_with('.') {
                    return Err(Diagnostic::error(format!("`{decimal}` is not a number"), span, "malformed number")
                        .help("write a decimal like `0.5` or `1.5e-3`, with digits on both sides of the point"));
                }
                if decimal.len() > NUMBER_LENGTH {
                    return Err(Diagnostic::error("number too long", span, format!("{} characters", decimal.len()))
                        .help(format!("write at most {NUMBER_LENGTH}: a double holds 17 digits")));
                }
                let number = Number::parse(decimal).ok_or_else(|| {
                    Diagnostic::error("number out of range", span, "no double-precision number is near this")
                        .help("magnitudes from 5e-324 to 1.7e308 can be represented")
                })?;
                Token::Number(number)
            }
            b'A'..=b'Z' | b'a'..=b'z' | b'_' => {
                let in_name = |b: u8| b.is_ascii_alphanumeric() || b == b'_';
                at = run(at, in_name);
                if bytes.get(at) == Some(&b'.') && bytes.get(at + 1).is_some_and(|&b| in_name(b)) {
                    at = run(at + 1, in_name);
                }
                Token::Name(text[start..at].to_owned())
            }
            _ if text[at..].starts_with('°') => {
                at += '°'.len_utf8();
                Token::Name("°".to_owned())
            }
            b'<' | b'>' => {
                if bytes.get(at + 1) != Some(&b'=') {
                    let sign = char::from(byte);
                    let span = offset + at..offset + at + 1;
                    return Err(Diagnostic::error(format!("`{sign}` is not offered"), span, "unexpected")
                        .help(format!("write `{sign}=`: a condition is met at the moment its two sides are equal")));
                }
                at += 2;
                Token::Comparison(if byte == b'<' { Comparison::LessOrEqual } else { Comparison::GreaterOrEqual })
            }
            b'*' if bytes.get(at + 1) == Some(&b'*') => {
                let span = offset + at..offset + at + 2;
                return Err(Diagnostic::error("`**` is not an operator", span, "unexpected")
                    .help("a power is written with `^`, as in `x^2`"));
            }
            b'=' => {
                let span = offset + at..offset + at + 1;
                return Err(Diagnostic::error("`=` is not an operator", span, "unexpected").help(
                    "conditions compare with `>=` or `<=`; an equation is written as a difference, `left - right`",
                ));
            }
            b'+' | b'-' | b'*' | b'/' | b'^' | b'(' | b')' | b',' => {
                at += 1;
                Token::Symbol(char::from(byte))
            }
            _ => {
                let stray = text[start..].chars().next().unwrap_or(char::REPLACEMENT_CHARACTER);
                let span = offset + start..offset + start + stray.len_utf8();
                return Err(Diagnostic::error(
                    format!("stray character `{}`", stray.escape_debug()),
                    span,
                    "does not belong in a formula",
                )
                .help("a formula is made of numbers, names, `+ - * / ^`, parentheses and function calls"));
            }
        };
        tokens.push((token, offset + start..offset + at));
    }
    Ok(tokens)
}
