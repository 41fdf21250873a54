//! Numbers as people read them.

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

/// A run time, with three digits at least.
pub(crate) fn milliseconds(seconds: f64) -> String {
    if seconds < 1e-5 { format!("{:.3} us", seconds * 1e6) } else { format!("{:.3} ms", seconds * 1e3) }
}

/// A number in the digits that read back as the same; nothing where it is not finite.
pub(crate) fn full(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

/// A number in seven decimals, or in six digits behind the first where these would not show it.
pub(crate) fn decimals(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) { format!("{value:.7}") } else { format!("{value:.6e}") }
}

/// A number in eight digits or so, however small it is.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e7).contains(&value.abs()) {
        // Adding zero makes -0 the same as 0.
        format!("{:.7}", value + 0.0)
    } else {
        format!("{value:.7e}")
    }
}

/// An angle in degrees, a length as it is.
pub(crate) fn quantity(value: f64, unit: &str) -> String {
    if unit == "rad" {
        let text = format!("{:.4} deg", value.to_degrees());
        text.strip_prefix('-').filter(|size| *size == "0.0000 deg").map_or(text.clone(), str::to_owned)
    } else {
        format!("{value:.7} {unit}").trim_end().to_owned()
    }
}

/// A method and how its steps are chosen.
pub(crate) fn method(name: &str, tolerance: Option<f64>, step: f64) -> String {
    let name = name.to_uppercase();
    match tolerance {
        None => format!("{name}, step {}", seconds(step)),
        Some(tolerance) => format!("{name}, tolerance {tolerance:e}, rows every {}", seconds(step)),
    }
}

/// A text in lines of a width.
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

/// The beginning of a text.
pub(crate) fn shortened(text: &str, width: usize) -> String {
    match text.char_indices().nth(width) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
