//! `qrm check`

mod limits;
mod motion;
mod rest;
mod turn;

use super::setup::Setup;
use super::{CheckArguments, Failure};
use crate::scenes::Scenes;

/// Says what can be known of a mechanism beyond one run of it.
pub(super) fn check(scenes: &Scenes, arguments: &CheckArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.motion)?;
    if !arguments.at_rest.is_empty() {
        let positions = arguments.at_rest.iter().map(|text| rest::position(&setup, text));
        for position in positions.collect::<Result<Vec<_>, _>>()? {
            super::say(&rest::rest(&setup, &position)?);
        }
        return Ok(());
    }
    super::say(&facts(&setup)?);
    Ok(())
}

/// Everything but positions at rest that were asked for.
pub(super) fn facts(setup: &Setup) -> Result<String, Failure> {
    let mut text = format!("{}: {}\n", setup.description.name, setup.description.doc);
    text += &turn::facts(setup)?;
    text += &motion::facts(setup)?;
    Ok(text)
}

/// An angle in degrees, a length as it is.
fn shown(value: f64, unit: &str) -> String {
    if unit == "rad" {
        format!("{:.4} deg", value.to_degrees())
    } else {
        format!("{value:.7} {unit}").trim_end().to_owned()
    }
}

/// The unit of a generalized force.
fn unit_of_force(unit: &str) -> &'static str {
    if unit == "m" { "N" } else { "N m" }
}
