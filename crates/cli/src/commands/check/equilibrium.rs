//! Positions at rest, and the forces that balance the loads there.

use qrm_core::Mechanism;
use qrm_scene::names::suggestion;
use qrm_scene::scene::Quantity;
use qrm_sim::analysis::{NoEquilibrium, static_equilibrium};
use qrm_sim::position::Start;

use super::motors::Motors;
use crate::error::Error;
use crate::format::{position, quantity, unit_of_force};
use crate::options::number;
use crate::setup::Setup;

/// The largest distance of a position from the start, in turns.
const MAX_TURNS: f64 = 100.0;

/// Values of given coordinates.
type Wanted = Vec<(usize, f64)>;

/// Reads `phi2=45deg` or `phi=0.5,s=0.1`. A repeated coordinate begins another position.
pub(super) fn positions(mechanism: &dyn Mechanism, texts: &[String]) -> Result<Vec<Wanted>, Error> {
    let mut positions: Vec<Wanted> = Vec::new();
    for text in texts {
        for part in text.split(',') {
            let (place, value) = value(mechanism, text, part)?;
            match positions.last_mut() {
                Some(last) if last.iter().all(|(other, _)| *other != place) => last.push((place, value)),
                _ => positions.push(vec![(place, value)]),
            }
        }
    }
    Ok(positions)
}

fn value(mechanism: &dyn Mechanism, text: &str, part: &str) -> Result<(usize, f64), Error> {
    let is_given = Start::new(mechanism).given;
    let coordinates = mechanism.description().coordinates;
    let given: Vec<&str> = (0..coordinates.len()).filter(|&i| is_given[i]).map(|i| coordinates[i].name).collect();
    let wrong = |why: String, help: String| Error::usage(format!("`--static {text}`: {why}")).help(help);
    let Some(first) = given.first() else {
        let help = "move one from `solve` to `given` there; without degree of freedom there is one position only, and \
                    `qrm run` writes its forces"
            .to_owned();
        return Err(wrong("[initial] gives no coordinate that could be held elsewhere".to_owned(), help));
    };
    let Some((name, value)) = part.split_once('=') else {
        return Err(wrong(format!("`{part}` has no `=`"), format!("write `--static {first}=45deg`")));
    };
    let name = name.trim();
    // A released drive may have the same name as the coordinate that it prescribes.
    let places = || (0..coordinates.len()).filter(|&i| coordinates[i].name == name);
    let Some(place) = places().find(|&i| is_given[i]).or_else(|| places().next()) else {
        let help = suggestion(name, given.iter().copied(), || format!("these can be given: {}", given.join(", ")));
        return Err(wrong(format!("there is no coordinate `{name}`"), help));
    };
    if !is_given[place] {
        let help = format!("give one that does not: {}", given.join(", "));
        return Err(wrong(format!("`{name}` follows from the constraints"), help));
    }
    let option = format!("--static {name}");
    let value = number(&option, value.trim(), coordinates[place].unit)?;
    if coordinates[place].unit == "rad" && value.abs() > MAX_TURNS * std::f64::consts::TAU {
        return Err(wrong(format!("more than {MAX_TURNS} turns"), "take whole turns off".to_owned()));
    }
    Ok((place, value))
}

/// A note that loads which depend on time are evaluated at the start.
pub(super) fn when(setup: &Setup) -> &'static str {
    let values = setup.scene.loads.iter().flat_map(|load| load.kind.forces());
    let mut names = values.flat_map(|value| value.names());
    if names.any(|name| *name == Quantity::Time) { " at t = 0" } else { "" }
}

/// The forces that hold a position, as text.
pub(super) fn text(setup: &Setup, mechanism: &dyn Mechanism, wanted: &[(usize, f64)]) -> Result<String, Error> {
    let description = mechanism.description();
    let motors = Motors::new(setup);
    let rest = static_equilibrium(mechanism, wanted, &|q, dq| motors.work(q, dq))
        .map_err(|reason| no_equilibrium(setup, mechanism, &reason))?;
    let is_given = Start::new(mechanism).given;
    let role =
        if setup.mechanism().is_driven() { "instead of the drive" } else { "in addition to the loads of the scene" };
    let role = format!("{role}{}", motors.left_out());
    let mut text = format!("{} at rest{}\n\n", description.name, when(setup));
    let mut line = |name: &str, value: f64, unit: &str, more: &str| {
        let also = if unit == "rad" { format!("= {}", quantity(value, unit)) } else { more.to_owned() };
        let digits = if value == 0.0 || (1e-3..1e9).contains(&value.abs()) {
            format!("{:.10}", value + 0.0)
        } else {
            format!("{value:.10e}")
        };
        text += format!("  {name:12} {digits:>20} {unit:6} {also}").trim_end();
        text += "\n";
    };
    for (coordinate, value) in setup.description.coordinates.iter().zip(&rest.q) {
        line(coordinate.name, *value, coordinate.unit, "");
    }
    for (i, coordinate) in description.coordinates.iter().enumerate().filter(|(i, _)| is_given[*i]) {
        let name = format!("on {}", coordinate.name);
        line(&name, rest.forces[i], &unit_of_force(coordinate.unit), &format!("{role}, holds it at rest"));
    }
    for (output, value) in setup.scene.outputs.iter().zip(&rest.outputs) {
        if !output.kind.needs_motion(&setup.scene) {
            line(&output.name, *value, &output.unit, &output.doc);
        }
    }
    if !motors.left_out().is_empty() {
        text += "\n  outputs count the torques of motors at standstill\n";
    }
    Ok(text)
}

fn no_equilibrium(setup: &Setup, mechanism: &dyn Mechanism, reason: &NoEquilibrium) -> Error {
    let description = mechanism.description();
    match reason {
        NoEquilibrium::NotAssembled(reason) => setup.not_assembled(reason),
        NoEquilibrium::Singular => {
            Error::usage("the start is singular: it does not determine which way the mechanism goes")
                .help("give another start in [initial]")
        }
        NoEquilibrium::Driven => Error::usage("a constraint depends on time"),
        NoEquilibrium::NotFinite => Error::usage("forces at this position are not finite")
            .help("the position is a limit of the mechanism, or a formula leaves its domain"),
        NoEquilibrium::LimitPosition { q, constraint } => {
            let at = position(description, q);
            let why = constraint.map_or_else(
                || "another branch begins there".to_owned(),
                |i| format!("constraint `{}` cannot be closed beyond", description.constraints[i].name),
            );
            Error::usage(format!("the position cannot be reached: the mechanism locks at {at}")).help(why)
        }
    }
}
