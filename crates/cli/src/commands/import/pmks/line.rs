//! A line of a mechanism: a joint of links at a place.

use std::ops::Range;

use super::super::numbers::finite;
use super::super::source::Source;
use crate::error::Error;

/// A line of the text: a joint of links at a place.
pub(super) struct Line {
    pub(super) links: Vec<(String, Range<usize>)>,
    pub(super) kind: String,
    pub(super) place: [f64; 2],
    /// The direction of a slider, in radians.
    pub(super) direction: f64,
    pub(super) is_traced: bool,
    pub(super) is_input: bool,
    pub(super) span: Range<usize>,
}

impl Line {
    pub(super) fn read(source: &Source, line: &str, offset: usize) -> Result<Self, Error> {
        let mut tokens = tokens(line, offset);
        let lead = line.len() - line.trim_start().len();
        let span = offset + lead..offset + lead + line.trim().len();
        let example = "write the links, the type (R, P, RP or G) and the place of a joint, as `ground crank R 0 0`";
        let kind = kind_at(&tokens).filter(|at| *at > 0).ok_or_else(|| {
            source.error("this line is not a joint", span.clone(), "no link with a type of joint behind it", example)
        })?;
        let mut rest = tokens.split_off(kind);
        let kind = rest.remove(0).0.to_ascii_uppercase();
        let mut numbers = Vec::new();
        while let Some((word, at)) = rest.first() {
            let is_number = word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '.'));
            match finite(word) {
                Some(value) if value.abs() < 1e100 => numbers.push(value),
                _ if is_number => {
                    return Err(source.error("this number cannot be read", at.clone(), "not a finite number", example));
                }
                _ => break,
            }
            rest.remove(0);
        }
        let [x, y] = match numbers[..] {
            [x, y, ..] => [x, y],
            _ => return Err(source.error("this joint has no place", span, "two numbers are missing", example)),
        };
        let flag = |at: usize| match rest.first() {
            Some((flags, _)) if rest.len() == 1 => flags.chars().nth(at).is_some_and(|c| matches!(c, 't' | '+')),
            _ => rest.get(at).is_some_and(|(word, _)| word.eq_ignore_ascii_case("true")),
        };
        let (is_traced, is_input) = (flag(0), flag(3));
        let direction = numbers.get(2).copied().unwrap_or(0.0).to_radians();
        Ok(Self { links: tokens, kind, place: [x, y], direction, is_traced, is_input, span })
    }
}

/// Splits a line into tokens, with their places.
pub(super) fn tokens(line: &str, offset: usize) -> Vec<(String, Range<usize>)> {
    let mut found = Vec::new();
    let mut begin = 0;
    let is_space = |rest: &str| rest.starts_with("%20") || rest.starts_with("%2C") || rest.starts_with("%2c");
    let mut at = 0;
    while at <= line.len() {
        let rest = &line[at..];
        let (is_end, step) = match rest.chars().next() {
            None => (true, 1),
            Some('+' | ',' | ' ' | '\t' | '\r') => (true, 1),
            Some('%') if is_space(rest) => (true, 3),
            Some(c) => (false, c.len_utf8()),
        };
        if is_end {
            if at > begin {
                found.push((line[begin..at].to_owned(), offset + begin..offset + at));
            }
            begin = at + step;
        }
        at += step;
    }
    found
}

/// The number of the token that is the type of joint: the last one of this kind.
pub(super) fn kind_at(tokens: &[(String, Range<usize>)]) -> Option<usize> {
    tokens.iter().rposition(|(word, _)| ["r", "p", "rp", "g"].contains(&word.to_ascii_lowercase().as_str()))
}
