//! Numbers in the text of a scene.

use qrm_scene::unit::Unit;
use toml_edit::{DocumentMut, Item, Value};

use super::toml_text::{Place, formula, replace, value_mut};

/// Writes a number in SI units, in the unit of the file. A formula of one parameter sets this parameter.
///
/// # Errors
/// The number is a formula of parameters.
pub(super) fn set(document: &mut DocumentMut, place: Place, number: f64, resolution: f64) -> Result<(), String> {
    set_scaled(document, place, number, 1.0, resolution)
}

/// Writes a number. Without a unit it has units of the size `factor` in the file.
fn set_scaled(
    document: &mut DocumentMut,
    place: Place,
    number: f64,
    factor: f64,
    resolution: f64,
) -> Result<(), String> {
    let Some(value) = value_mut(document, place) else {
        return Err(format!("the file has no value at `{}`", place.0.join(".")));
    };
    let text = value.as_str().unwrap_or_default().trim().to_owned();
    if let Some((keys, unit)) = parameter(document, &text).filter(|_| factor == 1.0) {
        if uses(document.as_item(), &text) > 1 {
            return Err(format!("parameter `{text}` has other uses too: change it by its slider, or in the file"));
        }
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        return set_scaled(document, (&keys, None), number, unit, resolution);
    }
    if names(&text).any(|name| parameter(document, name).is_some()) {
        let name = place.0.join(".");
        return Err(format!("`{name}` is the formula `{text}`: change it, or its parameters, in the file"));
    }
    let has_value = |value: &Value| {
        let unit = if quantity(&text).is_some() { 1.0 } else { factor };
        literal(value).is_some_and(|own| (own * unit - number).abs() <= 0.5 * resolution)
    };
    if value_mut(document, place).is_some_and(|value| has_value(value)) {
        return Ok(());
    }
    let scaled = |factor: f64| rounded(number / factor, resolution / factor);
    let new = quantity(&text).map_or_else(
        || Value::from(scaled(factor)),
        |(_, unit, factor)| formula(&format!("{} {unit}", scaled(factor))),
    );
    if let Some(value) = value_mut(document, place) {
        replace(value, new);
    }
    Ok(())
}

/// The number at a place in SI units; `None` if it is a formula.
pub(super) fn get(document: &DocumentMut, (keys, index): Place) -> Option<f64> {
    let item = keys.iter().try_fold(document.as_item(), |item, key| item.as_table_like()?.get(key))?;
    let value = item.as_value()?;
    let value = index.map_or(Some(value), |index| value.as_array()?.get(index))?;
    let text = value.as_str().unwrap_or_default().trim();
    if let Some((keys, factor)) = parameter(document, text) {
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        return get(document, (&keys, None)).map(|number| number * factor);
    }
    literal(value)
}

/// A number that is written without names, in SI units.
pub(super) fn literal(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(number) => number.value().to_string().parse().ok(),
        Value::Float(number) => Some(*number.value()),
        Value::String(text) => {
            let text = text.value().trim();
            let plain = || text.parse().ok();
            quantity(text).map_or_else(plain, |(number, _, factor)| Some(number * factor))
        }
        _ => None,
    }
}

/// An angle as text in degrees.
pub(super) fn degrees(angle: f64) -> String {
    format!("{} deg", rounded(angle.to_degrees(), 0.01))
}

/// The number that is nearest to a value among the multiples of a power of ten.
pub(super) fn rounded(value: f64, resolution: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 17")]
    let decimals = (-resolution.log10()).ceil().clamp(0.0, 17.0) as usize;
    let number: f64 = format!("{value:.decimals$}").parse().unwrap_or(value);
    // No minus before zero.
    number + 0.0
}

/// A number with a unit: both, and the size of the unit in SI units.
fn quantity(text: &str) -> Option<(f64, &str, f64)> {
    let is_exponent = |rest: &str| {
        let digits = rest.strip_prefix(['e', 'E']).map(|rest| rest.strip_prefix(['+', '-']).unwrap_or(rest));
        digits.is_some_and(|digits| digits.starts_with(|c: char| c.is_ascii_digit()))
    };
    let is_end = |(i, c): &(usize, char)| !matches!(c, '0'..='9' | '.' | '-' | '+') && !is_exponent(&text[*i..]);
    let end = text.char_indices().find(is_end).map(|(end, _)| end).filter(|end| *end > 0)?;
    let (number, unit) = (text[..end].parse().ok()?, text[end..].trim());
    Some((number, unit, Unit::parse(unit)?.factor()))
}

/// The keys of the value of a parameter, and the size of its unit.
pub(super) fn parameter(document: &DocumentMut, name: &str) -> Option<(Vec<String>, f64)> {
    let item = document.get("parameters")?.as_table_like()?.get(name)?;
    let keys = |more: &[&str]| ["parameters", name].iter().chain(more).map(|key| (*key).to_owned()).collect();
    let Some(table) = item.as_table_like() else { return Some((keys(&[]), 1.0)) };
    let unit = table.get("unit").and_then(Item::as_str).and_then(Unit::parse);
    Some((keys(&["value"]), unit.map_or(1.0, |unit| unit.factor())))
}

/// The names in a formula.
fn names(formula: &str) -> impl Iterator<Item = &str> {
    formula.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|name| !name.is_empty())
}

/// The number of texts that contain a name.
fn uses(item: &Item, name: &str) -> usize {
    let in_value = |value: &Value| uses(&Item::Value(value.clone()), name);
    if let Some(table) = item.as_table_like() {
        return table.iter().map(|(_, item)| uses(item, name)).sum();
    }
    match item.as_value() {
        Some(Value::Array(array)) => array.iter().map(in_value).sum(),
        Some(Value::String(text)) => usize::from(names(text.value()).any(|own| own == name)),
        _ => 0,
    }
}
