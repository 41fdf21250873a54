//! `qrm tolerance`

mod derivatives;
mod histogram;
mod monte_carlo;
mod motions;
mod nominal;
mod options;
mod parameter;
mod quantity;
mod report;
mod slope;
mod statistics;
mod table;
mod worst_case;

use qrm_core::Model;

use super::sweep::by_lanes;
use crate::error::Error;
use crate::memory::require_room;
use crate::output::{check_target, print, save, save_json};
use crate::setup::Setup;
use derivatives::Derived;
use monte_carlo::Samples;
use motions::Motions;
pub(crate) use options::Options;
use parameter::TolerancedParameter;
use quantity::Quantity;
use report::Report;
use slope::Slope;
use statistics::Statistics;
use worst_case::Probes;

/// The relative resolution of differences of values, unless the tolerance of the method is larger.
const RESOLUTION: f64 = 1e-9;

/// Propagates tolerances of parameters to quantities of a motion: by linearization, worst case and Monte Carlo.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let how = by_lanes(&options.how);
    let setup = Setup::new(models, &options.scene, &how)?;
    let new = |text: &String| TolerancedParameter::new(text, setup.description);
    let mut parameters = options.vary.iter().map(new).collect::<Result<Vec<_>, _>>()?;
    // Parameters with tolerances are set for the derivatives, and varied in the samples.
    let mut scene = options.scene.clone();
    scene.set.extend(parameters.iter().filter_map(TolerancedParameter::assignment));
    parameter::check(&parameters, &setup)?;
    let nominal = Setup::from_found(scene.name.find(models)?, &scene, &how)?;
    parameter::complete(&mut parameters, &nominal);
    let folder = options.out.folder(&setup.path);
    let [json, picture, csv] = ["tolerance.json", "tolerance.svg", "samples.csv"].map(|name| folder.join(name));
    [&json, &picture, &csv].into_iter().try_for_each(|path| check_target(path))?;

    let derived = derivatives::find(&nominal, &parameters, &options.of)?;
    // Samples, a copy of the parameters, and what the statistics of a quantity need.
    let (columns, samples) = (2 * parameters.len() + derived.len() + 5, options.samples as usize);
    let what = format!("{samples} samples of {columns} columns");
    require_room(samples.saturating_mul(columns).saturating_mul(8), &what, "choose fewer `--samples`")?;
    let columns: Vec<&str> = derived.iter().map(|derived| derived.name.as_str()).collect();
    let mut motions = Motions::new(setup, &parameters, &columns, options)?;
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
    // Quantities that do not depend on the tolerances have no histogram.
    if !figure.panels.is_empty() {
        save(&picture, figure.svg().map_err(|reason| Error::run(reason.to_string()))?.as_bytes())?;
        written.push(picture);
    }
    if options.keep_samples {
        save(&csv, &report.csv()?)?;
        written.push(csv);
    }
    let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    print(&format!("{}\n{}wrote {}", table::text(&report), motions.on_gpu(), written.join(", ")));
    Ok(())
}
