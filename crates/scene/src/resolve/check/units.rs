//! Units that do not fit their quantities, and angles without units.

use std::f64::consts::TAU;

use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier, OutputValue};
use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::scene::{LoadKind, Quantity, Scene, Start, Value};
use crate::unit::Unit;

/// Reports units of coordinates and constraints that are not those of their numbers, and units that do not fit outputs.
pub(super) fn units(document: &Document, findings: &mut Vec<Diagnostic>) {
    let coordinates = document.coordinates.iter().map(|own| ("coordinate", &own.identifier, &own.unit));
    let constraints = document.constraints.iter().map(|own| ("constraint", &own.identifier, &own.unit));
    for (what, identifier, unit) in coordinates.chain(constraints) {
        if Unit::parse(unit).is_some_and(|unit| unit.is_scaled()) {
            let title = format!("{what} `{}` has the unit `{unit}`, and its numbers do not", identifier.name);
            let help = "write `unit = \"rad\"` or `unit = \"m\"`; outputs and parameters are converted, such as \
                        `{ value = 'phi', unit = \"deg\" }`";
            findings.push(Diagnostic::error(title, identifier.span.clone(), "in rad or m").help(help));
        }
    }
    for output in &document.outputs {
        let expected = match &output.value {
            OutputValue::Power(_) => "W",
            OutputValue::ShakingForce(_) | OutputValue::Reaction { along: Some(_), .. } => "N",
            OutputValue::ShakingMoment(_) | OutputValue::Reaction { along: None, .. } => "N m",
            _ => continue,
        };
        findings.extend(misfit(&output.identifier, &output.unit, expected));
    }
}

/// An error if an output has a unit of another kind.
pub(crate) fn misfit(output: &Identifier, unit: &str, expected: &str) -> Option<Diagnostic> {
    let (own, expected) = (Unit::parse(unit).filter(|_| !unit.is_empty())?, Unit::parse(expected)?);
    if own.fits(&expected) {
        return None;
    }
    let title = format!("output `{}` is {}, and has the unit `{unit}`", output.name, expected.quantity());
    let help = format!("write `unit = \"{}\"`, or another unit of the same kind", expected.base());
    Some(Diagnostic::error(title, output.span.clone(), own.quantity()).help(help))
}

/// Reports parameters without a unit that are taken as angles, and are bare numbers beyond a turn.
pub(super) fn parameters(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let angles = angles(scene);
    for (place, parameter) in scene.parameters.iter().enumerate() {
        let Some(syntax) = document.parameters.iter().find(|syntax| syntax.identifier.name == parameter.name) else {
            continue;
        };
        if angles.contains(&place) && parameter.unit.is_empty() && is_beyond_turn(&parameter.formula) {
            let help = "write `'45 deg'`, or `{ value = 45, unit = \"rad\" }`";
            let title = format!(
                "parameter `{}` is an angle without a unit, and is more than a turn in radians",
                parameter.name
            );
            let error = Diagnostic::error(title, syntax.identifier.span.clone(), "degrees or radians?");
            findings.push(error.help(help));
        }
    }
}

/// Whether a formula is a bare number of more than a turn in radians.
fn is_beyond_turn(formula: &Value) -> bool {
    matches!(formula.nodes(), [Node::Number(number)] | [Node::Number(number), Node::Negate(_)] if number.value > TAU)
}

/// The parameters that are terms of angles in positions, or in starts of angles.
fn angles(scene: &Scene) -> Vec<usize> {
    let mut angles = Vec::new();
    for value in scene.points.iter().flat_map(|point| &point.position) {
        for node in value.nodes() {
            if let Node::Call(Function::Sin | Function::Cos | Function::Tan, operands) = node {
                operands.iter().for_each(|operand| terms(value, *operand, &mut angles));
            }
        }
    }
    for coordinate in scene.coordinates.iter().filter(|coordinate| coordinate.unit == "rad") {
        if let Start::Given(value) | Start::Guess(value) = &coordinate.position {
            terms(value, value.nodes().len() - 1, &mut angles);
        }
    }
    angles
}

/// Reports springs along angles whose relaxed angle is a bare number beyond a turn.
pub(super) fn relaxed_angles(scene: &Scene, source: &str, findings: &mut Vec<Diagnostic>) {
    for load in &scene.loads {
        let LoadKind::Spring { along, rest: Some(rest), .. } = &load.kind else { continue };
        let is_angle =
            matches!(along.nodes(), [Node::Name(Quantity::Coordinate(i))] if scene.coordinates[*i].unit == "rad");
        let span = rest.whole_span();
        let [text, behind] = [span.clone(), span.end..source.len()].map(|part| source.get(part).unwrap_or_default());
        if is_angle && is_beyond_turn(rest) && !behind.trim_start().starts_with("rad") {
            findings.push(Diagnostic::angle_without_unit(text, span));
        }
    }
}

/// Adds the parameters that are terms of a sum.
fn terms(value: &Value, id: NodeId, parameters: &mut Vec<usize>) {
    match &value.nodes()[id] {
        Node::Name(Quantity::Parameter(place)) => parameters.push(*place),
        Node::Negate(a) => terms(value, *a, parameters),
        Node::Add(a, b) | Node::Subtract(a, b) => [*a, *b].into_iter().for_each(|id| terms(value, id, parameters)),
        _ => {}
    }
}
