//! Inputs and outputs by their names.

use qrm_scene::names::suggestion;
use qrm_sim::analysis::LinearOutput;

use crate::error::Error;
use crate::options::check_parameter;
use crate::setup::Setup;

/// The parameters of these names.
pub(super) fn inputs(setup: &Setup, names: &[String]) -> Result<Vec<usize>, Error> {
    check_twice("--input", names)?;
    let parameters = setup.description.parameters;
    let place = |name: &String| {
        check_parameter(setup.description, name)?;
        Ok(parameters.iter().position(|parameter| parameter.name == name).unwrap_or(0))
    };
    names.iter().map(place).collect()
}

/// The coordinates, rates, accelerations and outputs of these names.
pub(super) fn outputs(setup: &Setup, names: &[String]) -> Result<Vec<LinearOutput>, Error> {
    check_twice("--output", names)?;
    names.iter().map(|name| output(setup, name)).collect()
}

fn output(setup: &Setup, name: &str) -> Result<LinearOutput, Error> {
    let description = setup.description;
    let coordinate = |name: &str| description.coordinates.iter().position(|coordinate| coordinate.name == name);
    let output = description.outputs.iter().position(|output| output.name == name).map(LinearOutput::Output);
    let found = output
        .or_else(|| coordinate(name).map(LinearOutput::Coordinate))
        .or_else(|| coordinate(name.strip_suffix("_ddot")?).map(LinearOutput::Acceleration))
        .or_else(|| coordinate(name.strip_suffix("_dot")?).map(LinearOutput::Rate));
    found.ok_or_else(|| {
        let coordinates = description.coordinates.iter().map(|coordinate| coordinate.name);
        let names: Vec<&str> = coordinates.chain(description.outputs.iter().map(|output| output.name)).collect();
        let list = || {
            format!("coordinates and outputs: {}; NAME_dot and NAME_ddot are rates and accelerations", names.join(", "))
        };
        let scene = description.name;
        Error::usage(format!("`--output {name}`: scene `{scene}` has no coordinate or output `{name}`"))
            .help(suggestion(name, names.iter().copied(), list))
    })
}

fn check_twice(option: &str, names: &[String]) -> Result<(), Error> {
    match names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        Some((_, twice)) => Err(Error::given_twice(&format!("{option} {twice}"))),
        None => Ok(()),
    }
}
