//! The documentation of generated code, identical in all languages.

use qrm_core::NamedTape;
use qrm_core::named_tape::{Argument, Function};
use qrm_scene::scene::{Body, Constraint, Coordinate, Load, Parameter, Point, Scene};

use crate::source_excerpts::SourceExcerpts;

/// The documentation of the struct of the parameters.
pub(crate) const PARAMETERS: &str = "The numbers of the scene that can be changed, under their names in the scene.";
/// The documentation of the struct of the constants.
pub(crate) const CONSTANTS: &str = "Values that depend on parameters alone, computed once.";
/// The documentation of the struct of a position.
pub(crate) const POSITION: &str = "What follows from the position alone.";

/// The documentation of a parameter.
pub(crate) fn parameter(p: &Parameter) -> String {
    let unit = if p.unit.is_empty() { String::new() } else { format!(" ({})", p.unit) };
    format!("{}{unit}", if p.doc.is_empty() { &p.name } else { &p.doc })
}

/// The documentation of a function: its purpose, its arguments, and its cost.
pub(crate) fn function(scene: &Scene, tape: &NamedTape, function: &Function) -> String {
    let mut text = function.doc.clone();
    let is_plain = |argument: &Argument| !matches!(argument, Argument::Position | Argument::Angles);
    if function.arguments.iter().all(is_plain) {
        let arguments: Vec<String> = function.arguments.iter().map(|argument| described(scene, *argument)).collect();
        text += &format!("\n\nArguments: {}.", arguments.join(", "));
    }
    text += &format!("\n\nOperations: {}.", tape.operations(function));
    text
}

/// The description of an argument with the names of its numbers.
fn described(scene: &Scene, argument: Argument) -> String {
    let coordinates =
        |suffix: &str| -> Vec<String> { scene.coordinates.iter().map(|c| format!("{}{suffix}", c.name)).collect() };
    let constraints = || scene.constraints.iter().map(|c| c.name.clone()).collect::<Vec<String>>();
    let (name, of) = match argument {
        Argument::Time => return "`t` in s".to_owned(),
        Argument::Coordinates => ("q", coordinates("")),
        Argument::Rates => ("qd", coordinates("_dot")),
        Argument::Accelerations => ("qdd", coordinates("_ddot")),
        Argument::Multipliers => ("multipliers", constraints()),
        Argument::Residuals => ("residuals", constraints()),
        Argument::Position | Argument::Angles => ("", Vec::new()),
    };
    format!("`{name} = [{}]`", of.join(", "))
}

/// The documentation of the mechanism, from the scene.
pub(crate) fn mechanism(scene: &Scene, source: &str) -> String {
    let words = SourceExcerpts { source };
    let mut text = if scene.doc.is_empty() { scene.name.clone() } else { scene.doc.clone() };
    let mut list = |title: &str, items: Vec<String>| {
        if !items.is_empty() {
            text += &format!("\n\n{title}:\n- {}", items.join("\n- "));
        }
    };
    let coordinate = |c: &Coordinate| format!("`{}`{}", c.name, after_name(&[&c.doc, &c.unit]));
    list("Coordinates", scene.coordinates.iter().map(coordinate).collect());
    let point = |p: &Point| format!("`{} = {}`", p.name, words.pair(&p.position));
    list("Points", scene.points.iter().map(point).collect());
    let body = |b: &Body| format!("`{}`: {}", b.name, words.body(b));
    list("Bodies", scene.bodies.iter().map(body).collect());
    let constraint =
        |c: &Constraint| format!("`{}`: `{} = 0`{}", c.name, words.formula(&c.residual), after_name(&[&c.doc]));
    list("Loops", scene.constraints.iter().map(constraint).collect());
    let load = |l: &Load| format!("`{}`: {}", l.name, words.load(&l.kind));
    list("Loads", scene.loads.iter().map(load).collect());
    text + "\n\nThe struct holds its parameters, and what depends on them alone."
}

/// Joins the nonempty words that follow a name.
fn after_name(words: &[&str]) -> String {
    words.iter().filter(|word| !word.is_empty()).map(|word| format!(", {word}")).collect()
}

/// The lines of a documentation text; formulae in it are indented by four spaces.
pub(crate) fn lines(doc: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut in_formulae = false;
    for line in doc.lines() {
        match line.starts_with("```") {
            true => in_formulae = !in_formulae,
            false if in_formulae => lines.push(format!("    {line}")),
            false => lines.push(line.to_owned()),
        }
    }
    lines
}
