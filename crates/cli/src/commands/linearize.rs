//! `qrm linearize`

mod diagram;
mod matlab;
mod names;
mod report;
mod response;

use clap::Args;
use qrm_core::Model;
use qrm_sim::analysis::{LinearModel, LinearOutput, Modes, NoModes, linear_model, modes};
use qrm_sim::position::Start;

use super::modes::{failure, setup, start};
use crate::error::Error;
use crate::options::{OutFolder, SceneName, optional_positive};
use crate::output::{check_target, print, save, save_json};
use crate::setup::Setup;
use report::LinearReport;
use response::FrequencyResponse;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    name: SceneName,
    /// Input: a parameter of loads; may be repeated
    #[arg(long, value_name = "NAME", required = true)]
    input: Vec<String>,
    /// Output: a coordinate, its rate NAME_dot, its acceleration NAME_ddot, or an output of the scene; may be repeated
    #[arg(long, value_name = "NAME", required = true)]
    output: Vec<String>,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    /// Linearize about the equilibrium near these values of coordinates that the scene gives at its start, such as
    /// `phi=30deg` [default: its start]
    #[arg(long, value_name = "NAME=VALUE,..", allow_hyphen_values = true)]
    at: Vec<String>,
    /// Lowest frequency of the response, in Hz [default: a tenth of the lowest natural frequency]
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
    from: Option<String>,
    /// Highest frequency of the response, in Hz [default: ten times the highest natural frequency]
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
    to: Option<String>,
    /// Number of frequencies, evenly spread on a logarithmic scale
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    points: u32,
    #[command(flatten)]
    out: OutFolder,
}

/// Writes a linear model of a scene about an equilibrium, and its frequency response.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let setup = setup(models, &options.name, &options.set)?;
    let start = start::start(&setup, &options.at)?;
    let inputs = names::inputs(&setup, &options.input)?;
    let outputs = names::outputs(&setup, &options.output)?;
    let [from, to] = [("--from", &options.from), ("--to", &options.to)]
        .map(|(option, text)| optional_positive(option, text.as_ref(), "Hz"));
    let (from, to) = (from?, to?);
    let folder = options.out.subfolder(&setup.path, "linear");
    let names = ["linear.json", "linear.m", "frequency_response.csv", "frequency_response.svg"];
    let paths = names.map(|file| folder.join(file));
    paths.iter().try_for_each(|path| check_target(path))?;
    let (report, model, modes) = linearized(&setup, &start, !options.at.is_empty(), (&inputs, &outputs))?;
    let response = FrequencyResponse::new(&model, &modes, [from, to], options.points)?;
    let mut saved = vec![
        save_json(&paths[0], &report),
        save(&paths[1], matlab::script(&report).as_bytes()),
        save(&paths[2], &response.csv(&report)?),
    ];
    let mut warning = String::new();
    let mut files: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    match diagram::figure(&report, &response).svg() {
        Ok(drawn) => saved.push(save(&paths[3], drawn.as_bytes())),
        Err(reason) => {
            warning = format!("\n\nwarning: no picture: {reason}");
            files.pop();
        }
    }
    print(&(report.text(&response, &files) + &warning));
    Error::all(saved.into_iter().filter_map(Result::err).collect())
}

/// The contents of `linear.json`.
pub(crate) fn json(setup: &Setup, at: &[String], inputs: &[String], outputs: &[String]) -> Result<String, Error> {
    let start = start::start(setup, at)?;
    let (inputs, outputs) = (names::inputs(setup, inputs)?, names::outputs(setup, outputs)?);
    let (report, ..) = linearized(setup, &start, !at.is_empty(), (&inputs, &outputs))?;
    Ok(serde_json::to_string(&report)?)
}

/// The linear model about the equilibrium near a start; `is_asked` as in [`start::nearest`].
fn linearized(
    setup: &Setup,
    start: &Start,
    is_asked: bool,
    (inputs, outputs): (&[usize], &[LinearOutput]),
) -> Result<(LinearReport, LinearModel, Modes), Error> {
    let (mechanism, tape) = (setup.mechanism(), setup.model.tape());
    let no_model = |reason: NoModes| failure::error(setup, reason);
    let at = start::nearest(setup, &*mechanism, start, is_asked).map_err(no_model)?;
    let modes = modes(&*mechanism, tape, &at).map_err(no_model)?;
    let model = linear_model(&*mechanism, tape, (&at, &modes), inputs, outputs).map_err(no_model)?;
    Ok((LinearReport::new(setup, (&at, &modes), &model, (inputs, outputs)), model, modes))
}
