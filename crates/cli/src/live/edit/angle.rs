//! Angles in the text of a scene.

use super::number::rounded;

/// The smallest difference of angles in degrees.
const DEGREES: f64 = 0.01;

/// An angle as text in degrees.
pub(super) fn degrees(angle: f64) -> String {
    format!("{} deg", rounded(angle.to_degrees(), DEGREES))
}

/// A formula of time with its constant changed. Where it has none, one in degrees and one in bare radians are offered.
pub(super) fn with_change(formula: &str, change: f64) -> Vec<String> {
    let written = |unit: &str, number: f64| match unit {
        "deg" => format!("{} deg", rounded(number + change.to_degrees(), DEGREES)),
        "" => format!("{}", rounded(number + change, 1e-4)),
        unit => format!("{} {unit}", rounded(number + change, 1e-4)),
    };
    match constant(formula) {
        Some((number, unit, rest)) => vec![format!("{} {rest}", written(unit, number))],
        None => {
            let (sign, rest) =
                formula.trim().strip_prefix('-').map_or(('+', formula.trim()), |rest| ('-', rest.trim()));
            ["deg", ""].map(|unit| format!("{} {sign} {rest}", written(unit, 0.0))).into()
        }
    }
}

/// The constant at the beginning of a sum, its unit, and the rest of the sum.
pub(super) fn constant(formula: &str) -> Option<(f64, &str, &str)> {
    let formula = formula.trim();
    let end = formula.find(|c: char| !matches!(c, '0'..='9' | '.' | '-')).unwrap_or(formula.len());
    let (number, rest) = (formula[..end].parse().ok()?, formula[end..].trim_start());
    let (unit, rest) = ["deg", "rad", ""].into_iter().find_map(|unit| Some((unit, rest.strip_prefix(unit)?)))?;
    let rest = rest.trim_start();
    (rest.is_empty() || rest.starts_with(['+', '-'])).then_some((number, unit, rest))
}
