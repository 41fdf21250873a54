//! Why there is no equilibrium and no linear model, in words.

use qrm_sim::analysis::NoModes;

use crate::error::Error;
use crate::format::{position, unit_of_force};
use crate::setup::Setup;

/// The error of a search that found no equilibrium, or of a linear model that does not exist.
pub(in crate::commands) fn error(setup: &Setup, reason: NoModes) -> Error {
    let description = setup.description;
    let scene = description.name;
    let place = |q: &[f64]| position(description, q);
    match reason {
        NoModes::NotAssembled(reason) => setup.not_assembled(&reason),
        NoModes::Driven => {
            let driven = format!("a constraint of scene `{scene}` depends on time: it has no position of rest");
            Error::usage(driven).help("leave out what drives it; `qrm stability` linearizes along a motion")
        }
        NoModes::NoFreedom => Error::usage(
            "the mechanism has no degree of freedom: its motion follows from the constraints alone, and nothing in it \
             can oscillate",
        )
        .help("leave out what drives it to see how it moves freely"),
        NoModes::Redundant { rank } => setup.redundant(rank),
        NoModes::Singular { q } => Error::run(format!(
            "the position is singular: the constraints do not say which motions they allow at {}",
            place(&q)
        ))
        .help("seek another equilibrium with --at"),
        NoModes::Massless { q } => {
            Error::usage(format!("a motion that the constraints allow has no inertia at {}", place(&q)))
                .help("give each moving part a mass or an inertia")
        }
        NoModes::NotFinite { q } => {
            Error::run(format!("loads or masses, or their derivatives, are not finite at {}", place(&q)))
                .help("a formula leaves its domain there; seek another equilibrium with --at")
        }
        NoModes::NotFound { q, coordinate, residual } => {
            let coordinate = &description.coordinates[coordinate];
            Error::run(format!(
                "no equilibrium was found. Nearest is {}, where a force of {residual:.4e} {} on `{}` is not balanced",
                place(&q),
                unit_of_force(coordinate.unit),
                coordinate.name
            ))
            .help("begin nearer to one with --at; `qrm check --static` gives the forces that hold a position")
        }
        NoModes::NoEigenvalues => Error::run("the linear equations have no finite eigenvalues"),
        NoModes::OutputNotSmooth { output } => {
            let name = description.outputs[output].name;
            Error::usage(format!("`--output {name}`: `{name}` has no finite derivatives at the equilibrium"))
                .help("the size of a force that is zero there has none; choose a component")
        }
        NoModes::NotALoad { parameter, changes_constraints } => {
            let name = description.parameters[parameter].name;
            let what = if changes_constraints { "constraints" } else { "masses" };
            Error::usage(format!(
                "`--input {name}`: `{name}` changes the {what}, so that its rates would act on the mechanism too"
            ))
            .help("an input is a parameter of loads, such as a force or a torque")
        }
    }
}
