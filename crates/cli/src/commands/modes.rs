//! `qrm modes`

pub(super) mod failure;
mod pictures;
pub(super) mod report;
pub(super) mod start;
mod table;
mod text;

use clap::Args;
use qrm_core::{Mechanism, Model};
use qrm_sim::analysis::{Equilibrium, Modes, NoModes, equilibria, modes};
use qrm_sim::position::Start;

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
    let mechanism = setup.mechanism();
    let all = found(&setup, &*mechanism, start, !options.at.is_empty(), !options.no_others)?;
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

/// The contents of `modes.json`, with other equilibria where they are wanted.
pub(crate) fn json(setup: &Setup, at: &[String], others: bool) -> Result<String, Error> {
    let mechanism = setup.mechanism();
    let all = found(setup, &*mechanism, start::start(setup, at)?, !at.is_empty(), others)?;
    Ok(serde_json::to_string(&ModesReport::new(setup, &*mechanism, all)?)?)
}

/// An equilibrium with its modes, or why there are none.
type WithModes = (Equilibrium, Result<Modes, Error>);

/// Equilibria with their modes, that near the start first; `is_asked` as in [`start::nearest`].
fn found(
    setup: &Setup,
    mechanism: &dyn Mechanism,
    start: Start,
    is_asked: bool,
    others: bool,
) -> Result<Vec<WithModes>, Error> {
    let tape = setup.model.tape();
    let no_modes = |reason: NoModes| failure::error(setup, reason);
    let nearest = start::nearest(setup, mechanism, &start, is_asked).map_err(no_modes)?;
    let found = if others { equilibria(mechanism, tape, Some(start)).map_err(no_modes)? } else { vec![nearest] };
    let mut all = Vec::new();
    for (place, equilibrium) in found.into_iter().enumerate() {
        let modes = modes(mechanism, tape, &equilibrium).map_err(no_modes);
        if place == 0 && modes.is_err() {
            return modes.map(|_| all);
        }
        all.push((equilibrium, modes));
    }
    Ok(all)
}

/// The scene with its parameters.
pub(super) fn setup(models: &'static [Model], name: &SceneName, set: &[String]) -> Result<Setup, Error> {
    let scene = SceneOptions { name: name.clone(), set: set.to_vec(), step: None, end_time: None, until: None };
    Setup::new(models, &scene, &MethodOptions::default())
}
