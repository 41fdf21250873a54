//! Positions at rest: what balances the loads there.

use qrm_codegen::names::suggestion;
use qrm_codegen::scene::OutputKind;

use super::super::setup::Setup;
use super::super::{Failure, settings, words};
use super::{shown, unit_of_force};
use crate::rest::NoRest;

/// Reads `phi2=45deg` or `phi=0.5,s=0.1`.
pub(super) fn position(setup: &Setup, text: &str) -> Result<Vec<(usize, f64)>, Failure> {
    let is_given = setup.scene.given();
    let coordinates = setup.description.coordinates;
    let given: Vec<&str> = (0..coordinates.len()).filter(|&i| is_given[i]).map(|i| coordinates[i].name).collect();
    let wrong = |why: String, help: String| Failure::Use(format!("error: `--static {text}`: {why}\n  = help: {help}"));
    let example = format!("write `--static {}=45deg`", given.first().unwrap_or(&"NAME"));
    let mut position = Vec::new();
    for part in text.split(',') {
        let Some((name, value)) = part.split_once('=') else {
            return Err(wrong(format!("`{part}` has no `=`"), example));
        };
        let name = name.trim();
        let Some(place) = coordinates.iter().position(|c| c.name == name) else {
            let help = suggestion(name, given.iter().copied(), || format!("the scene gives: {}", given.join(", ")));
            return Err(wrong(format!("there is no coordinate `{name}`"), help));
        };
        if !is_given[place] {
            let help = format!("give what [initial] gives: {}", given.join(", "));
            return Err(wrong(format!("`{name}` follows from the constraints"), help));
        }
        let option = format!("--static {name}");
        let value = match value.trim().strip_suffix("deg") {
            Some(degrees) => settings::number(&option, degrees.trim())?.to_radians(),
            None => settings::number(&option, value.trim())?,
        };
        position.push((place, value));
    }
    Ok(position)
}

/// What holds a position.
pub(super) fn rest(setup: &Setup, wanted: &[(usize, f64)]) -> Result<String, Failure> {
    let description = &setup.description;
    let rest = setup.scene.rest(&setup.replace(), wanted).map_err(|reason| no_rest(setup, &reason))?;
    let is_given = setup.scene.given();
    let mut text = format!("{} at rest\n\n", description.name);
    let mut line = |name: &str, value: f64, unit: &str, more: &str| {
        let also = if unit == "rad" { format!("= {}", shown(value, unit)) } else { more.to_owned() };
        text += format!("  {name:12} {value:>20.10} {unit:6} {also}").trim_end();
        text += "\n";
    };
    for (coordinate, value) in description.coordinates.iter().zip(&rest.q) {
        line(coordinate.name, *value, coordinate.unit, "");
    }
    for (i, coordinate) in description.coordinates.iter().enumerate().filter(|(i, _)| is_given[*i]) {
        let name = format!("on {}", coordinate.name);
        line(&name, rest.forces[i], unit_of_force(coordinate.unit), "beside the loads of the scene, holds it at rest");
    }
    for (output, value) in setup.text.outputs.iter().zip(&rest.outputs) {
        if !matches!(output.kind, OutputKind::Rate(_) | OutputKind::SecondRate(_)) {
            line(&output.name, *value, &output.unit, &output.doc);
        }
    }
    Ok(text)
}

fn no_rest(setup: &Setup, reason: &NoRest) -> Failure {
    let description = &setup.description;
    Failure::Use(match reason {
        NoRest::NotAssembled(reason) => words::not_assembled_report(reason, description, &setup.text, &setup.path),
        NoRest::Singular => "error: the start is singular: it does not say which way the mechanism goes\n  \
             = help: give another start in [initial]"
            .to_owned(),
        NoRest::NotFinite => "error: forces at this position are not finite\n  \
             = help: the mechanism is locked there, or a formula leaves its domain"
            .to_owned(),
        NoRest::Lock { q, constraint } => {
            let at = description.coordinates.iter().zip(q).map(|(c, q)| format!("{} = {}", c.name, shown(*q, c.unit)));
            let why = constraint.map_or_else(
                || "another branch begins there".to_owned(),
                |i| format!("constraint `{}` cannot be closed beyond", description.constraints[i].name),
            );
            format!(
                "error: the position cannot be reached: the mechanism locks at {}\n  = help: {why}",
                at.collect::<Vec<_>>().join(", ")
            )
        }
    })
}
