//! Formatting of numbers and names for people.

use qrm_core::Description;

/// The name of a scene, with its documentation if it has one.
pub(crate) fn heading(scene: &Description) -> String {
    if scene.doc.is_empty() { scene.name.to_owned() } else { format!("{}: {}", scene.name, scene.doc) }
}

/// A number of things: `1 step`, `2 steps`.
pub(crate) fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A time without the rounding errors of its last digits.
pub(crate) fn seconds(t: f64) -> String {
    let rounded: f64 = format!("{t:.13e}").parse().unwrap_or(t);
    let digits = format!("{rounded:?}");
    format!("{} s", digits.strip_suffix(".0").unwrap_or(&digits))
}

/// A run time with at least three digits.
pub(crate) fn milliseconds(seconds: f64) -> String {
    if seconds < 1e-5 { format!("{:.3} us", seconds * 1e6) } else { format!("{:.3} ms", seconds * 1e3) }
}

/// A number in the shortest decimal that reads back exactly; empty if it is not finite.
pub(crate) fn full(value: f64) -> String {
    let mut text = String::new();
    push_full(&mut text, value);
    text
}

/// Appends a number as [`full`] writes it.
pub(crate) fn push_full(text: &mut String, value: f64) {
    // `zmij` takes a fifth of the time of the standard library. Beyond these numbers it has other exponents; of two
    // decimals at the same distance it may write the other one.
    if value == 0.0 || (1e-4..1e16).contains(&value.abs()) {
        text.push_str(zmij::Buffer::new().format_finite(value));
    } else if value.is_finite() {
        text.extend([format!("{value:?}")]);
    }
}

/// A number with seven decimals, or with six digits after the first if seven decimals are too few.
pub(crate) fn decimals(value: f64) -> String {
    // Adding zero turns -0 into 0.
    let value = value + 0.0;
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) { format!("{value:.7}") } else { format!("{value:.6e}") }
}

/// The largest number of digits of a number with an error: those of a double.
const MOST_DIGITS: i32 = 16;

/// A number in its known digits, with the error of the last one in parentheses, rounded up: `-24359.2177(2)`.
pub(crate) fn with_error(value: f64, error: f64) -> String {
    if !(error > 0.0) || !error.is_finite() || !value.is_finite() {
        return decimals(value);
    }
    let place = |x: f64| format!("{x:e}").split_once('e').and_then(|(_, place)| place.parse::<i32>().ok()).unwrap_or(0);
    let mut last = place(error);
    let leading = if value == 0.0 { last } else { place(value).max(last) };
    last = last.max(leading - MOST_DIGITS + 1);
    // One unit of the last digit of the error.
    let unit = |last: i32| format!("1e{last}").parse::<f64>().unwrap_or(1.0);
    let mut digit = (error / unit(last) * (1.0 - 1e-9)).ceil().max(1.0);
    if digit >= 10.0 {
        (digit, last) = (1.0, last + 1);
    }
    let leading = leading.max(last);
    // No sign if no digit is known.
    let value = if value.abs() < 0.5 * unit(last) { 0.0 } else { value };
    let behind = usize::try_from(leading - last).unwrap_or(0);
    if (-4..6).contains(&leading) {
        if last <= 0 {
            return format!("{value:.0$}({digit})", usize::try_from(-last).unwrap_or(0));
        }
        let rounded = (value / unit(last)).round() * unit(last);
        return format!("{rounded:.0}({:.0})", digit * unit(last));
    }
    let mantissa = value / unit(leading);
    format!("{mantissa:.behind$}({digit})e{leading}")
}

/// A number with about eight digits, of any size.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e7).contains(&value.abs()) {
        // Adding zero turns -0 into 0.
        format!("{:.7}", value + 0.0)
    } else {
        format!("{value:.7e}")
    }
}

/// The coordinates of a position.
pub(crate) fn position(description: &Description, q: &[f64]) -> String {
    let coordinates = description.coordinates.iter().zip(q);
    coordinates.map(|(c, q)| format!("{} = {}", c.name, quantity(*q, c.unit))).collect::<Vec<_>>().join(", ")
}

