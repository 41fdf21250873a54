//! `qrm check`

mod limits;
mod motion;
mod rest;
mod turn;

use super::Failure;
use super::arguments::CheckArguments;
use super::setup::Setup;
use crate::scenes::Scenes;

/// Says what can be known of a mechanism beyond one run of it.
pub(super) fn check(scenes: &Scenes, arguments: &CheckArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.scene, &arguments.method)?;
    if !arguments.at_rest.is_empty() {
        for position in rest::positions(&setup, &arguments.at_rest)? {
            super::say(&rest::rest(&setup, &position)?);
        }
        return Ok(());
    }
    let (facts, problem) = facts(&setup)?;
    let width = facts.iter().map(|fact| fact.topic.len()).max().unwrap_or(0);
    let mut text = format!("{}: {}\n", setup.description.name, setup.description.doc);
    for Fact { topic, lines } in &facts {
        let topics = std::iter::once(topic.as_str()).chain(std::iter::repeat(""));
        text.push('\n');
        for (topic, line) in topics.zip(lines) {
            text += &format!("  {topic:width$}  {line}\n");
        }
    }
    super::say(&text);
    problem.map_or(Ok(()), |problem| Err(Failure::Run(problem)))
}

/// What is known about one topic.
pub(super) struct Fact {
    pub(super) topic: String,
    pub(super) lines: Vec<String>,
}

impl Fact {
    fn new(topic: &str, lines: impl Into<Vec<String>>) -> Self {
        Self { topic: topic.to_owned(), lines: lines.into() }
    }
}

/// Everything but positions at rest that were asked for, and why the scene's own run did not do what was asked.
pub(super) fn facts(setup: &Setup) -> Result<(Vec<Fact>, Option<String>), Failure> {
    let mut facts = turn::facts(setup)?;
    let (of_motion, problem) = motion::facts(setup)?;
    facts.extend(of_motion);
    Ok((facts, problem))
}

/// A number in eight digits or so, however small it is.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e7).contains(&value.abs()) {
        // Adding zero makes -0 the same as 0.
        format!("{:.7}", value + 0.0)
    } else {
        format!("{value:.7e}")
    }
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
fn unit_of_force(unit: &str) -> String {
    match unit {
        "m" => "N".to_owned(),
        "rad" => "N m".to_owned(),
        other => format!("J/{other}"),
    }
}
