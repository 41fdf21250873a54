//! The rows of a sweep, one for each design.

use qrm_core::QuantityDescription;
use qrm_sim::batch::DesignResult;
use qrm_sim::columns::{self, Column};
use qrm_sim::run::Status;

use super::axes::Axes;
use crate::format::full;
use crate::messages;
use crate::parquet;
use crate::setup::Setup;

/// The fields of a row, and whether the design came to its end.
pub(super) struct Row {
    pub(super) fields: Vec<String>,
    pub(super) is_done: bool,
}

/// The source of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    Design,
    /// The value of a parameter that is varied.
    Varied(usize),
    Status,
    Reason,
    EndTime,
    Steps,
    /// A coordinate at the end.
    Coordinate(usize),
    /// The rate of a coordinate at the end.
    Rate(usize),
    Minimum(usize),
    Maximum(usize),
    EstimatedError,
}

/// The columns of every sweep, whatever its scene.
const FIXED: [(&str, &str, &str, Field); 6] = [
    ("design", "", "number of the design", Field::Design),
    ("status", "", "whether the design came to its end: done or failed", Field::Status),
    ("reason", "", "why it did not", Field::Reason),
    ("end_time", "s", "when the motion ended", Field::EndTime),
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
    let [design, status, reason, end_time, steps, error] =
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
        [("min", "smallest", Field::Minimum(i)), ("max", "largest", Field::Maximum(i))].map(|(end, what, field)| {
            let doc = format!("{what} value in the motion: {}", output.doc);
            Column::new(format!("{}_{end}", output.name), output.unit, doc, field)
        })
    });
    let mut columns = vec![design];
    columns.extend(varied);
    columns.extend([status, reason, end_time, steps]);
    columns.extend(coordinates);
    columns.extend(rates);
    columns.extend(extremes);
    columns.push(error);
    columns
}

/// The row of a design that cannot be run.
pub(super) fn refused(columns: &[Column<Field>], design: usize, values: &[f64], reason: &str) -> Row {
    let field = |column: &Column<Field>| match column.kind {
        Field::Design => design.to_string(),
        Field::Varied(i) => full(values[i]),
        Field::Status => "failed".to_owned(),
        Field::Reason => reason.to_owned(),
        _ => String::new(),
    };
    Row { fields: columns.iter().map(field).collect(), is_done: false }
}

/// The row of a design that was run.
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
            let doubts = finished.doubts.iter().map(|doubt| doubt.text(tolerance, setup.description));
            doubts.chain(passed_over).collect::<Vec<_>>().join("; and ")
        }
        Ok(status) => messages::status(status, finished.end_time, setup.description, &setup.until).text,
        Err(reason) => messages::no_start(reason, setup).message().text,
    };
    let has_begun = finished.status.is_ok();
    let at = |values: &[f64], i: usize| values.get(i).map_or_else(String::new, |value| full(*value));
    let extreme = |i: usize, end: usize| finished.extremes.get(i).map_or_else(String::new, |e| full(e[end]));
    let field = |column: &Column<Field>| match column.kind {
        Field::Design => design.to_string(),
        Field::Varied(i) => full(values[i]),
        Field::Status => if reason.is_empty() { "done" } else { "failed" }.to_owned(),
        Field::Reason => reason.clone(),
        Field::EndTime if has_begun => full(finished.end_time),
        Field::Steps if has_begun => finished.steps.to_string(),
        Field::EndTime | Field::Steps => String::new(),
        Field::Coordinate(i) => at(&finished.q, i),
        Field::Rate(i) => at(&finished.qd, i),
        Field::Minimum(i) => extreme(i, 0),
        Field::Maximum(i) => extreme(i, 1),
        Field::EstimatedError => finished.estimated_error.map_or_else(String::new, full),
    };
    Row { fields: columns.iter().map(field).collect(), is_done: reason.is_empty() }
}
