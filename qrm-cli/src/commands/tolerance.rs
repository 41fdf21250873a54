//! `qrm tolerance`

mod figure;
mod parameter;
mod report;
mod samples;
mod statistics;

use std::collections::BTreeMap;

use clap::{Args, ValueEnum};
use qrm_core::Model;
use qrm_scene::names::suggestion;

use super::sensitivity::{Asked, Quantity as Derived};
use super::sweep::{Axes, Designs, by_lanes, threads};
use crate::error::Error;
use crate::options::{MethodOptions, OutFolder, SceneOptions};
use crate::output::{check_target, print, save, save_json};
use crate::setup::Setup;
use parameter::TolerancedParameter;
use report::Report;
use samples::Samples;
use statistics::Statistics;

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
    /// The value without tolerances.
    nominal: f64,
    /// The derivative by each parameter that has a tolerance.
    derivatives: Vec<f64>,
    /// The values with every parameter at the end of its tolerance that makes it smaller, and larger.
    worst: [f64; 2],
    statistics: Statistics,
}

impl Quantity {
    /// The standard deviation by derivatives, and the share of each parameter in its square.
    fn linear(&self, parameters: &[TolerancedParameter], distribution: Distribution) -> (f64, Vec<f64>) {
        let square = |(by, parameter): (&f64, &TolerancedParameter)| {
            (by * parameter.tolerance * distribution.deviation()).powi(2)
        };
        let squares: Vec<f64> = self.derivatives.iter().zip(parameters).map(square).collect();
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
    let nominal = Setup::new(models, &scene, &how)?;
    parameter::complete(&mut parameters, &nominal);
    let folder = options.out.of(&setup.path);
    let [json, picture, csv] = ["tolerance.json", "tolerance.svg", "samples.csv"].map(|name| folder.join(name));
    [&json, &picture, &csv].into_iter().try_for_each(|path| check_target(path))?;

    let mut quantities = with_derivatives(&nominal, &parameters, &options.of)?;
    let values = samples::draw(&parameters, &quantities, options);
    let axes = Axes::paired(setup.description, values)?;
    let designs = Designs { estimate_error: false, ..Designs::new(setup, axes)? };
    let samples = Samples::run(&designs, &mut quantities, threads(options.threads))?;
    let report =
        Report { designs: &designs, parameters: &parameters, quantities: &quantities, samples: &samples, options };
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
    print(&format!("{}\nwrote {}", report.text(), written.join(", ")));
    Ok(())
}

/// The quantities that are asked for, with their derivatives.
fn with_derivatives(setup: &Setup, parameters: &[TolerancedParameter], of: &[String]) -> Result<Vec<Quantity>, Error> {
    let names: Vec<String> = parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let found = Asked::new(setup, &names, &[], BTreeMap::new(), false)?.find(setup)?;
    let place = |name: &String| found.by.iter().position(|by| by == name).unwrap_or(0);
    let quantity = |row: &Derived| {
        let name = match (row.what, row.name.as_str()) {
            ("end", "t") => "end_time".to_owned(),
            ("end", name) if !setup.description.outputs.iter().any(|output| output.name == name) => name.to_owned(),
            ("minimum", name) => format!("{name}_min"),
            ("maximum", name) => format!("{name}_max"),
            _ => return None,
        };
        let derivatives = names.iter().map(|name| row.value.by[place(name)]).collect();
        let (unit, nominal) = (row.unit.clone(), row.value.value);
        let is_default = row.what != "end" || name == "end_time";
        Some((
            is_default,
            Quantity { name, unit, nominal, derivatives, worst: [nominal; 2], statistics: Statistics::default() },
        ))
    };
    let all: Vec<(bool, Quantity)> = found.quantities(setup).iter().filter_map(quantity).collect();
    let known = || all.iter().map(|(_, quantity)| quantity.name.as_str());
    if let Some(unknown) = of.iter().find(|of| !known().any(|name| name == of.as_str())) {
        let help = suggestion(unknown, known(), || format!("columns: {}", known().collect::<Vec<_>>().join(", ")));
        return Err(Error::usage(format!("`--of {unknown}`: no column of a sweep has this name")).help(help));
    }
    let is_asked = |(is_default, quantity): &(bool, Quantity)| {
        if of.is_empty() { *is_default } else { of.contains(&quantity.name) }
    };
    let chosen: Vec<Quantity> = all.into_iter().filter(is_asked).map(|(_, quantity)| quantity).collect();
    if chosen.is_empty() {
        return Err(Error::usage(format!("scene `{}` has no outputs", setup.description.name))
            .help("name a coordinate by `--of`, or give the scene outputs"));
    }
    Ok(chosen)
}
