//! `modes.csv`

use super::report::ModesReport;
use crate::error::Error;
use crate::format::full;
use crate::output::csv as table;

/// One row a mode: frequency, shape and derivatives by parameters.
pub(super) fn csv(report: &ModesReport) -> Result<Vec<u8>, Error> {
    let numbers = ["frequency", "frequency_error", "rate", "rate_error", "square", "square_error"];
    let mut header: Vec<String> = ["mode", "kind"].into_iter().chain(numbers).map(str::to_owned).collect();
    let coordinates = report.equilibrium.coordinates.0.iter().map(|(name, _)| name);
    header.extend(coordinates.map(|name| format!("shape_{name}")));
    header.extend(report.parameters.iter().map(|name| format!("by_{name}")));
    let rows = report.modes.iter().enumerate().map(|(place, mode)| {
        let numbers =
            [mode.frequency, mode.frequency_error, mode.rate, mode.rate_error, mode.square, mode.square_error];
        let mut row = vec![(place + 1).to_string(), mode.kind.to_owned()];
        row.extend(numbers.map(full));
        row.extend(mode.shape.0.iter().map(|(_, value)| full(*value)));
        match &mode.by {
            Some(by) => row.extend(by.0.iter().map(|(_, value)| full(*value))),
            None => row.extend(report.parameters.iter().map(|_| String::new())),
        }
        row
    });
    table(header, rows)
}
