//! Motions of designs, run separately and in lanes.

use qrm_sim::batch::LaneCount;

use super::options::Options;
use super::parameter::TolerancedParameter;
use crate::commands::sweep::{Axes, Cell, Designs, Field, Row, threads};
use crate::error::Error;
use crate::format::counted;
use crate::progress::{Progress, interrupted, watch_interrupts};
use crate::setup::Setup;

/// Runs designs and extracts the quantities from their rows.
pub(super) struct Motions {
    designs: Designs,
    names: Vec<String>,
    /// The indices of the quantities in the rows.
    places: Vec<usize>,
    /// The index of the reason of a failure.
    reason: usize,
    threads: usize,
}

/// The results of several designs.
pub(super) struct Found {
    /// The values of each quantity in all designs; not a number where the design failed.
    pub(super) values: Vec<Vec<f64>>,
    /// The designs that failed, and the reasons.
    pub(super) failures: Vec<(usize, String)>,
}

impl Motions {
    /// Creates the motions of a scene with these varied parameters and these columns of a sweep.
    pub(super) fn new(
        setup: Setup,
        parameters: &[TolerancedParameter],
        columns: &[&str],
        options: &Options,
    ) -> Result<Self, Error> {
        let nominal = parameters.iter().map(|parameter| (parameter.name.clone(), vec![parameter.value])).collect();
        let axes = Axes::paired(setup.description, nominal)?;
        let designs = Designs { estimate_error: false, ..Designs::new(setup, axes)? };
        let threads = threads(options.threads);
        let designs = designs.on(options.device, (options.samples as usize, threads))?;
        let all = designs.columns();
        let place = |name: &str| all.iter().position(|column| column.name == name).unwrap_or(0);
        let places = columns.iter().map(|name| place(name)).collect();
        let names = parameters.iter().map(|parameter| parameter.name.clone()).collect();
        Ok(Self { names, places, reason: place("reason"), threads, designs })
    }

    /// Where the samples ran, and what failed there; empty without a GPU.
    pub(super) fn on_gpu(&self) -> String {
        let failure = self.designs.gpu_failure().map(|failure| format!("{}\n\n", failure.warning()));
        let on = self.designs.on_gpu("sample").map(|on| format!("samples {on}\n"));
        on.unwrap_or_default() + &failure.unwrap_or_default()
    }

    /// The sources of the quantities.
    pub(super) fn fields(&self) -> Vec<Field> {
        let columns = self.designs.columns();
        self.places.iter().map(|place| columns[*place].kind).collect()
    }

    /// Runs designs separately, like `qrm run`. `points` holds the values of each parameter in all designs.
    pub(super) fn alone(&mut self, points: &[Vec<f64>]) -> Result<Found, Error> {
        self.run(points, LaneCount::One, 0, "design")
    }

    /// Runs designs in lanes. The designs from `first` on are samples.
    pub(super) fn in_lanes(&mut self, points: &[Vec<f64>], first: usize) -> Result<Found, Error> {
        self.run(points, LaneCount::Most, first, "sample")
    }

    fn run(&mut self, points: &[Vec<f64>], lanes: LaneCount, first: usize, noun: &str) -> Result<Found, Error> {
        let named = self.names.iter().cloned().zip(points.iter().cloned()).collect();
        self.designs.axes = Axes::paired(self.designs.setup.description, named)?;
        self.designs.lanes = lanes;
        let count = self.designs.count();
        let mut found =
            Found { values: self.places.iter().map(|_| Vec::with_capacity(count)).collect(), failures: Vec::new() };
        watch_interrupts();
        let progress = Progress::designs(count, 0);
        let take = |rows: Vec<Row>| {
            progress.add(rows.len());
            rows.iter().for_each(|row| found.take(row, &self.places, self.reason));
            Ok(())
        };
        let done = self.designs.run((0, count), self.threads, |rows| rows, take)?;
        drop(progress);
        if done < count || interrupted() {
            let (done, all) = (done.saturating_sub(first), counted((count - first) as u64, noun));
            return Err(Error::run(format!("interrupted after {done} of {all}")));
        }
        Ok(found)
    }
}

impl Found {
    fn take(&mut self, row: &Row, places: &[usize], reason: usize) {
        if let (false, Cell::Text(why)) = (row.is_done, &row.cells[reason]) {
            self.failures.push((self.values.first().map_or(0, Vec::len), why.clone()));
        }
        for (values, place) in self.values.iter_mut().zip(places) {
            let value = if let Cell::Number(value) = row.cells[*place] { value } else { f64::NAN };
            values.push(if row.is_done { value } else { f64::NAN });
        }
    }
}
