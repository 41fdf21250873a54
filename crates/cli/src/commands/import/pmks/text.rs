//! The parts of a text of PMKS: the lines of its first mechanism, and its settings.

use super::super::numbers::finite;

/// Finds the lines of joints, and the place at which they begin.
pub(super) fn mechanism(text: &str) -> (&str, usize) {
    let Some(begin) = text.find("mech=").map(|at| at + "mech=".len()) else { return (text, 0) };
    let rest = &text[begin..];
    // Files have one joint a line behind `mech=`, links all of them in one line.
    let first = rest.split('\n').next().unwrap_or_default();
    let end = if first.contains('|') { first.len() } else { rest.find("mech=").unwrap_or(rest.len()) };
    let end = rest[..end].find('&').unwrap_or(end);
    (&rest[..end], begin)
}

/// Reads a setting, such as the speed in `set=s20|f5`.
pub(super) fn setting(text: &str, letter: char) -> Option<f64> {
    let rest = &text[text.find("set=")? + "set=".len()..];
    let end = rest.find(['&', '\n', '\r', ' ']).unwrap_or(rest.len());
    rest[..end].split('|').find_map(|part| finite(part.strip_prefix(letter)?))
}
