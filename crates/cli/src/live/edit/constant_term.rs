//! The constant at the beginning of a formula.

use qrm_scene::unit::Unit;

use super::number::rounded;

/// Adds to the constant term of a formula. A formula without one gets a new term: one result for each of the units.
pub(super) fn with_change(formula: &str, change: f64, units: [&str; 2], resolution: f64) -> Vec<String> {
    let written = |unit: &str, number: f64| {
        let factor = Unit::parse(unit).map_or(1.0, |unit| unit.factor());
        let number = rounded(number + change / factor, resolution / factor);
        format!("{number} {unit}").trim_end().to_owned()
    };
    match constant(formula) {
        Some((number, unit, rest)) => vec![format!("{} {rest}", written(unit, number))],
        None => {
            let (sign, rest) =
                formula.trim().strip_prefix('-').map_or(('+', formula.trim()), |rest| ('-', rest.trim()));
            units.map(|unit| format!("{} {sign} {rest}", written(unit, 0.0))).into()
        }
    }
}

/// The constant at the beginning of a sum, its unit, and the rest of the sum.
pub(super) fn constant(formula: &str) -> Option<(f64, &str, &str)> {
    let formula = formula.trim();
    let end = formula.find(|c: char| !matches!(c, '0'..='9' | '.' | '-')).unwrap_or(formula.len());
    let (number, rest) = (formula[..end].parse().ok()?, formula[end..].trim_start());
    let end = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len());
    let (unit, rest) = (&rest[..end], rest[end..].trim_start());
    let is_sum = rest.is_empty() || rest.starts_with(['+', '-']);
    (is_sum && (unit.is_empty() || Unit::parse(unit).is_some())).then_some((number, unit, rest))
}
