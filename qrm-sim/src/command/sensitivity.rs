//! `qrm sensitivity`

mod check;
mod quantities;
mod table;

use num_dual::Dual64;
use qrm_scene::evaluate::parameter_values;
use qrm_scene::names::suggestion;

use super::arguments::{MethodArguments, SensitivityArguments};
use super::setup::Setup;
use super::{Failure, settings, words};
use crate::scenes::{Replace, Scenes};
use crate::sensitivity::{NoSensitivity, Sensitivity, SensitivityEnd, SensitivityRequest};
use crate::trouble::breakdown;
use quantities::quantities;

/// Takes derivatives of a motion by parameters, checks them, prints and writes them.
pub(super) fn sensitivity(scenes: &Scenes, arguments: &SensitivityArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.scene, &MethodArguments::default())?;
    let by = by(&setup, &arguments.by)?;
    of(&setup, &arguments.of)?;
    let path = setup.folder(arguments.out.as_deref()).join("sensitivity.csv");
    // That of other settings would pass for this one's. If it is not there, or cannot be removed, writing will tell.
    let _ = std::fs::remove_file(&path);
    let found = derive(&setup, &by, &setup.replace(), setup.step())?;
    let rows = quantities(&setup, &found, &arguments.of);
    let doubts = if arguments.no_check { Vec::new() } else { check::check(&setup, &by, &rows, &arguments.of) };
    let bytes = table::csv(&rows, &by).map_err(|e| Failure::Run(format!("error: {}: {e}", path.display())))?;
    super::save(&path, &bytes)?;
    let mut text = table::printed(&setup, &rows, &by);
    text += &check::said(&doubts, setup.step());
    super::say(&format!("{text}\nwrote {} ({} rows)", path.display(), rows.len()));
    check::verdict(&doubts)
}

/// The parameters that are asked for, or all.
fn by(setup: &Setup, asked: &[String]) -> Result<Vec<&'static str>, Failure> {
    let all = || setup.description.parameters.iter().map(|parameter| parameter.name);
    asked.iter().try_for_each(|name| settings::known(&setup.description, name))?;
    let is_asked = |name: &&str| asked.is_empty() || asked.iter().any(|asked| asked == name);
    let by: Vec<&str> = all().filter(is_asked).collect();
    if by.is_empty() {
        return Err(Failure::Use(format!(
            "error: scene `{}` has no parameter\n  = help: give a number a name under [parameters]",
            setup.description.name
        )));
    }
    Ok(by)
}

fn of(setup: &Setup, asked: &[String]) -> Result<(), Failure> {
    let outputs = || setup.description.outputs.iter().map(|output| output.name).chain(["end"]);
    let Some(unknown) = asked.iter().find(|asked| !outputs().any(|output| output == asked.as_str())) else {
        return Ok(());
    };
    let help = suggestion(unknown, outputs(), || format!("outputs: {}", outputs().collect::<Vec<_>>().join(", ")));
    Err(Failure::Use(format!(
        "error: `--of {unknown}`: scene `{}` has no output of this name\n  = help: {help}",
        setup.description.name
    )))
}

/// The derivatives where parameters have other values, or steps another length.
fn derive(setup: &Setup, by: &[&str], replace: Replace, step: f64) -> Result<Sensitivity, Failure> {
    let condition = |seeded: &str, t: Dual64, q: &[Dual64], qd: &[Dual64]| {
        let number = |name: &str| replace(name).map(Dual64::from);
        let value = |name: &str| if name == seeded { seed(setup, replace, name) } else { number(name) };
        let parameters: Vec<Dual64> = parameter_values(&setup.text, value);
        let condition = setup.condition.as_ref();
        condition.map_or(Dual64::from(0.0), |c| c.value_in(&mut Vec::new(), &parameters, t, q, qd))
    };
    let end = match (setup.end_time, &setup.condition) {
        (Some(t), _) => Some(SensitivityEnd::Time(t)),
        (None, Some(_)) => Some(SensitivityEnd::Condition(&condition)),
        (None, None) => None,
    };
    let request = SensitivityRequest { by, step: Some(step), end };
    setup.scene.sensitivity(replace, &request).map_err(|reason| failure(setup, &reason))
}

/// The value of a parameter, with its derivative by itself.
fn seed(setup: &Setup, replace: Replace, name: &str) -> Option<Dual64> {
    let place = setup.description.parameters.iter().position(|parameter| parameter.name == name)?;
    setup.scene.parameters(replace).get(place).map(|value| Dual64::new(*value, 1.0))
}

fn failure(setup: &Setup, reason: &NoSensitivity) -> Failure {
    let name = setup.description.name;
    let message = match reason {
        NoSensitivity::NoStart(reason) => {
            return Failure::Use(words::no_start(reason, &setup.description, &setup.text, &setup.path));
        }
        NoSensitivity::Broken { t, reason } => {
            format!("the motion breaks off after t = {t} s: {}", breakdown(reason, &setup.description))
        }
        NoSensitivity::Singular { t } => format!(
            "after t = {t} s the mechanism comes near a position at which its constraints say too little, or the step is too long: the \
             motion is carried on there by means that have no derivatives\n  \
             = help: use a shorter --step, an earlier --end-time, or look with `qrm stability {name}` for singular positions"
        ),
        NoSensitivity::NotSmooth { t } => format!(
            "at or after t = {t} s some formula has no value, or no derivative\n  \
             = help: look for roots of what becomes zero there, and for powers with exponents below one"
        ),
        NoSensitivity::StoppedAtStart => {
            "the stop condition holds at the start: there is no motion\n  = help: end elsewhere with --until or --end-time".to_owned()
        }
        NoSensitivity::NotStopped { end_time } => format!(
            "the stop condition did not become true up to t = {end_time} s\n  = help: `qrm run {name}` says how near it came"
        ),
        NoSensitivity::Grazing { t } => format!(
            "the stop condition becomes true at t = {t} s without passing through zero there: the least change of a parameter may move the \
             end far, so it has no derivative\n  = help: end elsewhere with --until or --end-time"
        ),
        NoSensitivity::NoParameter { name: parameter } => format!("scene `{name}` has no parameter `{parameter}`"),
        NoSensitivity::NoFormulae => format!("scene `{name}` is not described by formulae of its parameters"),
    };
    Failure::Run(format!("error: no derivatives: {message}"))
}
