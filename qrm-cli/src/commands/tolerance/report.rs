//! The results of tolerances as text and tables.

use qrm_view::figure::Figure;
use serde::Serialize;

use super::parameter::TolerancedParameter;
use super::samples::Samples;
use super::{Options, Quantity, figure};
use crate::commands::sweep::Designs;
use crate::error::Error;
use crate::format::{counted, full, number};
use crate::output::{Named, csv};

/// What tolerances do, in all forms.
pub(super) struct Report<'r> {
    pub(super) designs: &'r Designs,
    pub(super) parameters: &'r [TolerancedParameter],
    pub(super) quantities: &'r [Quantity],
    pub(super) samples: &'r Samples,
    pub(super) options: &'r Options,
}

/// `tolerance.json`
#[derive(Serialize)]
pub(super) struct Summary {
    scene: &'static str,
    samples: usize,
    failed: usize,
    distribution: &'static str,
    seed: u64,
    parameters: Named<Varied>,
    quantities: Named<Effect>,
}

#[derive(Serialize)]
struct Varied {
    unit: &'static str,
    value: f64,
    tolerance: f64,
}

#[derive(Serialize)]
struct Effect {
    unit: String,
    nominal: f64,
    linear: Linear,
    worst_case: [f64; 2],
    monte_carlo: MonteCarlo,
}

#[derive(Serialize)]
struct Linear {
    standard_deviation: f64,
    worst_case: [f64; 2],
    derivatives: Named<f64>,
    shares: Named<f64>,
}

#[derive(Serialize)]
struct MonteCarlo {
    samples: usize,
    mean: f64,
    standard_deviation: f64,
    minimum: f64,
    quantile_0_135_percent: f64,
    median: f64,
    quantile_99_865_percent: f64,
    maximum: f64,
    shares: Named<f64>,
}

/// Parameters with a smaller share than this are not printed.
const LEAST_SHARE: f64 = 0.005;
/// Most parameters that are printed for a quantity.
const MOST_PARAMETERS: usize = 4;

impl Report<'_> {
    /// The contents of `tolerance.json`.
    pub(super) fn summary(&self) -> Summary {
        let varied = |parameter: &TolerancedParameter| {
            let TolerancedParameter { unit, value, tolerance, .. } = *parameter;
            (parameter.name.clone(), Varied { unit, value, tolerance })
        };
        Summary {
            scene: self.designs.setup.description.name,
            samples: self.samples.count(),
            failed: self.samples.failed,
            distribution: self.options.distribution.name(),
            seed: self.options.seed,
            parameters: Named(self.parameters.iter().map(varied).collect()),
            quantities: Named(
                self.quantities.iter().map(|quantity| (quantity.name.clone(), self.effect(quantity))).collect(),
            ),
        }
    }

    fn effect(&self, quantity: &Quantity) -> Effect {
        let named = |values: &[f64]| {
            let names = self.parameters.iter().map(|parameter| parameter.name.clone());
            Named(names.zip(values.iter().copied()).collect())
        };
        let (standard_deviation, shares) = quantity.linear(self.parameters, self.options.distribution);
        let nominal = quantity.nominal;
        let products = quantity.derivatives.iter().zip(self.parameters);
        let reach: f64 = products.map(|(by, parameter)| (by * parameter.tolerance).abs()).sum();
        let own = &quantity.statistics;
        let [minimum, quantile_0_135_percent, median, quantile_99_865_percent, maximum] = own.quantiles;
        Effect {
            unit: quantity.unit.clone(),
            nominal,
            linear: Linear {
                standard_deviation,
                worst_case: [nominal - reach, nominal + reach],
                derivatives: named(&quantity.derivatives),
                shares: named(&shares),
            },
            worst_case: quantity.worst,
            monte_carlo: MonteCarlo {
                samples: own.count,
                mean: own.mean,
                standard_deviation: own.deviation,
                minimum,
                quantile_0_135_percent,
                median,
                quantile_99_865_percent,
                maximum,
                shares: named(&own.correlations),
            },
        }
    }

    /// The results as a table.
    pub(super) fn text(&self) -> String {
        let mut rows = vec![["", "nominal", "linear", "Monte Carlo", "worst case", "due to"].map(str::to_owned)];
        for quantity in self.quantities {
            let Quantity { name, unit, nominal, worst, statistics, .. } = quantity;
            let (deviation, shares) = quantity.linear(self.parameters, self.options.distribution);
            let name = if unit.is_empty() { name.clone() } else { format!("{name}, {unit}") };
            let spread = |deviation: f64| format!("+-{:.2e}", 3.0 * deviation);
            let [least, most] = worst.map(|worst| format!("{:+.2e}", worst - nominal));
            rows.push([
                name,
                number(*nominal),
                spread(deviation),
                spread(statistics.deviation),
                format!("{least} {most}"),
                self.ranking(&shares),
            ]);
        }
        let widths: Vec<usize> =
            (0..6).map(|k| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0)).collect();
        let line = |row: &[String; 6]| {
            let cells = row.iter().zip(&widths).enumerate().map(|(k, (cell, &width))| match k {
                0 | 5 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            });
            format!("  {}", cells.collect::<Vec<_>>().join("  ")).trim_end().to_owned()
        };
        let Options { distribution, .. } = self.options;
        let count = counted(self.samples.count() as u64, "sample");
        let mut lines = vec![
            format!(
                "{}: {count}, {}; +- is three standard deviations",
                self.designs.setup.description.name,
                distribution.name()
            ),
            String::new(),
        ];
        lines.extend(rows.iter().map(line));
        if let (failed @ 1.., Some(reason)) = (self.samples.failed, &self.samples.reason) {
            lines.push(format!("\nwarning: {} failed: {reason}", counted(failed as u64, "sample")));
        }
        lines.push(String::new());
        lines.join("\n")
    }

    /// The parameters by their shares, the largest first.
    fn ranking(&self, shares: &[f64]) -> String {
        let mut ranked: Vec<(&str, f64)> =
            self.parameters.iter().map(|parameter| parameter.name.as_str()).zip(shares.iter().copied()).collect();
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
        let large = ranked.into_iter().filter(|(_, share)| *share >= LEAST_SHARE).take(MOST_PARAMETERS);
        large.map(|(name, share)| format!("{name} {:.0} %", 100.0 * share)).collect::<Vec<_>>().join(", ")
    }

    /// The samples as a table.
    ///
    /// # Errors
    /// The table could not be made.
    pub(super) fn csv(&self) -> Result<Vec<u8>, Error> {
        let names = self.parameters.iter().map(|parameter| parameter.name.as_str());
        let names: Vec<&str> = names.chain(self.quantities.iter().map(|quantity| quantity.name.as_str())).collect();
        let Samples { first, values, .. } = self.samples;
        let rows = (0..self.samples.count()).map(|i| {
            let inputs = self.designs.axes.values(first + i);
            inputs.into_iter().chain(values.iter().map(|values| values[i])).map(full).collect::<Vec<String>>()
        });
        csv(&names, rows)
    }

    /// The histograms.
    pub(super) fn figure(&self) -> Figure {
        figure::figure(self.designs.setup.description.name, self.quantities, &self.samples.values)
    }
}
