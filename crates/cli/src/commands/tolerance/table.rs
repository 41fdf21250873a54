//! The results of tolerances on a terminal.

use super::report::Report;
use super::{Options, Quantity};
use crate::format::{counted, with_error, wrapped};
use crate::table::{self, Align};

/// The smallest printed share of a parameter.
const LEAST_SHARE: f64 = 0.005;
/// The largest number of printed parameters per quantity.
const MOST_PARAMETERS: usize = 4;
/// The error of samples, relative to three standard deviations, above which it is marked.
const LARGE_ERROR: f64 = 0.1;
/// The error of samples, relative to the size of their quantity, below which it does not matter.
const SMALL_ERROR: f64 = 1e-6;
/// The width of warnings.
const WIDTH: usize = 110;

/// The results as a table, with warnings.
pub(super) fn text(report: &Report) -> String {
    let header = ["", "nominal", "linear", "Monte Carlo", "worst case", "due to"].map(str::to_owned);
    let mut rows = vec![header.to_vec()];
    rows.extend(report.quantities.iter().map(|quantity| row(report, quantity)));
    let columns = [Align::Left, Align::Right, Align::Right, Align::Right, Align::Right, Align::Left];
    let Options { distribution, .. } = report.options;
    let count = counted(report.samples.count() as u64, "sample");
    let title = format!("{}: {count}, {}; +- is three standard deviations", report.scene, distribution.name());
    let mut lines = vec![title, String::new()];
    lines.extend(table::lines(&columns, &rows));
    let warnings = warnings(report);
    lines.extend(warnings.iter().map(|warning| format!("\n{}", wrapped(&format!("warning: {warning}"), WIDTH))));
    lines.push(String::new());
    lines.join("\n")
}

fn row(report: &Report, quantity: &Quantity) -> Vec<String> {
    let Quantity { name, unit, nominal, worst, resolution, .. } = quantity;
    let (deviation, shares) = quantity.linear(report.parameters, report.options.distribution);
    let spread = |deviation: f64| {
        if 3.0 * deviation <= *resolution { "+-0".to_owned() } else { format!("+-{:.2e}", 3.0 * deviation) }
    };
    let change = |(sign, end): (&str, f64)| {
        let change = end - nominal.value;
        if change.abs() <= *resolution { format!("{sign}0") } else { format!("{change:+.2e}") }
    };
    let by_difference = if unconfirmed(report, quantity).next().is_some() { "~" } else { "" };
    let of_samples = if has_no_spread(quantity) {
        "+-0".to_owned()
    } else {
        format!("{}{}", if is_uncertain(quantity) { "?" } else { "" }, spread(quantity.statistics.deviation))
    };
    let [least, most] = worst.ends;
    vec![
        if unit.is_empty() { name.clone() } else { format!("{name}, {unit}") },
        with_error(nominal.value, nominal.error.unwrap_or(0.0)),
        format!("{by_difference}{}", spread(deviation)),
        of_samples,
        format!("{} {}", change(("-", least)), change(("+", most))),
        if 3.0 * deviation <= *resolution { String::new() } else { ranking(report, &shares) },
    ]
}

/// The parameters whose derivative of a quantity is not confirmed.
fn unconfirmed<'r>(report: &'r Report, quantity: &'r Quantity) -> impl Iterator<Item = &'r str> {
    let slopes = report.parameters.iter().zip(&quantity.slopes);
    slopes.filter(|(_, slope)| !slope.is_confirmed).map(|(parameter, _)| parameter.name.as_str())
}

/// Whether the samples of a quantity differ only by insignificant errors.
fn has_no_spread(quantity: &Quantity) -> bool {
    let error = quantity.sample_error;
    3.0 * quantity.statistics.deviation <= error && error <= SMALL_ERROR * quantity.nominal.size
}

/// Whether errors are a large part of the spread of a quantity's samples.
fn is_uncertain(quantity: &Quantity) -> bool {
    let Quantity { sample_error, resolution, statistics, .. } = quantity;
    *sample_error > *resolution && *sample_error > LARGE_ERROR * 3.0 * statistics.deviation && !has_no_spread(quantity)
}

fn warnings(report: &Report) -> Vec<String> {
    let quantities = report.quantities;
    let list = |names: Vec<String>| names.join(", ");
    let mut warnings = Vec::new();
    let derivatives = quantities.iter().filter_map(|quantity| {
        let by: Vec<&str> = unconfirmed(report, quantity).collect();
        (!by.is_empty()).then(|| format!("{} by {}", quantity.name, by.join(" and ")))
    });
    let derivatives: Vec<String> = derivatives.collect();
    if !derivatives.is_empty() {
        warnings.push(format!(
            "motions at other values do not confirm the derivatives of {}; linear tolerances with ~ take the \
             difference over the whole tolerance instead",
            list(derivatives)
        ));
    }
    let turning = quantities.iter().filter(|quantity| !quantity.worst.is_monotonic);
    let turning: Vec<String> = turning.map(|quantity| quantity.name.clone()).collect();
    if !turning.is_empty() {
        warnings.push(format!(
            "not monotonic within the tolerances: {}; the worst case is that of {}, and others may go beyond it",
            list(turning),
            counted(report.probes.count() as u64, "motion")
        ));
    }
    let uncertain = quantities.iter().filter(|quantity| is_uncertain(quantity));
    let uncertain: Vec<String> =
        uncertain.map(|quantity| format!("{} ({:.1e})", quantity.name, quantity.sample_error)).collect();
    if !uncertain.is_empty() {
        warnings.push(format!(
            "samples with ? have errors that matter: {}. Peaks that are narrow against a step, and corners of outputs, \
             are not always seen in lanes; try a shorter --max-step",
            list(uncertain)
        ));
    }
    if let (failed @ 1.., Some(reason)) = (report.samples.failed, &report.samples.reason) {
        warnings.push(format!("{} failed: {reason}", counted(failed as u64, "sample")));
    }
    warnings
}

/// The parameters sorted by their shares, largest first.
fn ranking(report: &Report, shares: &[f64]) -> String {
    let names = report.parameters.iter().map(|parameter| parameter.name.as_str());
    let mut ranked: Vec<(&str, f64)> = names.zip(shares.iter().copied()).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    let large = ranked.into_iter().filter(|(_, share)| *share >= LEAST_SHARE).take(MOST_PARAMETERS);
    large.map(|(name, share)| format!("{name} {:.0} %", 100.0 * share)).collect::<Vec<_>>().join(", ")
}
