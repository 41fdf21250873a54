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
    /// The options of each run but its method.
    pub run: RunOptions,
    /// The times at which runs are compared, in s; eight up to the end if there are none.
    pub at: Vec<String>,
    /// The column whose error counts; the coordinates if `None`.
    pub of: Option<String>,
    /// The reference that runs are compared with: `energy`, `scene` or `run`.
    pub reference: Option<String>,
    /// The time that may be taken, such as `30s`.
    pub budget: String,
}

/// Measurements of every method.
#[derive(Clone, Debug)]
pub struct Accuracy {
    /// `accuracy.csv`.
    pub table: Vec<u8>,
    /// The report of the command.
    pub text: String,
    /// The origin of the exact values.
    pub reference: String,
    /// Each goal with the cheapest method for it, in a sentence.
    pub recommendations: Vec<(String, String)>,
    /// `accuracy.svg`; the reason if there is no picture.
    pub figure: Result<String, String>,
    /// Doubts that the measurements leave.
    pub warnings: Vec<String>,
}

impl LoadedScene {
    /// Measures run time and error of every method: `qrm accuracy`.
    ///
    /// # Errors
    /// An option is wrong, or no method gets to the end.
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

/// The reference of this name.
fn reference(name: &str) -> Result<ReferenceKind, Error> {
    ReferenceKind::from_str(name, false).map_err(|_| {
        let kinds = ReferenceKind::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let names: Vec<String> = kinds.map(|kind| kind.get_name().to_owned()).collect();
        Error::usage(format!("there is no reference `{name}`")).help(format!("references: {}", names.join(", ")))
    })
}
