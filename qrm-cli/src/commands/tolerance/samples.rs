//! Monte Carlo samples of mechanisms with tolerances.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::parameter::TolerancedParameter;
use super::statistics::Statistics;
use super::{Distribution, Options, Quantity};
use crate::commands::sweep::{Cell, Designs, Row};
use crate::error::Error;
use crate::progress::{DesignProgress, interrupted, watch_interrupts};

/// Draws the parameters of all designs: the nominal one, two worst cases for each quantity, then random samples.
pub(super) fn draw(
    parameters: &[TolerancedParameter],
    quantities: &[Quantity],
    options: &Options,
) -> Vec<(String, Vec<f64>)> {
    let count = options.samples as usize;
    let mut values: Vec<(String, Vec<f64>)> = parameters
        .iter()
        .enumerate()
        .map(|(i, TolerancedParameter { name, value, tolerance, .. })| {
            let mut values = Vec::with_capacity(designs_before_samples(quantities.len()) + count);
            values.push(*value);
            for Quantity { derivatives, .. } in quantities {
                // A parameter that does nothing stays where it is.
                let rise = if derivatives[i] == 0.0 { 0.0 } else { tolerance.copysign(derivatives[i]) };
                values.extend([value - rise, value + rise]);
            }
            (name.clone(), values)
        })
        .collect();
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    for _ in 0..count {
        for ((_, values), TolerancedParameter { value, tolerance, .. }) in values.iter_mut().zip(parameters) {
            values.push(match options.distribution {
                Distribution::Normal => {
                    value + tolerance * options.distribution.deviation() * random.sample::<f64, _>(StandardNormal)
                }
                Distribution::Uniform => value + tolerance * random.random_range(-1.0..=1.0),
            });
        }
    }
    values
}

/// The design without tolerances, and two for each quantity at worst.
fn designs_before_samples(quantities: usize) -> usize {
    1 + 2 * quantities
}

/// The ends of the samples.
pub(super) struct Samples {
    /// The number of the first design that is a sample.
    pub(super) first: usize,
    /// For each quantity its value in each sample; not a number where the sample failed.
    pub(super) values: Vec<Vec<f64>>,
    /// The samples that failed, and why the first of them did.
    pub(super) failed: usize,
    pub(super) reason: Option<String>,
}

impl Samples {
    /// The number of samples, failed ones included.
    pub(super) fn count(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// Runs all designs, and completes the quantities by what they show.
    ///
    /// # Errors
    /// The design without tolerances or one at worst fails, or the user interrupts.
    pub(super) fn run(designs: &Designs, quantities: &mut [Quantity], threads: usize) -> Result<Self, Error> {
        let columns = designs.columns();
        let place = |name: &str| columns.iter().position(|column| column.name == name).unwrap_or(0);
        let places: Vec<usize> = quantities.iter().map(|quantity| place(&quantity.name)).collect();
        let reason = place("reason");
        let first = designs_before_samples(quantities.len());
        let count = designs.count();
        let mut values: Vec<Vec<f64>> = places.iter().map(|_| Vec::with_capacity(count)).collect();
        let mut failures = Vec::new();
        watch_interrupts();
        let progress = DesignProgress::new(count, 0);
        let done = designs.run(
            (0, count),
            threads,
            |rows| rows,
            |rows: Vec<Row>| {
                progress.add(rows.len());
                for row in rows {
                    if let (false, Cell::Text(why)) = (row.is_done, &row.cells[reason]) {
                        let design = values[0].len();
                        if design < first {
                            return Err(fails(design, why));
                        }
                        failures.push(why.clone());
                    }
                    for (values, place) in values.iter_mut().zip(&places) {
                        let value = if let Cell::Number(value) = row.cells[*place] { value } else { f64::NAN };
                        values.push(if row.is_done { value } else { f64::NAN });
                    }
                }
                Ok(())
            },
        )?;
        drop(progress);
        if done < count || interrupted() {
            return Err(Error::run(format!("interrupted after {done} of {count} designs")));
        }
        if failures.len() == count - first {
            let why = failures.first().map_or("", String::as_str);
            return Err(Error::run(format!("every sample fails: {why}")).help("choose smaller tolerances"));
        }
        let inputs: Vec<Vec<f64>> = (0..designs.axes.values(0).len())
            .map(|i| (first..count).map(|design| designs.axes.values(design)[i]).collect())
            .collect();
        for (i, (quantity, values)) in quantities.iter_mut().zip(&mut values).enumerate() {
            quantity.nominal = values[0];
            // A nonlinear quantity may be at an extreme without tolerances.
            let ends = [values[0], values[1 + 2 * i], values[2 + 2 * i]];
            quantity.worst =
                [ends.into_iter().fold(f64::INFINITY, f64::min), ends.into_iter().fold(f64::NEG_INFINITY, f64::max)];
            values.drain(..first);
            quantity.statistics = Statistics::of(values, &inputs);
        }
        let (failed, reason) = (failures.len(), failures.into_iter().next());
        Ok(Self { first, values, failed, reason })
    }
}

/// The error of a design that is no sample.
fn fails(design: usize, why: &str) -> Error {
    let which = if design == 0 { "without tolerances" } else { "at the ends of its tolerances" };
    Error::run(format!("the mechanism {which} fails: {why}")).help("choose other values or smaller tolerances")
}
