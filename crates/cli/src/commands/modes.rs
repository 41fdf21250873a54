//! `qrm modes`

pub(super) mod failure;
mod pictures;
mod report;
pub(super) mod start;
mod table;

use clap::Args;
use qrm_core::Model;
use qrm_sim::analysis::{NoModes, equilibria, modes};

use crate::error::Error;
use crate::options::{MethodOptions, OutFolder, SceneName, SceneOptions};
use crate::output::{check_target, print, save, save_json};
use crate::setup::Setup;
use report::ModesReport;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    name: SceneName,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    /// Seek the equilibrium near these values of coordinates that the scene gives at its start, such as `phi=30deg`
    /// [default: its start]
    #[arg(long, value_name = "NAME=VALUE,..", allow_hyphen_values = true)]
    at: Vec<String>,
    /// Seek no other equilibria
    #[arg(long)]
    no_others: bool,
    /// Draw no mode shapes
    #[arg(long)]
    no_figures: bool,
    #[command(flatten)]
    out: OutFolder,
}

/// Finds the equilibria of a scene and the modes about them, prints them and writes their files.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let setup = setup(models, &options.name, &options.set)?;
    let start = start::start(&setup, &options.at)?;
    let folder = options.out.subfolder(&setup.path, "modes");
    let [json, csv] = ["modes.json", "modes.csv"].map(|file| folder.join(file));
    check_target(&json)?;
    check_target(&csv)?;
    let (mechanism, tape) = (setup.mechanism(), setup.model.tape());
    let no_modes = |reason: NoModes| failure::error(&setup, reason);
    let nearest = start::nearest(&setup, &*mechanism, &start, !options.at.is_empty()).map_err(no_modes)?;
    let found =
        if options.no_others { vec![nearest] } else { equilibria(&*mechanism, tape, Some(start)).map_err(no_modes)? };
    let mut all = Vec::new();
    for (place, equilibrium) in found.into_iter().enumerate() {
        match modes(&*mechanism, tape, &equilibrium) {
            Ok(modes) => all.push((equilibrium, Ok(modes))),
            Err(reason) if place == 0 => return Err(no_modes(reason)),
            Err(reason) => all.push((equilibrium, Err(failure::error(&setup, reason)))),
        }
    }
    let drawn = match all.first() {
        Some((at, Ok(modes))) if !options.no_figures => {
            let first = modes.undamped.iter().take(pictures::MOST).enumerate();
            first.map(|(i, mode)| pictures::picture(&setup, &*mechanism, at, (i + 1, mode))).collect()
        }
        _ => Vec::new(),
    };
    let report = ModesReport::new(&setup, &*mechanism, all)?;
    let mut saved = vec![save_json(&json, &report), save(&csv, &table::csv(&report)?)];
    let mut files = vec![json, csv];
    let mut warnings = String::new();
    for (place, picture) in drawn.into_iter().enumerate() {
        let path = folder.join(format!("mode-{}.gif", place + 1));
        match picture {
            Ok(picture) => {
                saved.push(save(&path, &picture));
                files.push(path);
            }
            Err(reason) => warnings += &format!("\n\nwarning: {reason}"),
        }
    }
    print(&(report.text(&files) + &warnings));
    Error::all(saved.into_iter().filter_map(Result::err).collect())
}

/// The scene with its parameters.
pub(super) fn setup(models: &'static [Model], name: &SceneName, set: &[String]) -> Result<Setup, Error> {
    let scene = SceneOptions { name: name.clone(), set: set.to_vec(), step: None, end_time: None, until: None };
    Setup::new(models, &scene, &MethodOptions::default())
}
