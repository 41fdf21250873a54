//! Units in terms of SI base units, so that an importer can convert them.

/// The exponents of kg, m, s and rad, and the conversion factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BaseUnit {
    pub(super) exponents: [i32; 4],
    pub(super) factor: f64,
}

/// The names of the exponents.
pub(super) const NAMES: [&str; 4] = ["kg", "m", "s", "rad"];

/// The known units by name.
const KNOWN: [(&str, [i32; 4], f64); 22] = [
    ("kg", [1, 0, 0, 0], 1.0),
    ("g", [1, 0, 0, 0], 1e-3),
    ("t", [1, 0, 0, 0], 1e3),
    ("m", [0, 1, 0, 0], 1.0),
    ("mm", [0, 1, 0, 0], 1e-3),
    ("cm", [0, 1, 0, 0], 1e-2),
    ("km", [0, 1, 0, 0], 1e3),
    ("s", [0, 0, 1, 0], 1.0),
    ("ms", [0, 0, 1, 0], 1e-3),
    ("min", [0, 0, 1, 0], 60.0),
    ("h", [0, 0, 1, 0], 3600.0),
    ("rad", [0, 0, 0, 1], 1.0),
    ("deg", [0, 0, 0, 1], std::f64::consts::PI / 180.0),
    ("rev", [0, 0, 0, 1], 2.0 * std::f64::consts::PI),
    ("Hz", [0, 0, -1, 0], 1.0),
    ("N", [1, 1, -2, 0], 1.0),
    ("kN", [1, 1, -2, 0], 1e3),
    ("J", [1, 2, -2, 0], 1.0),
    ("kJ", [1, 2, -2, 0], 1e3),
    ("W", [1, 2, -3, 0], 1.0),
    ("kW", [1, 2, -3, 0], 1e3),
    ("Pa", [1, -1, -2, 0], 1.0),
];

/// Reads a unit such as `kg m^2`, `N s/m` or `(m/s)/s`; `None` if a part of it is unknown.
pub(super) fn base_unit(text: &str) -> Option<BaseUnit> {
    let mut unit = BaseUnit { exponents: [0; 4], factor: 1.0 };
    // Everything after a slash is in the denominator, up to the end of its parentheses.
    let (above, below) = split(text);
    multiply(&mut unit, above, 1)?;
    below.into_iter().try_for_each(|part| multiply(&mut unit, part, -1))?;
    Some(unit)
}

/// The text before the first slash outside of parentheses, and the texts between the others.
fn split(text: &str) -> (&str, Vec<&str>) {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, character) in text.char_indices() {
        match character {
            '(' => depth += 1,
            ')' => depth -= 1,
            '/' if depth == 0 => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    (parts[0], parts[1..].to_vec())
}

fn multiply(unit: &mut BaseUnit, text: &str, sign: i32) -> Option<()> {
    let text = text.trim();
    if let Some(inner) = text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) {
        let inner = base_unit(inner)?;
        for (exponent, by) in unit.exponents.iter_mut().zip(inner.exponents) {
            *exponent += sign * by;
        }
        unit.factor *= inner.factor.powi(sign);
        return Some(());
    }
    for factor in text.split([' ', '*']).filter(|factor| !factor.is_empty() && *factor != "1") {
        let (name, power) = factor.split_once('^').unwrap_or((factor, "1"));
        let power = sign * power.parse::<i32>().ok()?;
        let (_, exponents, scale) = KNOWN.iter().find(|(known, ..)| *known == name)?;
        for (exponent, by) in unit.exponents.iter_mut().zip(exponents) {
            *exponent += power * by;
        }
        unit.factor *= scale.powi(power);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_taken_apart() {
        let is = |text: &str, exponents: [i32; 4], factor: f64| {
            assert_eq!(base_unit(text), Some(BaseUnit { exponents, factor }), "{text}");
        };
        is("kg m^2", [1, 2, 0, 0], 1.0);
        is("N s/m", [1, 0, -1, 0], 1.0);
        is("N m", [1, 2, -2, 0], 1.0);
        is("rad/s^2", [0, 0, -2, 1], 1.0);
        is("(m/s)/s^2", [0, 1, -3, 0], 1.0);
        is("N m/rad/s", [1, 2, -3, -1], 1.0);
        is("N/mm", [1, 0, -2, 0], 1e3);
        is("1/s", [0, 0, -1, 0], 1.0);
        assert_eq!(base_unit("furlong"), None);
        assert_eq!(base_unit("m^x"), None);
    }
}
