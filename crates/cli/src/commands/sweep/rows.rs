//! The rows of a sweep, one for each design.

use qrm_core::QuantityDescription;
use qrm_sim::batch::DesignResult;
use qrm_sim::columns::{self, Column};
use qrm_sim::run::Status;

use super::axes::Axes;
use crate::error::Message;
use crate::format::push_full;
use crate::parquet;
use crate::run_report::design_warnings;
use crate::setup::Setup;

/// The cells of a row, and whether the design reached its end.
pub(crate) struct Row {
    pub(crate) cells: Vec<Cell>,
    pub(crate) is_done: bool,
    pub(crate) warnings: Vec<Message>,
}

/// An entry of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    /// An integer.
    Whole(u64),
    /// A number, which may be undefined.
    Number(f64),
    /// A text.
    Text(String),
    /// An unknown value.
    Empty,
}

impl Cell {
    /// Writes the cell as a field of CSV.
    fn write(&self, text: &mut String) {
        match self {
            Self::Whole(number) => text.push_str(&number.to_string()),
            Self::Number(number) => push_full(text, *number),
            Self::Text(own) if own.contains(['"', ',', '\n', '\r']) => {
                text.extend(["\"", &own.replace('"', "\"\""), "\""]);
            }
            Self::Text(own) => text.push_str(own),
            Self::Empty => {}
        }
    }
}

/// Rows as CSV.
pub(super) struct Block {
    pub(super) text: String,
    /// The number of designs that reached their end, and of those that did not.
    pub(super) done: usize,
    pub(super) failed: usize,
    /// The warnings of designs, with their places among the rows.
    pub(super) warnings: Vec<(usize, Vec<Message>)>,
}

impl From<Vec<Row>> for Block {
    fn from(rows: Vec<Row>) -> Self {
        let mut text = String::new();
        for row in &rows {
            for (place, cell) in row.cells.iter().enumerate() {
                if place > 0 {
                    text.push(',');
                }
                cell.write(&mut text);
            }
            text.push('\n');
        }
        let done = rows.iter().filter(|row| row.is_done).count();
        let failed = rows.len() - done;
        let warnings = rows.into_iter().map(|row| row.warnings).enumerate();
        Self { text, done, failed, warnings: warnings.filter(|(_, warnings)| !warnings.is_empty()).collect() }
    }
}

/// The source of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Field {
    Design,
    /// The value of a varied parameter.
    Varied(usize),
    Status,
    Reason,
    EndTime,
    EndTimeError,
    Steps,
    /// A coordinate at the end.
    Coordinate(usize),
    /// The rate of a coordinate at the end.
    Rate(usize),
    Minimum(usize),
    Maximum(usize),
    MinimumError(usize),
    MaximumError(usize),
    EstimatedError,
}

/// The columns that every sweep has; `end_time_error` only where designs end at a condition.
const FIXED: [(&str, &str, &str, Field); 7] = [
    ("design", "", "number of the design", Field::Design),
    ("status", "", "whether the design came to its end: done or failed", Field::Status),
    ("reason", "", "why it did not", Field::Reason),
    ("end_time", "s", "when the motion ended", Field::EndTime),
    ("end_time_error", "s", "estimated error of this time", Field::EndTimeError),
    ("steps", "", "steps made", Field::Steps),
    ("estimated_error", "rad or m", "largest error of a coordinate in any row, estimated", Field::EstimatedError),
];

/// The type of a column of a sweep.
pub(super) fn parquet_kind(name: &str) -> parquet::Kind {
    match FIXED.iter().find(|(fixed, ..)| *fixed == name) {
        Some((.., Field::Design | Field::Steps)) => parquet::Kind::Whole,
        Some((.., Field::Status | Field::Reason)) => parquet::Kind::Text,
        _ => parquet::Kind::Number,
    }
}

/// The columns of a sweep.
pub(super) fn columns(setup: &Setup, axes: &Axes, has_extremes: bool) -> Vec<Column<Field>> {
    let [design, status, reason, end_time, end_time_error, steps, error] =
        FIXED.map(|(name, unit, doc, field)| Column::new(name, unit, doc, field));
    let description = setup.description;
    let varied = axes.names().enumerate().map(|(i, name)| {
        let parameter = description.parameters.iter().find(|parameter| parameter.name == name);
        let (unit, doc) = parameter.map_or(("", ""), |parameter| (parameter.unit, parameter.doc));
        Column::new(name, unit, doc, Field::Varied(i))
    });
    let trajectory = columns::columns(description);
    let of = |field: fn(columns::Kind) -> Option<Field>| {
        let column = move |column: &Column| {
            let Column { name, unit, doc, kind } = column.clone();
            Some(Column { name, unit, doc, kind: field(kind)? })
        };
        trajectory.iter().filter_map(column).collect::<Vec<_>>()
    };
    let coordinates = of(|kind| match kind {
        columns::Kind::Coordinate(i) => Some(Field::Coordinate(i)),
        _ => None,
    });
    let rates = of(|kind| match kind {
        columns::Kind::Rate(i) => Some(Field::Rate(i)),
        _ => None,
    });
    let outputs = if has_extremes { description.outputs } else { &[] };
    let extremes = outputs.iter().enumerate().flat_map(|(i, output): (usize, &QuantityDescription)| {
        let of_output = [
            ("min", "smallest value in the motion", Field::Minimum(i)),
            ("min_error", "estimated error of the smallest value", Field::MinimumError(i)),
            ("max", "largest value in the motion", Field::Maximum(i)),
            ("max_error", "estimated error of the largest value", Field::MaximumError(i)),
        ];
        of_output.map(|(end, what, field)| {
            Column::new(format!("{}_{end}", output.name), output.unit, format!("{what}: {}", output.doc), field)
        })
    });
    let mut columns = vec![design];
    columns.extend(varied);
    columns.extend([status, reason, end_time]);
    columns.extend(Some(end_time_error).filter(|_| setup.has_condition()));
    columns.push(steps);
    columns.extend(coordinates);
    columns.extend(rates);
    columns.extend(extremes);
    columns.push(error);
    columns
}

