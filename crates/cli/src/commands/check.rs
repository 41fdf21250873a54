//! `qrm check`

mod branches;
mod equilibrium;
mod full_turn;
mod mobility;
mod motion;
mod motors;
mod revolution;
mod transmission;

use clap::Args;
use qrm_core::{Mechanism, Model, QuantityDescription};
use qrm_sim::analysis::MechanismWithoutDrive;
use qrm_sim::position::Start;

use crate::error::Error;
use crate::format::heading;
use crate::options::{MethodOptions, SceneOptions};
use crate::output::print;
use crate::setup::Setup;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    method: MethodOptions,
    /// Only say what balances the loads at rest, at a position such as `phi2=45deg`; may be repeated
    #[arg(long = "static", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    at_rest: Vec<String>,
    /// Only list the positions at which it can be assembled
    #[arg(long, conflicts_with = "at_rest")]
    branches: bool,
}

/// Prints properties of a mechanism beyond those of a single run.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let setup = Setup::from_found(options.scene.name.find(models)?, &options.scene, &options.method)?;
    // The full check includes both as topics.
    if !options.at_rest.is_empty() || options.branches {
        setup.print_notes();
    }
    if !options.at_rest.is_empty() {
        let mechanism = released(&setup, &setup.scene.drives())?;
        for position in equilibrium::positions(&*mechanism, &options.at_rest)? {
            print(&equilibrium::text(&setup, &*mechanism, &position)?);
        }
        return Ok(());
    }
    if options.branches {
        print(&branches::text(&setup)?);
        return Ok(());
    }
    let (topics, problem) = report_lines(&setup)?;
    let width = topics.iter().map(|topic| topic.name.len()).max().unwrap_or(0);
    let mut text = format!("{}\n", heading(setup.description));
    for Topic { name, lines } in &topics {
        let names = std::iter::once(name.as_str()).chain(std::iter::repeat(""));
        text.push('\n');
        for (name, line) in names.zip(lines) {
            text += &format!("  {name:width$}  {line}\n");
        }
    }
    print(&text);
    problem.map_or(Ok(()), Err)
}

/// Lines about a topic.
pub(crate) struct Topic {
    pub(crate) name: String,
    pub(crate) lines: Vec<String>,
}

impl Topic {
    fn new(name: &str, lines: impl Into<Vec<String>>) -> Self {
        Self { name: name.to_owned(), lines: lines.into() }
    }
}

/// The lines about mobility, a revolution and the scene's own motion, and an error if its run failed.
pub(crate) fn report_lines(setup: &Setup) -> Result<(Vec<Topic>, Option<Error>), Error> {
    let mut topics = mobility::report_lines(setup)?;
    topics.extend(revolution::report_lines(setup)?);
    let (of_motion, problem) = motion::report_lines(setup)?;
    topics.extend(of_motion);
    Ok((topics, problem))
}

/// Creates the mechanism with some of its drives released.
fn released(setup: &Setup, drives: &[usize]) -> Result<Box<dyn Mechanism>, Error> {
    let release =
        |mechanism, drive: &usize| MechanismWithoutDrive::new(mechanism, *drive).map(|own| Box::new(own) as Box<_>);
    let released = drives.iter().try_fold(setup.mechanism(), release);
    released.map_err(|reason| setup.not_assembled(&reason))
}

/// The coordinates that the scene gives at its start, or that drives prescribe.
fn inputs(setup: &Setup) -> Result<Vec<QuantityDescription>, Error> {
    let mechanism = released(setup, &setup.scene.drives())?;
    let coordinates = mechanism.description().coordinates.iter().zip(Start::new(&*mechanism).given);
    Ok(coordinates.filter(|(_, given)| *given).map(|(coordinate, _)| *coordinate).collect())
}
