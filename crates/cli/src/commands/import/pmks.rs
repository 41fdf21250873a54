//! Mechanisms of PMKS: one joint a line, as `ground input R 0 0 0 ffft`, or a link with such lines.

mod inputs;
mod line;
mod teeth;
mod text;

use super::independent_coordinates::IndependentCoordinates;
use super::linkage::{End, ImportedLinkage, Joint, Kind, Link};
use super::names::Names;
use super::source::Source;
use crate::error::Error;
use line::{Line, kind_at, tokens};
use text::{mechanism, setting};

/// The speed of the input where the model has none, in turns a minute.
const DEFAULT_SPEED: f64 = 10.0;

/// The largest number of joints of a scene.
const MAX_JOINTS: usize = 1000;

/// Whether a text looks like a mechanism of PMKS.
pub(super) fn recognizes(text: &str) -> bool {
    let lines = text.split(['\n', '|']).filter(|line| !line.trim().is_empty());
    text.contains("mech=") || lines.take(20).any(|line| kind_at(&tokens(line, 0)).is_some_and(|at| at > 0))
}

/// Reads the first mechanism of a text.
pub(super) fn read(source: &Source) -> Result<ImportedLinkage, Error> {
    let (text, offset) = mechanism(&source.text);
    let mut lines = Vec::new();
    let mut at = offset;
    for line in text.split(['\n', '|']) {
        if !line.trim().is_empty() {
            lines.push(Line::read(source, line, at)?);
        }
        at += line.len() + 1;
    }
    if lines.len() > MAX_JOINTS {
        let title = format!("it has {} joints, and a scene at most {MAX_JOINTS}", lines.len());
        return Err(source.whole(&title, "split the mechanism"));
    }
    if lines.is_empty() {
        return Err(source.whole("it has no joint", "write one joint a line, as `ground crank R 0 0`"));
    }
    let mut reader = Reader {
        source,
        linkage: ImportedLinkage::new("a mechanism of PMKS"),
        names: Names::new(),
        links: vec![],
        inputs: vec![],
    };
    reader.read(&lines)?;
    Ok(reader.linkage)
}

struct Reader<'s> {
    source: &'s Source,
    linkage: ImportedLinkage,
    names: Names,
    /// The names of the links in the file; the ground is the first.
    links: Vec<String>,
    /// The inputs.
    inputs: Vec<Input>,
}

/// A joint that is an input.
struct Input {
    joint: usize,
    is_slider: bool,
    place: [f64; 2],
}

