//! Formatting of numbers in a figure.

/// `value` with `digits` significant digits: `8.4913`, `−24123`, `1.2346×10⁻⁹`.
pub(super) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let written = format!("{:.*e}", digits.saturating_sub(1), value);
    let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let last = digits as i32 - 1;
    if (-2..=last).contains(&exponent) {
        rounded(value, (last - exponent).max(0) as usize)
    } else {
        format!("{}×{}", with_minus(mantissa), power_of_ten(exponent))
    }
}

/// `value` with `decimals` decimals.
pub(super) fn rounded(value: f64, decimals: usize) -> String {
    with_minus(&format!("{value:.decimals$}"))
}

/// `count`·10^`exponent` with `decimals` decimals and separated thousands: `−20 000`.
pub(super) fn decimal(count: i128, exponent: i32, decimals: usize) -> String {
    let digits = if count == 0 { String::new() } else { count.unsigned_abs().to_string() };
    // Zeros appended because of the power of ten, or of the decimals.
    let appended = if count == 0 { 0 } else { (exponent + decimals as i32).max(0) as usize };
    let digits = format!("{digits:0>width$}", digits = digits + &"0".repeat(appended), width = decimals + 1);
    let (whole, fraction) = digits.split_at(digits.len() - decimals);
    let sign = if count < 0 { "−" } else { "" };
    let point = if fraction.is_empty() { "" } else { "." };
    format!("{sign}{}{point}{fraction}", grouped(whole))
}

/// `count`·10^`exponent` with all its digits.
pub(super) fn exact(count: i128, exponent: i32) -> String {
    let digits = count.unsigned_abs().to_string();
    let kept = digits.trim_end_matches('0');
    let zeros = (digits.len() - kept.len()) as i32;
    let magnitude = exponent + digits.len() as i32 - 1;
    let sign = if count < 0 { "−" } else { "" };
    if count == 0 {
        "0".to_owned()
    } else if (-4..15).contains(&magnitude) {
        let kept: i128 = kept.parse().unwrap_or(0);
        sign.to_owned() + &decimal(kept, exponent + zeros, (-exponent - zeros).max(0) as usize)
    } else {
        let (first, rest) = kept.split_at(1);
        let point = if rest.is_empty() { "" } else { "." };
        format!("{sign}{first}{point}{rest}×{}", power_of_ten(magnitude))
    }
}

/// `10⁻³`.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32(0x2070 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    };
    "10".chars().chain(exponent.to_string().chars().map(raised)).collect()
}

/// The double nearest to 10^`exponent`; repeated multiplication would be inexact.
pub(super) fn ten_to(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(f64::NAN)
}

/// The largest exponent whose power of ten is not above a positive value.
pub(super) fn magnitude(value: f64) -> i32 {
    let estimate = value.log10().floor() as i32;
    // The logarithm of a number just below a power of ten may be rounded up.
    if ten_to(estimate) > value { estimate - 1 } else { estimate }
}

/// Replaces hyphens by minus signs.
fn with_minus(written: &str) -> String {
    written.replace('-', "−")
}

/// Separates groups of three digits if there are at least five digits.
fn grouped(whole: &str) -> String {
    if whole.len() < 5 {
        return whole.to_owned();
    }
    let mut text = String::new();
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}
