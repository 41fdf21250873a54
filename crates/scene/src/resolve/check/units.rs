//! Units that differ from those in which a scene computes.

use super::super::usage::all_values;
use crate::diagnostic::Diagnostic;
use crate::document::{CoordinateSyntax, Document, Identifier, OutputSyntax, OutputValue};
use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::scene::{Quantity, Scene, Start, Value};

/// Units other than rad, m, s, N, J and W.
const SCALED: [&str; 27] = [
    "deg", "°", "grad", "rev", "rpm", "um", "µm", "mm", "cm", "dm", "km", "in", "inch", "ft", "mN", "kN", "MN", "lbf",
    "mJ", "kJ", "MJ", "mW", "kW", "MW", "ms", "min", "h",
];

/// Units of angles other than rad.
const ANGLES: [&str; 4] = ["deg", "°", "grad", "rev"];

/// Reports units of coordinates, and of outputs that are computed without a factor, that the numbers do not have.
pub(super) fn units(document: &Document, findings: &mut Vec<Diagnostic>) {
    for CoordinateSyntax { identifier, unit, .. } in &document.coordinates {
        let help = "write `unit = \"rad\"` or `unit = \"m\"`; an output converts, such as `value = 'phi*180/pi'`";
        report("coordinate", identifier, unit, help, findings);
    }
    for OutputSyntax { identifier, value, unit, .. } in &document.outputs {
        let help = match value {
            OutputValue::Value(_) => "write the factor in the formula: `value = 'phi*180/pi'` or `value = 'x*1000'`",
            _ => "write the unit of the number",
        };
        if has_no_factor(document, value) {
            report("output", identifier, unit, help, findings);
        }
    }
}

/// Reports parameters whose unit is an angle other than rad, and which are taken as angles without a factor.
pub(super) fn angles(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let mut angles = Vec::new();
    for value in all_values(scene) {
        for node in value.nodes() {
            if let Node::Call(Function::Sin | Function::Cos | Function::Tan, operands) = node {
                operands.iter().for_each(|operand| terms(value, *operand, &mut angles));
            }
        }
    }
    for coordinate in &scene.coordinates {
        if let Start::Given(value) | Start::Guess(value) = &coordinate.position {
            terms(value, value.nodes().len() - 1, &mut angles);
        }
    }
    angles.sort_unstable();
    angles.dedup();
    for place in angles {
        let parameter = &scene.parameters[place];
        if !ANGLES.contains(&parameter.unit.as_str()) {
            continue;
        }
        let Some(syntax) = document.parameters.iter().find(|syntax| syntax.identifier.name == parameter.name) else {
            continue;
        };
        let title = format!("parameter `{}` is an angle in rad, and has the unit `{}`", parameter.name, parameter.unit);
        let label = "a unit does not convert numbers";
        let help = "write `value = '45deg', unit = \"rad\"`, or the factor `pi/180` wherever it is an angle";
        findings.push(Diagnostic::error(title, syntax.identifier.span.clone(), label).help(help));
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

/// Reports a unit that is scaled.
fn report(what: &str, identifier: &Identifier, unit: &str, help: &str, findings: &mut Vec<Diagnostic>) {
    let mut parts = unit.split(['/', '*', '^', ' ']);
    if !parts.next().is_some_and(|first| SCALED.contains(&first)) && !parts.any(|part| part == "min" || part == "h") {
        return;
    }
    let title = format!("{what} `{}` has the unit `{unit}`, and its numbers do not", identifier.name);
    let label = "in rad, m, s, N, J and W: a unit does not convert numbers";
    findings.push(Diagnostic::error(title, identifier.span.clone(), label).help(help));
}

/// Whether an output takes no formula, or is a coordinate, its rate, or the coordinate of a point.
fn has_no_factor(document: &Document, value: &OutputValue) -> bool {
    match value {
        OutputValue::Value(formula) | OutputValue::Rate(formula) | OutputValue::SecondRate(formula) => {
            let [Node::Name(name)] = formula.nodes() else { return false };
            !document.parameters.iter().any(|parameter| parameter.identifier.name == *name)
        }
        OutputValue::ShakingForce(_) | OutputValue::Reaction { along: Some(_), .. } | OutputValue::FreeBody { .. } => {
            false
        }
        _ => true,
    }
}