impl Reader<'_> {
    fn read(&mut self, lines: &[Line]) -> Result<(), Error> {
        self.links.push("ground".to_owned());
        self.names.unique("speed", "speed");
        for line in lines {
            for (name, _) in &line.links {
                self.link(name, line.place);
            }
        }
        let joined = |line: &&Line| line.links.len() > 1;
        let may_be_input = |line: &Line| line.links.len() > 1 && (line.kind == "R" || line.kind == "P");
        self.check_repetition(lines)?;
        let is_input = |line: &Line| line.is_input && line.links.len() > 1;
        let no_input = !lines.iter().any(is_input);
        let first = lines.iter().position(may_be_input).filter(|_| no_input);
        for (i, line) in lines.iter().enumerate() {
            if joined(&line) {
                self.joint(lines, line, is_input(line) || first == Some(i))?;
            } else {
                self.tracer(line);
            }
        }
        if !self.linkage.joints.iter().any(|joint| joint.ends.iter().any(|end| end.link == 0)) {
            return Err(self.source.whole("no joint is on the ground", "name a link `ground`"));
        }
        self.drop_inputs();
        self.finish();
        super::movable::check(self.source, &self.linkage)?;
        self.check_freedom()
    }

    /// The number of a link. A link with a new name is added.
    fn link(&mut self, name: &str, place: [f64; 2]) -> usize {
        if let Some(known) = self.known(name) {
            return known;
        }
        self.links.push(name.to_owned());
        let name = self.names.link(name, "link");
        self.linkage.links.push(Link::new(name, place, 0.0));
        self.links.len() - 1
    }

    fn end(&self, link: usize, place: [f64; 2]) -> End {
        End { link, at: self.linkage.local(link, place) }
    }

    /// Adds a joint of two or more links.
    fn joint(&mut self, lines: &[Line], line: &Line, is_input: bool) -> Result<(), Error> {
        let links: Vec<usize> = line.links.iter().map(|(name, _)| self.link(name, line.place)).collect();
        let refuse = |title: &str, label: &str, help: &str| self.source.error(title, line.span.clone(), label, help);
        if (1..links.len()).any(|i| links[..i].contains(&links[i])) {
            return Err(refuse("this joint names a link twice", "a joint is between links", "name each link once"));
        }
        if is_input && !matches!(line.kind.as_str(), "R" | "P") {
            return Err(refuse(
                "this joint cannot be the input",
                "not a pin or a slider",
                "drive a joint of type R or P",
            ));
        }
        let mut ends: Vec<End> = links.iter().map(|link| self.end(*link, line.place)).collect();
        let kind = match line.kind.as_str() {
            "R" => {
                // The ground comes last, as in a scene.
                ends.sort_by_key(|end| end.link == 0);
                Kind::Pin
            }
            _ if links.len() > 2 && line.kind != "RP" => {
                return Err(refuse(
                    "this joint has too many links",
                    "two links at most",
                    "write a joint for each pair",
                ));
            }
            "P" => {
                ends.swap(0, 1);
                ends.sort_by_key(|end| end.link == 0);
                Kind::Slider { direction: line.direction, rotation: 0.0 }
            }
            // The slot is on the first link, the pin on the second one.
            "RP" => {
                ends.truncate(2);
                ends.swap(0, 1);
                Kind::Slot { direction: line.direction }
            }
            _ => return self.teeth(lines, line, [links[0], links[1]]),
        };
        let name = self.joint_name();
        let drive = is_input.then(|| "speed*t".to_owned());
        if is_input {
            let joint = self.linkage.joints.len();
            self.inputs.push(Input { joint, is_slider: line.kind == "P", place: line.place });
        }
        self.linkage.joints.push(Joint { model_name: name.clone(), name, kind, ends, drive });
        if line.kind == "RP" && links.len() > 2 {
            let ends = links[1..].iter().map(|link| self.end(*link, line.place)).collect();
            let name = self.joint_name();
            self.linkage.joints.push(Joint { model_name: name.clone(), name, kind: Kind::Pin, ends, drive: None });
        }
        if line.is_traced && kind == Kind::Pin && !links.contains(&0) {
            let point = self.linkage.joints.last().map(|joint| joint.name.clone()).unwrap_or_default();
            self.linkage.trace_point(&point, &mut self.names);
        }
        Ok(())
    }

    /// The name of a joint: a letter for each, as on drawings.
    fn joint_name(&mut self) -> String {
        let count = self.linkage.joints.len();
        let letter = char::from(b'A' + u8::try_from(count % 26).unwrap_or(0));
        let wanted = if count < 26 { letter.to_string() } else { format!("{letter}{}", count / 26) };
        self.names.unique(&wanted, "joint")
    }

    fn known(&self, name: &str) -> Option<usize> {
        let lower = name.to_ascii_lowercase();
        // PMKS takes these spellings too.
        let is_ground = ["0", "gnd", "grnd", "grond", "gound", "groud"].contains(&lower.as_str());
        if is_ground || lower.starts_with("ground") {
            Some(0)
        } else {
            self.links.iter().position(|other| other == name)
        }
    }

    /// Adds a point of one link, and its coordinates as outputs.
    fn tracer(&mut self, line: &Line) {
        let Some(link) = line.links.first().map(|(name, _)| self.link(name, line.place)) else { return };
        let name = self.names.unique(&format!("P{}", self.linkage.outputs.len() / 2 + 1), "point");
        let at = self.linkage.local(link, line.place);
        self.linkage.links[link].points.push((name.clone(), at));
        if link > 0 {
            self.linkage.trace_point(&name, &mut self.names);
        }
    }

    /// Refuses links whose motion the input does not determine: without masses, nothing moves them.
    fn check_freedom(&self) -> Result<(), Error> {
        let independent = IndependentCoordinates::choose(&self.linkage);
        let ends = independent.joints.iter().map(|joint| self.linkage.joints[*joint].ends[0].link);
        let free: Vec<&str> = independent.links.into_iter().chain(ends).map(|link| self.links[link].as_str()).collect();
        if free.is_empty() {
            return Ok(());
        }
        let title = format!("the input does not determine the motion of: `{}`", free.join("`, `"));
        Err(self.source.whole(&title, "add the joints that are missing: PMKS has one input, and no masses"))
    }

    /// Adds the speeds of the inputs, the time of a turn, and remarks.
    fn finish(&mut self) {
        let speed = setting(&self.source.text, 's').unwrap_or(DEFAULT_SPEED);
        let speed = if speed == 0.0 { DEFAULT_SPEED } else { speed };
        // PMKS takes the last input.
        let inputs: Vec<&Input> = self.inputs.iter().rev().collect();
        let linkage = &mut self.linkage;
        let turns = inputs.first().is_none_or(|input| !input.is_slider);
        linkage.end_time = if turns { 60.0 / speed.abs() } else { 1.0 };
        linkage.step = linkage.end_time / 1000.0;
        for (number, input) in inputs.into_iter().enumerate() {
            let name = if number == 0 { "speed".to_owned() } else { self.names.unique("speed", "speed") };
            let (unit, what) = if input.is_slider { ("m/s", "input slider") } else { ("rpm", "input") };
            let of = if number == 0 { String::new() } else { format!(" {}", linkage.joints[input.joint].name) };
            linkage.joints[input.joint].drive = Some(format!("{name}*t"));
            let doc = format!("speed of the {what}{of}");
            linkage.parameters.push(super::linkage::Parameter { name, value: speed, unit, doc });
        }
        linkage.remarks.push("PMKS has lengths without a unit: they are metres here.".to_owned());
        linkage.remarks.push("It has no masses: forces need `mass`, `com` and `inertia` of the links.".to_owned());
        if self.source.text.matches("mech=").count() > 1 {
            linkage.left_out.push("all mechanisms of the file but the first".to_owned());
        }
        if self.source.text.contains("ts=") {
            linkage.left_out.push("the target shape".to_owned());
        }
    }
}

#[cfg(test)]
mod tests;
