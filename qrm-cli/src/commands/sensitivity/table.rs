//! Derivatives as tables.

use super::quantities::Quantity;
use crate::error::Error;
use crate::output;
use crate::setup::Setup;

/// Columns of derivatives that stand side by side on a terminal.
const ABREAST: usize = 5;

/// `sensitivity.csv`: a row for each quantity, a column for each parameter.
pub(super) fn csv(rows: &[Quantity], by: &[&str]) -> Result<Vec<u8>, Error> {
    let header = ["quantity", "of", "unit", "value"].map(str::to_owned).into_iter();
    let record = |row: &Quantity| {
        let texts = [row.what.to_owned(), row.name.clone(), row.unit.clone()].into_iter();
        let numbers = std::iter::once(&row.value.value).chain(&row.value.by).map(|number| format!("{number:?}"));
        texts.chain(numbers).collect::<Vec<String>>()
    };
    output::csv(header.chain(by.iter().map(|name| format!("by_{name}"))), rows.iter().map(record))
}

/// The table for a terminal.
pub(super) fn text(setup: &Setup, rows: &[Quantity], by: &[&str]) -> String {
    let mut text = format!("{}: derivatives by parameters, in the units of both\n", setup.description.name);
    let label = |row: &Quantity| format!("{} {}", spoken(row.what), row.name);
    let width = rows.iter().map(|row| label(row).len()).max().unwrap_or(0);
    for (block, names) in by.chunks(ABREAST).enumerate() {
        text += &format!("\n  {:width$} {:>16} ", "", "value");
        names.iter().for_each(|name| text += &format!("{:>17}", format!("by {name}")));
        text.push('\n');
        for row in rows {
            text += &format!("  {:width$} {:>16} ", label(row), digits(row.value.value));
            let derivatives = row.value.by.iter().skip(block * ABREAST).take(ABREAST);
            derivatives.for_each(|derivative| text += &format!("{:>17}", digits(*derivative)));
            text += format!("  {}", row.unit).trim_end();
            text.push('\n');
        }
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