/// The row of a design that cannot run.
pub(super) fn refused(columns: &[Column<Field>], design: usize, values: &[f64], reason: &str) -> Row {
    let cell = |column: &Column<Field>| match column.kind {
        Field::Design => Cell::Whole(design as u64),
        Field::Varied(i) => Cell::Number(values[i]),
        Field::Status => Cell::Text("failed".to_owned()),
        Field::Reason => Cell::Text(reason.to_owned()),
        _ => Cell::Empty,
    };
    Row { cells: columns.iter().map(cell).collect(), is_done: false, warnings: Vec::new() }
}

/// The row of a completed design.
pub(super) fn row(
    columns: &[Column<Field>],
    setup: &Setup,
    design: usize,
    values: &[f64],
    finished: &DesignResult,
    passed_over: Option<String>,
) -> Row {
    let tolerance = setup.settings.tolerance();
    let reason = match &finished.status {
        Ok(Status::Completed | Status::Stopped) => {
            let rejection_reasons =
                finished.rejection_reasons.iter().map(|reason| reason.text(tolerance, setup.description));
            rejection_reasons.chain(passed_over).collect::<Vec<_>>().join("; and ")
        }
        Ok(status) => setup.status(status, (finished.end_time, None)).text,
        Err(reason) => setup.no_start(reason).message().text,
    };
    let has_begun = finished.status.is_ok();
    let number = |value: Option<&f64>| value.map_or(Cell::Empty, |value| Cell::Number(*value));
    let cell = |column: &Column<Field>| match column.kind {
        Field::Design => Cell::Whole(design as u64),
        Field::Varied(i) => Cell::Number(values[i]),
        Field::Status => Cell::Text(if reason.is_empty() { "done" } else { "failed" }.to_owned()),
        Field::Reason => Cell::Text(reason.clone()),
        Field::EndTime if has_begun => Cell::Number(finished.end_time),
        Field::Steps if has_begun => Cell::Whole(finished.steps),
        Field::EndTime | Field::Steps => Cell::Empty,
        Field::EndTimeError => number(finished.end_time_error.map(two_digits).as_ref()),
        Field::Coordinate(i) => number(finished.q.get(i)),
        Field::Rate(i) => number(finished.qd.get(i)),
        Field::Minimum(i) => number(finished.extremes.get(i).map(|e| &e[0])),
        Field::Maximum(i) => number(finished.extremes.get(i).map(|e| &e[1])),
        Field::MinimumError(i) => number(finished.extreme_errors.get(i).map(|e| two_digits(e[0])).as_ref()),
        Field::MaximumError(i) => number(finished.extreme_errors.get(i).map(|e| two_digits(e[1])).as_ref()),
        Field::EstimatedError => number(finished.estimated_error.as_ref()),
    };
    let is_done = reason.is_empty();
    let warnings = if is_done { design_warnings(setup, finished) } else { Vec::new() };
    Row { cells: columns.iter().map(cell).collect(), is_done, warnings }
}

/// An error in as many digits as are known of it.
fn two_digits(error: f64) -> f64 {
    format!("{error:.1e}").parse().unwrap_or(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_of_the_library() {
        let texts = ["", "done", "a, b", "one \"two\"", "two\nlines", "\r", "\"", "# a", " ", "-1"];
        let cells = texts.map(|text| Cell::Text(text.to_owned())).into_iter();
        let cells = cells.chain([Cell::Whole(7), Cell::Number(0.1), Cell::Number(f64::NAN), Cell::Empty]).collect();
        let block = Block::from(vec![Row { cells, is_done: false, warnings: Vec::new() }]);
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(texts.into_iter().chain(["7", "0.1", "", ""])).expect("written");
        assert_eq!(block.text.as_bytes(), writer.into_inner().expect("written"));
        assert_eq!((block.done, block.failed), (0, 1));
    }
}
