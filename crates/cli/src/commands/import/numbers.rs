//! Numbers of models: read from text, and written in the shortest form that reads back the same.

/// Reads a finite number.
pub(super) fn finite(text: &str) -> Option<f64> {
    // `str::parse` also takes `inf` and `nan`.
    let is_number = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
    text.parse::<f64>().ok().filter(|value| is_number && value.is_finite())
}

/// Writes a number for TOML and for formulae.
pub(super) fn shortest(value: f64) -> String {
    let value = tidy(value);
    if value == 0.0 {
        "0".to_owned()
    } else if value.fract() == 0.0 && value.abs() < 1e15 {
        format!("{value:.0}")
    } else {
        format!("{value:?}")
    }
}

/// Writes a pair of numbers.
pub(super) fn pair([x, y]: [f64; 2]) -> String {
    format!("[{}, {}]", shortest(x), shortest(y))
}

/// Writes a number that follows a sign or `*` in a formula.
pub(super) fn factor(value: f64) -> String {
    let text = shortest(value);
    if text.starts_with('-') { format!("({text})") } else { text }
}

/// Writes a number as a further term of a formula, with its sign. Zero is left out.
pub(super) fn signed_term(value: f64) -> String {
    match shortest(value).strip_prefix('-') {
        Some(positive) => format!(" - {positive}"),
        None if tidy(value) == 0.0 => String::new(),
        None => format!(" + {}", shortest(value)),
    }
}

/// Removes whole turns: the angle is between -pi and pi.
pub(super) fn wrap_angle(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    if angle.abs() <= turn / 2.0 { angle } else { angle - turn * (angle / turn).round() }
}

/// Removes the rounding of a difference. `size` is that of its numbers, and at most 10 digits remain.
pub(super) fn snap_rounding(value: f64, size: f64) -> f64 {
    let rest = 4.0 * f64::EPSILON * size;
    if value.abs() <= rest {
        return 0.0;
    }
    // The digits that the rounding leaves.
    let digits = (value.abs() / rest).log10().clamp(1.0, 14.0) as usize;
    let near = format!("{value:.*e}", digits - 1);
    let count =
        near.split('e').next().unwrap_or_default().trim_end_matches('0').chars().filter(char::is_ascii_digit).count();
    match near.parse::<f64>() {
        Ok(rounded) if count <= 10 && (rounded - value).abs() <= rest => rounded,
        _ => value,
    }
}

/// Removes the rounding of a sum such as 0.1 + 0.2, where at most 12 digits remain.
fn tidy(value: f64) -> f64 {
    let near = format!("{value:.14e}");
    let digits = near.split('e').next().unwrap_or_default().trim_end_matches('0').chars().filter(char::is_ascii_digit);
    match near.parse::<f64>() {
        Ok(rounded) if digits.count() <= 12 && (rounded - value).abs() <= 4.0 * f64::EPSILON * value.abs() => rounded,
        _ => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_the_same() {
        for value in [0.1, 1e-7, 1.0 / 3.0, -2.5e20, 123456.789, 0.013466666666667, 5e-324, f64::MAX] {
            assert_eq!(finite(&shortest(value)), Some(value), "{value}");
        }
        assert_eq!(shortest(0.1 + 0.2), "0.3");
        assert_eq!(shortest(-0.0), "0");
        assert_eq!(shortest(3.0), "3");
    }

    #[test]
    fn what_is_not_a_finite_number_is_none() {
        for text in ["", "inf", "nan", "1e400", "-inf", "+NaN", "1,5", "0x1", "1 2", "infinity"] {
            assert_eq!(finite(text), None, "{text}");
        }
        assert_eq!(finite("-1.5e-3"), Some(-0.0015));
    }

    #[test]
    fn differences_lose_their_rounding() {
        assert_eq!(snap_rounding(14.8 - 13.7, 14.8), 1.1);
        assert_eq!(snap_rounding(2.7e-17, 0.4), 0.0);
        assert_eq!(snap_rounding(1.0 / 3.0, 1.0), 1.0 / 3.0);
        assert_eq!(snap_rounding(-0.25, 1.0), -0.25);
    }

    #[test]
    fn terms_carry_their_sign() {
        assert_eq!(signed_term(-0.5), " - 0.5");
        assert_eq!(signed_term(0.0), "");
        assert_eq!(factor(-2.0), "(-2)");
        assert!((wrap_angle(7.0) - (7.0 - std::f64::consts::TAU)).abs() < 1e-15);
    }
}
