//! A sweep whose rows are kept in memory.

use qrm_sim::columns::Column;

use super::options::RunOptions;
use super::scene::LoadedScene;
use crate::commands::sweep::{Axes, Cell, Designs, Field, Row, THREADS, by_lanes, self_check, threads};
use crate::error::Error;
use crate::gpu::Processor;
use crate::memory::require_room;
use crate::setup::Setup;

/// The designs of a sweep.
#[derive(Clone, Debug, Default)]
pub struct SweepOptions {
    /// The options of each run.
    pub run: RunOptions,
    /// The values of the varied parameters.
    pub vary: Vec<(String, Vec<f64>)>,
    /// Whether design `k` takes value `k` of every parameter, instead of a combination.
    pub is_paired: bool,
    /// Whether the extremes of the outputs are omitted.
    pub no_extremes: bool,
    /// Whether error estimates are omitted.
    pub no_error_estimate: bool,
    /// The number of cores; all if `None`.
    pub threads: Option<u32>,
    /// The processor that runs the designs.
    pub device: Processor,
}

/// The table of a sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The columns with their numbers or texts, a value for each design.
    pub columns: Vec<(Column<()>, Values)>,
    /// The problems of the table found by separate runs of some designs.
    pub warnings: Vec<String>,
}

/// The values of a column.
#[derive(Clone, Debug)]
pub enum Values {
    /// Integers; zero if unknown.
    Whole(Vec<u64>),
    /// Numbers; not a number if unknown.
    Number(Vec<f64>),
    /// Texts.
    Text(Vec<String>),
}

impl LoadedScene {
    /// Runs many designs: `qrm sweep`. An interrupted sweep has fewer rows.
    ///
    /// # Errors
    /// An option is invalid. Designs that fail are rows with a reason.
    pub fn sweep(&self, options: &SweepOptions) -> Result<Sweep, Error> {
        let (scene, start, how) = options.run.parsed()?;
        if !start.start.is_empty() {
            return Err(Error::usage("a sweep begins at the start of the scene").help("leave out `start`"));
        }
        let setup = Setup::without_rewrites(self.found(), &scene, &by_lanes(&how))?;
        let axes = if options.is_paired { Axes::paired } else { Axes::combinations };
        let axes = axes(setup.description, options.vary.clone())?;
        let designs = Designs {
            has_extremes: !options.no_extremes,
            estimate_error: !options.no_error_estimate,
            ..Designs::new(setup, axes)?
        };
        let threads = match options.threads {
            Some(asked) if !THREADS.contains(&asked.into()) => {
                let (least, most) = (THREADS.start(), THREADS.end());
                return Err(Error::usage(format!("`--threads` must be from {least} to {most}, but is {asked}")));
            }
            asked => threads(asked),
        };
        let count = designs.count();
        let designs = designs.on(options.device, (count, threads))?;
        let columns = designs.columns();
        check_memory(designs.count(), columns.len())?;
        let mut values: Vec<Values> = columns.iter().map(|column| Values::new(column.kind, designs.count())).collect();
        designs.run(
            (0, designs.count()),
            threads,
            |rows| rows,
            |rows: Vec<Row>| {
                for cells in rows {
                    values.iter_mut().zip(cells.cells).for_each(|(values, cell)| values.push(cell));
                }
                Ok(())
            },
        )?;
        let notes = designs.setup.notes.iter().map(ToString::to_string);
        let checked: Option<String> = match self_check::compare(&designs, (0, designs.count())) {
            Ok(agreement) => agreement.warning().map(|warning| warning.to_string()),
            Err(difference) => Some(difference.error().to_string()),
        };
        let failure = designs.gpu_failure().map(|failure| failure.to_string());
        let warnings = notes.chain(checked).chain(failure).collect();
        let column = |Column { name, unit, doc, .. }: Column<Field>| Column { name, unit, doc, kind: () };
        Ok(Sweep { columns: columns.into_iter().map(column).zip(values).collect(), warnings })
    }
}

/// Refuses a table that exceeds the memory of the machine.
fn check_memory(rows: usize, columns: usize) -> Result<(), Error> {
    // A value takes 8 bytes here and 8 in copies made by callers; texts take at most a few times that.
    let bytes = rows.saturating_mul(columns + 4).saturating_mul(16);
    let what = format!("{rows} designs with {columns} columns");
    require_room(bytes, &what, "vary fewer values, or let `qrm sweep` write a file")
}

impl Values {
    /// Creates an empty column.
    fn new(field: Field, count: usize) -> Self {
        match field {
            Field::Design | Field::Steps => Self::Whole(Vec::with_capacity(count)),
            Field::Status | Field::Reason => Self::Text(Vec::with_capacity(count)),
            _ => Self::Number(Vec::with_capacity(count)),
        }
    }

    fn push(&mut self, cell: Cell) {
        match self {
            Self::Whole(values) => values.push(if let Cell::Whole(value) = cell { value } else { 0 }),
            Self::Number(values) => values.push(if let Cell::Number(value) = cell { value } else { f64::NAN }),
            Self::Text(values) => values.push(if let Cell::Text(value) = cell { value } else { String::new() }),
        }
    }
}