/// The unit of the generalized force on a coordinate.
pub(crate) fn unit_of_force(coordinate: &str) -> String {
    match coordinate {
        "m" => "N".to_owned(),
        "rad" => "N m".to_owned(),
        other => format!("J/{other}"),
    }
}

/// An angle in degrees, or a length unchanged.
pub(crate) fn quantity(value: f64, unit: &str) -> String {
    if unit == "rad" {
        let text = format!("{:.4} deg", value.to_degrees());
        text.strip_prefix('-').filter(|size| *size == "0.0000 deg").map_or(text.clone(), str::to_owned)
    } else {
        format!("{value:.7} {unit}").trim_end().to_owned()
    }
}

/// A method with its tolerance or step.
pub(crate) fn method(name: &str, tolerance: Option<f64>, step: f64) -> String {
    let name = name.to_uppercase();
    match tolerance {
        None => format!("{name}, step {}", seconds(step)),
        Some(tolerance) => format!("{name}, tolerance {tolerance:e}, rows every {}", seconds(step)),
    }
}

/// A text wrapped to a width.
pub(crate) fn wrapped(text: &str, width: usize) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last().map_or(0, String::len);
        if line > 0 && line + 1 + word.len() > width {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(if line.is_empty() { "" } else { " " });
            line.push_str(word);
        }
    }
    lines.join("\n")
}

/// The beginning of a text, shortened to a width.
pub(crate) fn shortened(text: &str, width: usize) -> String {
    match text.char_indices().nth(width) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngCore, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::{full, with_error};

    #[test]
    fn numbers_read_back_and_are_as_short_as_those_of_the_standard_library() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let edges = [0.0, -0.0, 1.0, 1e15, 1e16, 1e17, 1.5e300, 9.999e-5, 1e-4, -1e-5, 5e-324, f64::MAX, f64::INFINITY];
        let any = (0..100_000).map(|_| f64::from_bits(random.next_u64())).collect::<Vec<_>>();
        // A mantissa of few bits or many, for numbers of usual size.
        let usual = any.iter().map(|any| {
            let bits = any.to_bits();
            let mantissa = bits >> 12 & u64::MAX << (bits % 52);
            f64::from_bits((1009 + bits % 67) << 52 | mantissa)
        });
        let all = edges.into_iter().chain(any.iter().copied()).chain(usual);
        for value in all {
            let expected = if value.is_finite() { format!("{value:?}") } else { String::new() };
            let text = full(value);
            assert_eq!((text.len(), text.contains('e')), (expected.len(), expected.contains('e')), "{text}");
            assert!(
                text.is_empty() || text.parse::<f64>().is_ok_and(|read| read.to_bits() == value.to_bits()),
                "{text}"
            );
        }
    }

    #[test]
    fn known_digits_end_with_the_error() {
        for (value, error, text) in [
            (-24_359.217_679_2, 1.6e-4, "-24359.2177(2)"),
            (0.933_333_3, 2e-7, "0.9333333(2)"),
            (0.933_333_3, 9.6e-8, "0.9333333(1)"),
            (12_345.678, 31.0, "12350(40)"),
            (1.5, 0.2, "1.5(2)"),
            (1.234_567_8e-7, 3.2e-13, "1.234568(4)e-7"),
            (6.022e23, 1e20, "6.022(1)e23"),
            (0.0, 1e-3, "0.000(1)"),
            (1e-9, 3e-7, "0(3)e-7"),
            (-0.001, 0.2, "0.0(2)"),
            (-1e-17, 7e-14, "0(7)e-14"),
            (1.0, 1e-30, "1.000000000000000(1)"),
            (1.0, 0.0, "1.0000000"),
            (2.5, f64::NAN, "2.5000000"),
        ] {
            assert_eq!(with_error(value, error), text, "{value} within {error}");
        }
    }
}
