//! Derivatives as tables.

use qrm_sim::analysis::{DerivativeErrors, Derivatives};

use super::quantities::Quantity;
use crate::error::Error;
use crate::output;
use crate::setup::Setup;

/// The number of derivative columns next to each other on a terminal.
const ABREAST: usize = 5;

/// `sensitivity.csv`: a row for each quantity; for each parameter a column of derivatives, of Hessian products if there
/// is a vector, and of the errors of both if they are estimated.
pub(super) fn csv(rows: &[Quantity], by: &[&str]) -> Result<Vec<u8>, Error> {
    let mut header = ["quantity", "of", "unit", "value"].map(str::to_owned).to_vec();
    for (prefix, suffix, _) in rows.first().map(columns).unwrap_or_default() {
        header.extend(by.iter().map(|name| format!("{prefix}{name}{suffix}")));
    }
    let record = |row: &Quantity| {
        let texts = [row.what.to_owned(), row.name.clone(), row.unit.clone()].into_iter();
        let numbers = std::iter::once(row.value.value).chain(columns(row).into_iter().flat_map(|group| group.2));
        texts.chain(numbers.map(|number| format!("{number:?}"))).collect::<Vec<String>>()
    };
    output::csv(header, rows.iter().map(record))
}

/// The groups of columns: the prefix and the suffix of the parameter's name, and the numbers.
fn columns(Quantity { value, errors, .. }: &Quantity) -> Vec<(&'static str, &'static str, Vec<f64>)> {
    let mut groups = vec![("by_", "", value.by.clone()), ("hessian_vector_", "", value.hessian_vector.clone())];
    if let Some(DerivativeErrors { by, hessian_vector, .. }) = errors {
        groups.extend([("by_", "_error", by.clone()), ("hessian_vector_", "_error", hessian_vector.clone())]);
    }
    groups.retain(|(_, _, numbers)| !numbers.is_empty());
    groups
}

/// The table for a terminal.
pub(super) fn text(setup: &Setup, rows: &[Quantity], by: &[&str]) -> String {
    let mut text = format!("{}: derivatives by parameters, in the units of both\n", setup.description.name);
    let label = |row: &Quantity| format!("{} {}", spoken(row.what), row.name);
    let width = rows.iter().map(|row| label(row).len()).max().unwrap_or(0);
    let mut block = |title: &str, numbers: fn(&Derivatives) -> &[f64]| {
        for (place, names) in by.chunks(ABREAST).enumerate() {
            text += &format!("\n  {:width$} {:>16} ", "", "value");
            names.iter().for_each(|name| text += &format!("{:>17}", format!("{title} {name}")));
            text.push('\n');
            for row in rows {
                text += &format!("  {:width$} {:>16} ", label(row), digits(row.value.value));
                let numbers = numbers(row.value).iter().skip(place * ABREAST).take(ABREAST);
                numbers.for_each(|number| text += &format!("{:>17}", digits(*number)));
                text += format!("  {}", row.unit).trim_end();
                text.push('\n');
            }
        }
    };
    block("by", |value| &value.by);
    if rows.iter().any(|row| !row.value.hessian_vector.is_empty()) {
        block("H v,", |value| &value.hessian_vector);
    }
    text
}

fn spoken(what: &str) -> String {
    match what {
        "minimum" => "smallest".to_owned(),
        "maximum" => "largest".to_owned(),
        "time_of_minimum" => "time of smallest".to_owned(),
        "time_of_maximum" => "time of largest".to_owned(),
        "integral" => "integral of".to_owned(),
        what => what.to_owned(),
    }
}

/// A number in ten digits.
fn digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e6).contains(&size) {
        return format!("{value:.9e}");
    }
    let before = if size < 1.0 { 0 } else { size.log10().floor() as usize + 1 };
    format!("{value:.*}", 10_usize.saturating_sub(before))
}
