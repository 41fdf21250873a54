//! The start of the coordinates of links.

use std::collections::BTreeSet;

use super::angles::Angles;
use super::graph::{Graph, Joint};
use super::independent_coordinates::independent_coordinates;
use super::places::{origin_names, slide};
use super::terms::{is_zero, whole};
use super::tree::{Placement, Tree};
use crate::diagnostic::{Diagnostic, Span};
use crate::document::{Document, Identifier};
use crate::parser::Formula;

/// The value and the rate of a coordinate at the start.
pub(super) struct StartValue {
    /// The coordinate.
    pub(super) name: String,
    /// The value of the coordinate at the start; `None` if it is unknown.
    pub(super) value: Option<Formula>,
    /// Whether the scene gives the value itself: the `angle` of a link, or the `start` of a slider.
    pub(super) is_written: bool,
    /// The rate of the coordinate at the start; if present, value and rate are both given.
    pub(super) rate: Option<Formula>,
}

/// The coordinates that a drive prescribes: angles against the ground, and places along sliders.
pub(super) fn driven(graph: &Graph, angles: &Angles) -> BTreeSet<String> {
    let driven = graph.joints.iter().enumerate().filter(|(_, joint)| joint.syntax.drive.is_some());
    let coordinate = |(number, joint): (usize, &Joint)| {
        if joint.syntax.kind.is_slider() {
            return Some(slide(graph, number));
        }
        let classes: Vec<usize> = joint.ends.iter().map(|end| angles.angle(end.link).class).collect();
        match classes[..] {
            [0, class] | [class, 0] if class > 0 => Some(angles.coordinates[class - 1].0.clone()),
            _ => None,
        }
    };
    driven.filter_map(coordinate).collect()
}

/// Writes the start of all coordinates to a scene. If the scene does not say which are given, `freedoms` independent
/// ones are: those whose values it gives itself come first, and coordinates that drives prescribe are not chosen.
pub(super) fn write(
    document: &mut Document,
    values: Vec<StartValue>,
    freedoms: usize,
    driven: &BTreeSet<String>,
) -> Vec<String> {
    let is_open = document.given.is_empty() && values.iter().all(|value| value.rate.is_none());
    let mut candidates: Vec<&StartValue> =
        values.iter().filter(|own| own.value.is_some() && !driven.contains(&own.name)).collect();
    candidates.sort_by_key(|own| !own.is_written);
    let candidates: Vec<&str> = candidates.into_iter().map(|own| own.name.as_str()).collect();
    let chosen = independent_coordinates(document, &candidates, if is_open { freedoms } else { 0 });
    let mut unknown = Vec::new();
    for StartValue { name, value, rate, .. } in values {
        if document.given.iter().chain(&document.solve).any(|(identifier, _)| identifier.name == name) {
            continue;
        }
        let Some(value) = value else {
            unknown.push(name);
            continue;
        };
        let rate = rate.or_else(|| chosen.contains(&name).then(|| whole(0)));
        let identifier = |name: String| Identifier { name, span: value.whole_span() };
        match rate {
            Some(rate) => {
                document.given.push((identifier(name.clone()), value.clone()));
                document.given.push((identifier(format!("{name}_dot")), rate));
            }
            None => document.solve.push((identifier(name), value)),
        }
    }
    unknown
}

/// Reports rates that have no coordinate: those of links that cannot turn, those of links that others hold at another
/// rate, and those of sliders whose positions are not coordinates.
pub(super) fn check_rates(graph: &Graph, tree: &Tree, angles: &Angles, findings: &mut Vec<Diagnostic>) {
    let mut given: Vec<Option<(&str, &Formula)>> = vec![None; angles.coordinates.len() + 1];
    for number in 1..graph.links.len() {
        let Some(rate) = graph.links[number].and_then(|link| link.rate.as_ref()) else { continue };
        let (name, class) = (graph.name(number), angles.angle(number).class);
        if class == 0 && !is_zero(rate) {
            let title = format!("link `{name}` cannot turn, and has a rate");
            let error = Diagnostic::error(title, rate.whole_span(), "joints hold it at the angle of the ground");
            findings.push(error.help("take `rate` out, or replace the joint that holds its angle by a pin"));
        }
        match given[class].filter(|_| class > 0) {
            Some((other, known)) if known.nodes() != rate.nodes() => {
                let title = format!("links `{other}` and `{name}` turn together, and both have a rate");
                let error = Diagnostic::error(title, rate.whole_span(), "the second one");
                findings.push(error.help("give one of them a `rate`"));
            }
            _ => given[class] = Some((name, rate)),
        }
    }
    for (number, joint) in graph.joints.iter().enumerate().filter(|(_, joint)| joint.syntax.kind.is_slider()) {
        let Some(rate) = &joint.syntax.rate else { continue };
        if !joint.ends.iter().any(|end| tree.places(number, *end)) {
            let title = format!("the place along joint `{}` is no coordinate", joint.syntax.identifier.name);
            let error = Diagnostic::error(title, rate.whole_span(), "no rate can be given for it");
            let free = joint.ends.iter().find(|end| tree.placements[end.link] == Placement::Free);
            let help = match free.map(|end| origin_names(graph, end.link)) {
                Some([x, y]) => format!("give `{x}` or `{y}`, the origin of its link, and its rate in [initial]"),
                None => "pins place its links: give one of them a `rate` next to its `angle`".to_owned(),
            };
            findings.push(error.help(help));
        }
    }
}

/// Reports coordinates without a start value.
pub(super) fn report_unknown(document: &Document, names: &[String], findings: &mut Vec<Diagnostic>) {
    for name in names {
        let own = document.coordinates.iter().find(|own| own.identifier.name == *name);
        let span = own.map_or(0..0, |own| own.identifier.span.clone());
        let error = Diagnostic::error(format!("the start of `{name}` is not known"), span, "nothing says where it is");
        findings.push(error.help(
            "give the link an `angle`, or two of its joints a rough place by `near = [x, y]`; a slider \
             or a cam takes `start = ...`",
        ));
    }
}

/// Reports that fewer coordinates or rates are given than there are degrees of freedom.
pub(super) fn report_too_few(document: &Document, freedoms: usize, place: &Span, findings: &mut Vec<Diagnostic>) {
    for (what, suffix) in [("position", ""), ("rate", "_dot")] {
        let is_given = |own: &str| document.given.iter().any(|(given, _)| given.name.strip_suffix(suffix) == Some(own));
        let given = document.coordinates.iter().filter(|own| is_given(&own.identifier.name)).count();
        if given >= freedoms {
            continue;
        }
        let freedom = if freedoms == 1 { "degree" } else { "degrees" };
        let said = if given == 1 { format!("1 {what} is") } else { format!("{given} {what}s are") };
        let title = format!("the mechanism has {freedoms} {freedom} of freedom, but {said} given at the start");
        let error = Diagnostic::error(title, place.clone(), "links begin here");
        let help = "give as many links as that a `rate` next to their `angle`, or a slider its `start` and `rate`, or \
                    coordinates of a link that no pin places, such as `x_LINK`, their values and rates in [initial]";
        findings.push(error.help(help));
        return;
    }
}
