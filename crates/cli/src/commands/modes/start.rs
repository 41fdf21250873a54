//! Where the search for an equilibrium begins.

use qrm_core::Mechanism;
use qrm_scene::names::suggestion;
use qrm_sim::analysis::{Equilibrium, NoModes, equilibria, equilibrium};
use qrm_sim::position::Start;

use crate::error::Error;
use crate::options::number;
use crate::setup::Setup;

/// The scene's start with other values of its given coordinates, as in `phi=30deg` or `phi=0.5,s=0.1`.
pub(in crate::commands) fn start(setup: &Setup, texts: &[String]) -> Result<Start, Error> {
    let mut start = setup.start();
    let coordinates = setup.description.coordinates;
    let mut set: Vec<usize> = Vec::new();
    for text in texts {
        for part in text.split(',') {
            let given = || (0..coordinates.len()).filter(|&i| start.given[i]).map(|i| coordinates[i].name);
            let wrong = |why: String| Error::usage(format!("`--at {text}`: {why}"));
            let Some((name, value)) = part.split_once('=') else {
                let example = given().next().unwrap_or("NAME");
                return Err(wrong(format!("`{part}` has no `=`")).help(format!("write `--at {example}=30deg`")));
            };
            let name = name.trim();
            let Some(place) = (0..coordinates.len()).find(|&i| coordinates[i].name == name && start.given[i]) else {
                let list = || match &given().collect::<Vec<_>>()[..] {
                    [] => "the start gives no coordinate".to_owned(),
                    names => format!("given at the start: {}", names.join(", ")),
                };
                let help = suggestion(name, given(), list);
                let scene = setup.description.name;
                let why = if coordinates.iter().any(|coordinate| coordinate.name == name) {
                    format!("scene `{scene}` does not give `{name}` at its start: it follows from the constraints")
                } else {
                    format!("scene `{scene}` has no coordinate `{name}`")
                };
                return Err(wrong(why).help(help));
            };
            if set.contains(&place) {
                return Err(Error::given_twice(&format!("--at {name}")));
            }
            start.q[place] = number(&format!("--at {name}"), value.trim(), coordinates[place].unit)?;
            set.push(place);
        }
    }
    Ok(start)
}

/// The equilibrium near a start. Where the search from there ends without one, it is the nearest of those from other
/// positions, unless the start `is_asked` for.
///
/// # Errors
/// No equilibrium is found.
pub(in crate::commands) fn nearest(
    setup: &Setup,
    mechanism: &dyn Mechanism,
    start: &Start,
    is_asked: bool,
) -> Result<Equilibrium, NoModes> {
    let tape = setup.model.tape();
    match equilibrium(mechanism, tape, Some(start.clone())) {
        Err(reason @ NoModes::NotFound { .. }) if !is_asked => {
            equilibria(mechanism, tape, Some(start.clone()))?.into_iter().next().ok_or(reason)
        }
        found => found,
    }
}
