//! Positions at rest: what balances the loads there.

use qrm_scene::names::suggestion;
use qrm_scene::scene::{LoadKind, OutputKind, Quantity, Value};

use super::super::setup::Setup;
use super::super::{Failure, settings, words};
use super::{shown, unit_of_force};
use crate::rest::NoRest;

/// Farther from the start a position is not looked for.
const MOST_TURNS: f64 = 100.0;

/// Values of coordinates that the scene gives.
type Wanted = Vec<(usize, f64)>;

/// Reads `phi2=45deg` or `phi=0.5,s=0.1`. A coordinate that is asked for again begins another position.
pub(super) fn positions(setup: &Setup, texts: &[String]) -> Result<Vec<Wanted>, Failure> {
    let mut positions: Vec<Wanted> = Vec::new();
    for text in texts {
        for part in text.split(',') {
            let (place, value) = value(setup, text, part)?;
            match positions.last_mut() {
                Some(last) if last.iter().all(|(other, _)| *other != place) => last.push((place, value)),
                _ => positions.push(vec![(place, value)]),
            }
        }
    }
    Ok(positions)
}

fn value(setup: &Setup, text: &str, part: &str) -> Result<(usize, f64), Failure> {
    let is_given = setup.scene.given();
    let coordinates = setup.description.coordinates;
    let given: Vec<&str> = (0..coordinates.len()).filter(|&i| is_given[i]).map(|i| coordinates[i].name).collect();
    let wrong = |why: String, help: String| Failure::Use(format!("error: `--static {text}`: {why}\n  = help: {help}"));
    let Some(first) = given.first() else {
        let help = "its forces at rest need no `--static`: they are what `qrm run` writes".to_owned();
        return Err(wrong("the mechanism has no freedom, so it has one position only".to_owned(), help));
    };
    let Some((name, value)) = part.split_once('=') else {
        return Err(wrong(format!("`{part}` has no `=`"), format!("write `--static {first}=45deg`")));
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
    if coordinates[place].unit != "rad" && value.trim().ends_with("deg") {
        return Err(wrong(format!("`{name}` is no angle"), format!("give it in {}", coordinates[place].unit)));
    }
    let value = match value.trim().strip_suffix("deg") {
        Some(degrees) => settings::number(&option, degrees.trim())?.to_radians(),
        None => settings::number(&option, value.trim())?,
    };
    if coordinates[place].unit == "rad" && value.abs() > MOST_TURNS * std::f64::consts::TAU {
        return Err(wrong(format!("more than {MOST_TURNS} turns"), "take whole turns off".to_owned()));
    }
    Ok((place, value))
}

/// Loads that depend on time are taken at its beginning; said where there are such.
pub(super) fn when(setup: &Setup) -> &'static str {
    let values = setup.text.loads.iter().flat_map(|load| match &load.kind {
        LoadKind::Force { force, .. } => force.iter().collect(),
        LoadKind::Torque { torque, .. } => vec![torque],
        LoadKind::Spring { force, friction, .. } => force.iter().chain(friction.iter().map(|(size, _)| size)).collect(),
        LoadKind::Gravity(_) => Vec::new(),
    });
    let mut names = values.flat_map(|value: &Value| value.names());
    if names.any(|name| *name == Quantity::Time) { " at t = 0" } else { "" }
}

/// What holds a position.
pub(super) fn rest(setup: &Setup, wanted: &[(usize, f64)]) -> Result<String, Failure> {
    let description = &setup.description;
    let rest = setup.scene.rest(&setup.replace(), wanted).map_err(|reason| no_rest(setup, &reason))?;
    let is_given = setup.scene.given();
    let mut text = format!("{} at rest{}\n\n", description.name, when(setup));
    let mut line = |name: &str, value: f64, unit: &str, more: &str| {
        let also = if unit == "rad" { format!("= {}", shown(value, unit)) } else { more.to_owned() };
        let digits = if value == 0.0 || (1e-3..1e9).contains(&value.abs()) {
            format!("{:.10}", value + 0.0)
        } else {
            format!("{value:.10e}")
        };
        text += format!("  {name:12} {digits:>20} {unit:6} {also}").trim_end();
        text += "\n";
    };
    for (coordinate, value) in description.coordinates.iter().zip(&rest.q) {
        line(coordinate.name, *value, coordinate.unit, "");
    }
    for (i, coordinate) in description.coordinates.iter().enumerate().filter(|(i, _)| is_given[*i]) {
        let name = format!("on {}", coordinate.name);
        line(&name, rest.forces[i], &unit_of_force(coordinate.unit), "beside the loads of the scene, holds it at rest");
    }
    for (output, value) in setup.text.outputs.iter().zip(&rest.outputs) {
        if !matches!(output.kind, OutputKind::Rate(_) | OutputKind::SecondRate(_) | OutputKind::LoadPower(_)) {
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
        NoRest::Driven => {
            "error: a constraint depends on time: there is no position that the mechanism could be held in\n  \
             = help: leave the constraint out to see what balances the loads at rest"
                .to_owned()
        }
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
