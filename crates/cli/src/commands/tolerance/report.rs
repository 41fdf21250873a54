//! The effect of tolerances as files.

use qrm_view::figure::Figure;
use serde::Serialize;

use super::histogram;
use super::monte_carlo::Samples;
use super::options::Options;
use super::parameter::TolerancedParameter;
use super::quantity::Quantity;
use super::worst_case::Probes;
use crate::error::Error;
use crate::format::full;
use crate::output::{Named, csv};

/// The effect of tolerances, for all forms of output.
pub(super) struct Report<'r> {
    pub(super) scene: &'static str,
    pub(super) parameters: &'r [TolerancedParameter],
    pub(super) quantities: &'r [Quantity],
    pub(super) probes: &'r Probes,
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
    /// The estimated error of the nominal value.
    error: Option<f64>,
    linear: Linear,
    worst_case: [f64; 2],
    /// The parameter values of the motions with these extremes.
    worst_case_at: [Named<f64>; 2],
    /// Whether all motions are consistent with a quantity that is monotonic in each parameter.
    monotonic: bool,
    monte_carlo: MonteCarlo,
}

#[derive(Serialize)]
struct Linear {
    standard_deviation: f64,
    worst_case: [f64; 2],
    /// The confirmed derivatives; `None` where other motions do not confirm one.
    derivatives: Named<Option<f64>>,
    /// The difference quotients over the full tolerances, which replace unconfirmed derivatives.
    differences: Named<f64>,
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
    /// The largest difference between a motion in lanes and the same motion run separately.
    error: f64,
    shares: Named<f64>,
}

impl Report<'_> {
    /// The contents of `tolerance.json`.
    pub(super) fn summary(&self) -> Summary {
        let varied = |parameter: &TolerancedParameter| {
            let TolerancedParameter { unit, value, tolerance, .. } = *parameter;
            (parameter.name.clone(), Varied { unit, value, tolerance })
        };
        Summary {
            scene: self.scene,
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
        let (standard_deviation, shares) = quantity.linear(self.parameters, self.options.distribution);
        let nominal = quantity.nominal.value;
        let slopes = &quantity.slopes;
        let products = slopes.iter().zip(self.parameters);
        let reach: f64 = products.map(|(slope, parameter)| (slope.value() * parameter.tolerance).abs()).sum();
        let own = &quantity.statistics;
        let [minimum, quantile_0_135_percent, median, quantile_99_865_percent, maximum] = own.quantiles;
        Effect {
            unit: quantity.unit.clone(),
            nominal,
            error: quantity.nominal.error,
            linear: Linear {
                standard_deviation,
                worst_case: [nominal - reach, nominal + reach],
                derivatives: self.named(slopes.iter().map(|slope| slope.is_confirmed.then_some(slope.derivative))),
                differences: self.named(slopes.iter().map(|slope| slope.difference_quotient)),
                shares: self.named(shares),
            },
            worst_case: quantity.worst.ends,
            worst_case_at: quantity
                .worst
                .designs
                .map(|design| self.named(self.probes.points.iter().map(|points| points[design]))),
            monotonic: quantity.worst.is_monotonic,
            monte_carlo: MonteCarlo {
                samples: own.count,
                mean: own.mean,
                standard_deviation: own.deviation,
                minimum,
                quantile_0_135_percent,
                median,
                quantile_99_865_percent,
                maximum,
                error: quantity.sample_error,
                shares: self.named(own.correlations.iter().copied()),
            },
        }
    }

    /// Pairs the values of all parameters with their names.
    fn named<T>(&self, values: impl IntoIterator<Item = T>) -> Named<T> {
        Named(self.parameters.iter().map(|parameter| parameter.name.clone()).zip(values).collect())
    }

    /// The samples as a table.
    ///
    /// # Errors
    /// The table could not be created.
    pub(super) fn csv(&self) -> Result<Vec<u8>, Error> {
        let names = self.parameters.iter().map(|parameter| parameter.name.as_str());
        let names: Vec<&str> = names.chain(self.quantities.iter().map(|quantity| quantity.name.as_str())).collect();
        let Samples { points, values, .. } = self.samples;
        let rows = (0..self.samples.count())
            .map(|i| points.iter().chain(values).map(|values| full(values[i])).collect::<Vec<String>>());
        csv(&names, rows)
    }

    /// The histograms.
    pub(super) fn figure(&self) -> Figure {
        histogram::figure(self.scene, self.quantities, &self.samples.values)
    }
}
