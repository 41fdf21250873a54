//! `qrm tolerance`

mod derivatives;
mod histogram;
mod monte_carlo;
mod motions;
mod nominal;
mod parameter;
mod report;
mod slope;
mod statistics;
mod table;
mod worst_case;

use clap::{Args, ValueEnum};
use qrm_core::Model;

use super::sweep::{by_lanes, threads};
use crate::error::Error;
use crate::options::{MethodOptions, OutFolder, SceneOptions};
use crate::output::{check_target, print, save, save_json};
use crate::setup::Setup;
use derivatives::Derived;
use monte_carlo::Samples;
use motions::Motions;
use nominal::Nominal;
use parameter::TolerancedParameter;
use report::Report;
use slope::Slope;
use statistics::Statistics;
use worst_case::{Probes, WorstCase};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    how: MethodOptions,
    /// Give a parameter a tolerance, `NAME=VALUE+-TOLERANCE`, or `NAME=+-TOLERANCE` about the value that it has; may be
    /// repeated
    #[arg(long, value_name = "NAME=VALUE+-TOL", required = true, allow_hyphen_values = true)]
    vary: Vec<String>,
    /// The column of `qrm sweep` to analyse, such as `x6_max` or `end_time`; may be repeated [default: the extremes of all
    /// outputs]
    #[arg(long, value_name = "NAME")]
    of: Vec<String>,
    /// Number of Monte Carlo samples
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(100..=10_000_000))]
    samples: u32,
    /// How parameters vary within their tolerances
    #[arg(long, value_enum, default_value_t = Distribution::Normal)]
    distribution: Distribution,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Write all samples too: samples.csv
    #[arg(long)]
    keep_samples: bool,
    /// How many cores to use [default: all]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=4096))]
    threads: Option<u32>,
    #[command(flatten)]
    out: OutFolder,
}

/// How a parameter varies within its tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Distribution {
    /// About the value with a third of the tolerance as standard deviation
    Normal,
    /// Evenly, from the value minus the tolerance to the value plus it
    Uniform,
}

impl Distribution {
    /// The standard deviation of a parameter against its tolerance.
    fn deviation(self) -> f64 {
        match self {
            Self::Normal => 1.0 / 3.0,
            Self::Uniform => 1.0 / 3.0_f64.sqrt(),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Uniform => "uniform",
        }
    }
}

/// A quantity of a motion and what tolerances do to it.
struct Quantity {
    /// The column of a sweep.
    name: String,
    unit: String,
    nominal: Nominal,
    /// How it changes with each parameter that has a tolerance.
    slopes: Vec<Slope>,
    worst: WorstCase,
    statistics: Statistics,
    /// Changes below this one are not known.
    resolution: f64,
    /// The error of its values in the samples, as far as it was seen.
    sample_error: f64,
}

/// Differences of values are known to this part of their size, or to the tolerance of the method.
const RESOLUTION: f64 = 1e-9;

impl Quantity {
    /// The standard deviation by slopes, and the share of each parameter in its square.
    fn linear(&self, parameters: &[TolerancedParameter], distribution: Distribution) -> (f64, Vec<f64>) {
        let square = |(slope, parameter): (&Slope, &TolerancedParameter)| {
            (slope.value() * parameter.tolerance * distribution.deviation()).powi(2)
        };
        let squares: Vec<f64> = self.slopes.iter().zip(parameters).map(square).collect();
        let sum: f64 = squares.iter().sum();
        (sum.sqrt(), squares.iter().map(|square| if sum > 0.0 { square / sum } else { 0.0 }).collect())
    }
}

/// Propagates tolerances of parameters to quantities of a motion: by linearization, at worst, and by Monte Carlo.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let mut parameters =
        options.vary.iter().map(|text| TolerancedParameter::new(text)).collect::<Result<Vec<_>, _>>()?;
    let how = by_lanes(&options.how);
    let setup = Setup::new(models, &options.scene, &how)?;
    // The parameters that have tolerances are set where derivatives are taken, and varied in the samples.
    let mut scene = options.scene.clone();
    scene.set.extend(parameters.iter().filter_map(TolerancedParameter::assignment));
    parameter::check(&parameters, &setup)?;
    let nominal = Setup::from_found(scene.name.find(models)?, &scene, &how)?;
    parameter::complete(&mut parameters, &nominal);
    let folder = options.out.folder(&setup.path);
    let [json, picture, csv] = ["tolerance.json", "tolerance.svg", "samples.csv"].map(|name| folder.join(name));
    [&json, &picture, &csv].into_iter().try_for_each(|path| check_target(path))?;

    let derived = derivatives::find(&nominal, &parameters, &options.of)?;
    let columns: Vec<&str> = derived.iter().map(|derived| derived.name.as_str()).collect();
    let mut motions = Motions::new(setup, &parameters, &columns, threads(options.threads))?;
    let scene = nominal.description.name;
    let resolution = nominal.settings.tolerance().map_or(RESOLUTION, |tolerance| tolerance.max(RESOLUTION));
    let nominal = nominal::run(&nominal, &motions.fields())?;
    let (mut probes, slopes) = Probes::run(&mut motions, &parameters, &derived, &nominal, resolution)?;
    let samples = Samples::run(&mut motions, &parameters, &mut probes, options)?;
    let quantity = |(i, (derived, slopes)): (usize, (Derived, Vec<Slope>))| Quantity {
        name: derived.name,
        unit: derived.unit,
        nominal: nominal[i],
        slopes,
        worst: probes.worst_case(i),
        statistics: Statistics::new(&samples.values[i], &samples.points),
        resolution: resolution * nominal[i].size,
        sample_error: samples.errors[i],
    };
    let quantities: Vec<Quantity> = derived.into_iter().zip(slopes).enumerate().map(quantity).collect();
    let report =
        Report { scene, parameters: &parameters, quantities: &quantities, probes: &probes, samples: &samples, options };
    save_json(&json, &report.summary())?;
    let mut written = vec![json];
    let figure = report.figure();
    // Quantities that no tolerance changes have no histogram.
    if !figure.panels.is_empty() {
        save(&picture, figure.svg().map_err(|reason| Error::run(reason.to_string()))?.as_bytes())?;
        written.push(picture);
    }
    if options.keep_samples {
        save(&csv, &report.csv()?)?;
        written.push(csv);
    }
    let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    print(&format!("{}\nwrote {}", table::text(&report), written.join(", ")));
    Ok(())
}
