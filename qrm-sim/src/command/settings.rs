//! What the command line sets: parameters, numbers, conditions, each checked against the scene.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use qrm_core::Description;
use qrm_scene::diagnostic::Report;
use qrm_scene::evaluate::evaluate;
use qrm_scene::names::suggestion;
use qrm_scene::parser::parse_formula;

use super::Failure;
use crate::scenes::{Scene, Scenes};

/// The scene of this name.
pub(super) fn scene<'s>(scenes: &'s Scenes, name: &str) -> Result<&'s dyn Scene, Failure> {
    scenes.find(name).ok_or_else(|| {
        let names: Vec<&str> = scenes.iter().map(|s| s.description().name).collect();
        let help = suggestion(name, names.iter().copied(), || format!("scenes: {}", names.join(", ")));
        Failure::Use(format!("error: there is no scene `{name}`\n  = help: {help}"))
    })
}

/// Where the files of a command go.
pub(super) fn folder(description: &Description, out: Option<&Path>) -> PathBuf {
    out.map_or_else(|| PathBuf::from("out").join(description.name), Path::to_owned)
}

/// The parameters that `--set` changes.
pub(super) fn parameters(description: &Description, set: &[String]) -> Result<BTreeMap<String, f64>, Failure> {
    let mut values = BTreeMap::new();
    for assignment in set {
        let Some((name, value)) = assignment.split_once('=') else {
            return Err(Failure::Use(format!(
                "error: `--set {assignment}` has no `=`\n  = help: write `--set NAME=VALUE`"
            )));
        };
        let name = name.trim();
        known(description, name)?;
        values.insert(name.to_owned(), number(&format!("--set {name}"), value)?);
    }
    Ok(values)
}

pub(super) fn known(description: &Description, name: &str) -> Result<(), Failure> {
    let scene = description.name;
    if description.parameters.iter().any(|p| p.name == name) {
        return Ok(());
    }
    if description.left_out.contains(&name) {
        return Err(Failure::Use(format!(
            "error: parameter `{name}` is exactly zero in scene `{scene}`, so the generated code does without it\n  \
             = help: add `runtime = true` to `{name}` in scenes/{scene}.toml, or give it a value there, and build again"
        )));
    }
    let names: Vec<&str> = description.parameters.iter().map(|p| p.name).collect();
    let help = suggestion(name, names.iter().copied(), || format!("its parameters: {}", names.join(", ")));
    Err(Failure::Use(format!("error: scene `{scene}` has no parameter `{name}`\n  = help: {help}")))
}

/// A number, written as a number or as a formula of numbers and `pi`.
pub(super) fn number(option: &str, text: &str) -> Result<f64, Failure> {
    let wrong = |why: String| Failure::Use(format!("error: `{option}` needs a number, but `{text}` {why}"));
    let formula = parse_formula(text, 0, &[])
        .map_err(|finding| Failure::Use(Report::new(option, text, vec![finding]).to_string()))?;
    if let Some(name) = formula.names().find(|name| *name != "pi") {
        return Err(wrong(format!(
            "contains the name `{name}`\n  = help: only numbers, `pi` and functions can stand here"
        )));
    }
    let value = evaluate(&formula, |_| std::f64::consts::PI);
    if value.is_finite() { Ok(value) } else { Err(wrong(format!("gives {value}"))) }
}

/// A number above zero.
pub(super) fn positive(option: &str, text: &str) -> Result<f64, Failure> {
    let value = number(option, text)?;
    if value > 0.0 {
        return Ok(value);
    }
    Err(Failure::Use(format!("error: `{option}` must be above zero, but is {value}")))
}
