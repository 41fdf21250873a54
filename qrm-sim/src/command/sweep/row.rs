//! What a design becomes in a table.

use qrm_core::{Description, QuantityDescription};

use super::super::arguments::SweepArguments;
use super::super::words;
use super::axes::Axes;
use crate::outcome::{NoStart, Status};
use crate::sweep::Finished;
use crate::trouble::breakdown;

/// The fields of a row, and whether the design came to its end.
pub(super) struct Line {
    pub(super) fields: Vec<String>,
    pub(super) is_done: bool,
}

/// The columns of a sweep.
pub(super) struct Columns {
    description: Description,
    varied: Vec<String>,
    until: String,
    /// Whether there are columns for the extremes of outputs.
    extremes: bool,
}

impl Columns {
    pub(super) fn new(description: Description, axes: &Axes, arguments: &SweepArguments) -> Self {
        let until = arguments.scene.until.clone().unwrap_or_else(|| description.until.to_owned());
        let varied = axes.names().map(str::to_owned).collect();
        Self { varied, description, until, extremes: !arguments.no_extremes }
    }

    /// Their names.
    pub(super) fn header(&self) -> Vec<String> {
        let own = |name: &&str| (*name).to_owned();
        let mut header: Vec<String> = vec!["design".to_owned()];
        header.extend(self.varied.iter().cloned());
        header.extend(["status", "reason", "end_time", "steps"].iter().map(own));
        header.extend(self.description.coordinates.iter().map(|c| c.name.to_owned()));
        header.extend(self.description.coordinates.iter().map(|c| format!("{}_dot", c.name)));
        let extremes = self.outputs().iter().flat_map(|o| ["min", "max"].map(|end| format!("{}_{end}", o.name)));
        header.extend(extremes);
        header.push("estimated_error".to_owned());
        header
    }

    /// The row of a design that is none.
    pub(super) fn refused(&self, design: usize, values: &[f64], reason: &str) -> Line {
        let mut fields = vec![design.to_string()];
        fields.extend(values.iter().map(|value| number(*value)));
        fields.extend(["failed".to_owned(), reason.to_owned()]);
        fields.resize(self.header().len(), String::new());
        Line { fields, is_done: false }
    }

    /// The row of a design.
    pub(super) fn line(&self, design: usize, values: &[f64], finished: &Finished) -> Line {
        let reason = match &finished.status {
            Ok(Status::Completed | Status::Stopped) => String::new(),
            Ok(status) => words::status(status, finished.end_time, &self.description, &self.until),
            Err(reason) => self.no_start(reason),
        };
        let is_done = reason.is_empty();
        let mut fields = vec![design.to_string()];
        fields.extend(values.iter().map(|value| number(*value)));
        fields.push(if is_done { "done" } else { "failed" }.to_owned());
        // A table has one line for each design.
        fields.push(reason.split_whitespace().collect::<Vec<_>>().join(" "));
        let has_begun = finished.status.is_ok();
        let begun = |text: String| if has_begun { text } else { String::new() };
        fields.push(begun(number(finished.end_time)));
        fields.push(begun(finished.steps.to_string()));
        let (n, outputs) = (self.description.coordinates.len(), self.outputs().len());
        let each = |values: &[f64], i: usize| values.get(i).map_or_else(String::new, |value| number(*value));
        fields.extend((0..n).map(|i| each(&finished.q, i)));
        fields.extend((0..n).map(|i| each(&finished.qd, i)));
        fields.extend(
            (0..2 * outputs).map(|i| finished.extremes.get(i / 2).map_or_else(String::new, |e| number(e[i % 2]))),
        );
        fields.push(finished.estimated_error.map_or_else(String::new, number));
        Line { fields, is_done }
    }

    /// Those that have columns.
    fn outputs(&self) -> &[QuantityDescription] {
        if self.extremes { self.description.outputs } else { &[] }
    }

    fn no_start(&self, reason: &NoStart) -> String {
        match reason {
            NoStart::NotAssembled(reason) => {
                let constraint = &self.description.constraints[reason.constraint];
                let what =
                    if reason.rates { "the rates at the start cannot be solved for" } else { "it cannot be assembled" };
                format!(
                    "{what}: constraint `{}` stays {:.3e} {} open",
                    constraint.name, reason.residual, constraint.unit
                )
            }
            NoStart::Broken(reason) => format!("it cannot start: {}", breakdown(reason, &self.description)),
            NoStart::ConditionNotFinite => "the stop condition has no finite value at the start".to_owned(),
            NoStart::StepTooShort { step, end_time } => {
                format!("a step of {step:e} s is too short for a run of {end_time} s")
            }
        }
    }
}

/// A number in as many digits as it has; nothing where it is none.
fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}
