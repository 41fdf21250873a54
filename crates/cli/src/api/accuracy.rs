//! Run times and errors of every method.

use std::time::Instant;

use clap::ValueEnum;

use super::options::RunOptions;
use super::scene::LoadedScene;
use crate::commands::accuracy::{Study, budget, column};
use crate::error::Error;
use crate::reference::ReferenceKind;

/// The options of a measurement of accuracy.
#[derive(Clone, Debug, Default)]
pub struct AccuracyOptions {
    /// The options of each run, except its method.
    pub run: RunOptions,
    /// The times at which runs are compared, in s; if empty, eight times up to the end.
    pub at: Vec<String>,
    /// The column whose error is measured; the coordinates if `None`.
    pub of: Option<String>,
    /// The reference for the comparison: `energy`, `scene` or `run`.
    pub reference: Option<String>,
    /// The time limit, such as `30s`.
    pub budget: String,
}

/// Measurements of every method.
#[derive(Clone, Debug)]
pub struct Accuracy {
    /// `accuracy.csv`.
    pub table: Vec<u8>,
    /// The report of the command.
    pub text: String,
    /// The source of the exact values.
    pub reference: String,
    /// The accuracy goals, each with a sentence about the cheapest method.
    pub recommendations: Vec<(String, String)>,
    /// `accuracy.svg`, or the reason why there is no picture.
    pub figure: Result<String, String>,
    /// Warnings about the measurements.
    pub warnings: Vec<String>,
}

impl LoadedScene {
    /// Measures run time and error of every method: `qrm accuracy`.
    ///
    /// # Errors
    /// An option is invalid, or no method reaches the end.
    pub fn accuracy(&self, options: &AccuracyOptions) -> Result<Accuracy, Error> {
        let begun = Instant::now();
        let setup = self.setup(&options.run)?;
        let deadline = begun + budget(&options.budget)?;
        let of = options.of.as_deref().map(|name| column(&setup, name)).transpose()?;
        let reference = options.reference.as_deref().map(reference).transpose()?;
        let study = Study::new(&setup, &options.at, of, reference, deadline)?;
        Ok(Accuracy {
            table: study.csv()?,
            text: study.table(&setup),
            reference: study.origin(),
            recommendations: study.recommendations(),
            figure: study.figure(&setup).svg().map_err(|reason| reason.to_string()),
            warnings: study.warnings(&options.budget).iter().map(ToString::to_string).collect(),
        })
    }
}

/// Finds a reference by its name.
fn reference(name: &str) -> Result<ReferenceKind, Error> {
    ReferenceKind::from_str(name, false).map_err(|_| {
        let kinds = ReferenceKind::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let names: Vec<String> = kinds.map(|kind| kind.get_name().to_owned()).collect();
        Error::usage(format!("there is no reference `{name}`")).help(format!("references: {}", names.join(", ")))
    })
}
