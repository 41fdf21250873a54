//! `qrm check`

mod limits;
mod motion;
mod rest;
mod turn;

use super::setup::Setup;
use super::{CheckArguments, Failure};
use crate::scenes::Scenes;

/// Says what can be known of a mechanism beyond one run of it.
pub(super) fn check(scenes: &Scenes, arguments: &CheckArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.motion)?;
    if !arguments.at_rest.is_empty() {
        let positions = arguments.at_rest.iter().map(|text| rest::position(&setup, text));
        for position in positions.collect::<Result<Vec<_>, _>>()? {
            super::say(&rest::rest(&setup, &position)?);
        }
        return Ok(());
    }
    let facts = facts(&setup)?;
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
    Ok(())
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

/// Everything but positions at rest that were asked for.
pub(super) fn facts(setup: &Setup) -> Result<Vec<Fact>, Failure> {
    let mut facts = turn::facts(setup)?;
    facts.extend(motion::facts(setup)?);
    Ok(facts)
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
fn unit_of_force(unit: &str) -> &'static str {
    if unit == "m" { "N" } else { "N m" }
}
