//! Units that differ from those in which a scene computes.

use std::f64::consts::TAU;

use super::super::usage::all_values;
use crate::diagnostic::Diagnostic;
use crate::document::{CoordinateSyntax, Document, Identifier, OutputSyntax, OutputValue};
use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::scene::{Constraint, LoadKind, Quantity, Scene, Start, Value};

/// Units other than rad, m, kg, s, N, J and W: those of angles and of lengths first.
const SCALED: [&str; 42] = [
    "deg", "°", "grad", "rev", "um", "µm", "mm", "cm", "dm", "km", "in", "inch", "ft", "rpm", "RPM", "Hz", "mN", "kN",
    "MN", "daN", "lbf", "kgf", "Nmm", "Ncm", "kNm", "mJ", "kJ", "MJ", "mW", "kW", "MW", "ms", "min", "h", "g", "mg",
    "t", "lb", "gram", "tonne", "rps", "kHz",
];
const ANGLES: &[&str] = SCALED.split_at(4).0;
const LENGTHS: &[&str] = SCALED.split_at(13).0.split_at(4).1;

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

/// Reports parameters that are taken without a factor, and whose unit is none of those in which a scene computes; and
/// bare numbers beyond a turn that are taken as angles.
pub(super) fn parameters(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let positions: Vec<&Value> = scene.points.iter().flat_map(|point| &point.position).collect();
    // A sine in another formula may have any argument.
    let [in_all, in_positions] = [&all_values(scene), &positions].map(|values| angles(scene, values));
    let lengths = lengths(scene);
    let others = inertias_rates_and_loads(scene);
    for (place, parameter) in scene.parameters.iter().enumerate() {
        let (is_angle, is_length) = (in_all.contains(&place), lengths.contains(&place));
        let Some(syntax) = document.parameters.iter().find(|syntax| syntax.identifier.name == parameter.name) else {
            continue;
        };
        let unit = parameter.unit.as_str();
        let mut report = |title: String, label: &str, help: &str| {
            findings.push(Diagnostic::error(title, syntax.identifier.span.clone(), label).help(help));
        };
        let name = &parameter.name;
        let label = "a unit does not convert numbers";
        if is_angle && ANGLES.contains(&unit) {
            let help = "write `value = '45deg', unit = \"rad\"`, or the factor `pi/180` wherever it is an angle";
            report(format!("parameter `{name}` is an angle in rad, and has the unit `{unit}`"), label, help);
        } else if is_length && LENGTHS.contains(&unit) {
            let help = "write the value in m, such as `'300/1000'`, with `unit = \"m\"`, or the factor wherever it \
                        is a length";
            report(format!("parameter `{name}` is a length in m, and has the unit `{unit}`"), label, help);
        } else if others.contains(&place) && is_scaled(unit) {
            let help = "write the value in rad, m, kg, s and N, such as `'0.1*1000'`, with its unit, or the factor \
                        wherever it is used";
            report(format!("parameter `{name}` is used without a factor, and has the unit `{unit}`"), label, help);
        } else if in_positions.contains(&place) && unit.is_empty() && is_beyond_turn(&parameter.formula) {
            let help = "write `'45deg'`, or `{ value = 45, unit = \"rad\" }`";
            let title = format!("parameter `{name}` is an angle without a unit, and is more than a turn in radians");
            report(title, "degrees or radians?", help);
        }
    }
}

/// Whether a formula is a bare number of more than a turn in radians.
fn is_beyond_turn(formula: &Value) -> bool {
    matches!(formula.nodes(), [Node::Number(number)] | [Node::Number(number), Node::Negate(_)] if number.value > TAU)
}

/// The parameters that are terms of angles in formulae, or in starts of angles.
fn angles(scene: &Scene, values: &[&Value]) -> Vec<usize> {
    let mut angles = Vec::new();
    for value in values {
        for node in value.nodes() {
            if let Node::Call(Function::Sin | Function::Cos | Function::Tan, operands) = node {
                operands.iter().for_each(|operand| terms(value, *operand, &|_| None, &mut angles));
            }
        }
    }
    for coordinate in scene.coordinates.iter().filter(|coordinate| coordinate.unit == "rad") {
        if let Start::Given(value) | Start::Guess(value) = &coordinate.position {
            terms(value, value.nodes().len() - 1, &|_| None, &mut angles);
        }
    }
    angles
}

/// The parameters that are terms of positions, alone or times a sine, a cosine, 1/2 or 2: another factor may convert
/// them.
fn lengths(scene: &Scene) -> Vec<usize> {
    let mut lengths = Vec::new();
    for value in scene.points.iter().flat_map(|point| &point.position) {
        let is_scale = |id: NodeId| match &value.nodes()[id] {
            Node::Call(Function::Sin | Function::Cos, _) => true,
            Node::Number(number) => number.value == 0.5 || number.value == 2.0,
            _ => false,
        };
        let factor = |id: NodeId| match &value.nodes()[id] {
            Node::Multiply(a, b) | Node::Divide(a, b) if is_scale(*b) => Some(*a),
            Node::Multiply(a, b) if is_scale(*a) => Some(*b),
            _ => None,
        };
        terms(value, value.nodes().len() - 1, &factor, &mut lengths);
    }
    for coordinate in scene.coordinates.iter().filter(|coordinate| coordinate.unit == "m") {
        if let Start::Given(value) | Start::Guess(value) = &coordinate.position {
            terms(value, value.nodes().len() - 1, &|_| None, &mut lengths);
        }
    }
    lengths
}

/// The parameters that are masses, moments of inertia, parts of loads, or rates at the start or of drives.
fn inertias_rates_and_loads(scene: &Scene) -> Vec<usize> {
    let mut values: Vec<&Value> = scene.bodies.iter().flat_map(|body| [&body.mass, &body.inertia]).flatten().collect();
    for load in &scene.loads {
        match &load.kind {
            LoadKind::Force { force: components, .. } | LoadKind::Gravity(components) => values.extend(components),
            LoadKind::Torque { torque, .. } => values.push(torque),
            LoadKind::Spring { along, stiffness, rest, damping, force, friction, .. } => {
                values.extend([stiffness, damping, force].into_iter().flatten());
                let has_factor = matches!(along.nodes().last(), Some(Node::Multiply(..) | Node::Divide(..)));
                values.extend(rest.iter().filter(|_| !has_factor));
                values.extend(friction.iter().map(|friction| &friction.size));
            }
        }
    }
    for coordinate in &scene.coordinates {
        if let Start::Given(value) | Start::Guess(value) = &coordinate.rate {
            values.push(value);
        }
    }
    // A term of a sum may be converted with the others.
    let alone = |value: &Value| match value.nodes() {
        [Node::Name(Quantity::Parameter(place))] | [Node::Name(Quantity::Parameter(place)), Node::Negate(_)] => {
            Some(*place)
        }
        _ => None,
    };
    let mut parameters: Vec<usize> = values.into_iter().filter_map(alone).collect();
    // Such as `phi - w*t`.
    for Constraint { residual, .. } in &scene.constraints {
        let is_time = |id: NodeId| matches!(residual.nodes()[id], Node::Name(Quantity::Time));
        let rate = |id: NodeId| match residual.nodes()[id] {
            Node::Multiply(a, b) if is_time(b) => Some(a),
            Node::Multiply(a, b) if is_time(a) => Some(b),
            _ => None,
        };
        terms(residual, residual.nodes().len() - 1, &rate, &mut parameters);
    }
    parameters
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

/// Adds the parameters that are terms of a sum; `factor` gives the operation that a term is a multiple of.
fn terms(value: &Value, id: NodeId, factor: &dyn Fn(NodeId) -> Option<NodeId>, parameters: &mut Vec<usize>) {
    match &value.nodes()[id] {
        Node::Name(Quantity::Parameter(place)) => parameters.push(*place),
        Node::Negate(a) => terms(value, *a, factor, parameters),
        Node::Add(a, b) | Node::Subtract(a, b) => {
            [*a, *b].into_iter().for_each(|id| terms(value, id, factor, parameters))
        }
        _ => {
            if let Some(id) = factor(id) {
                terms(value, id, factor, parameters);
            }
        }
    }
}

/// Whether a unit has a factor other than one.
fn is_scaled(unit: &str) -> bool {
    unit.split(['/', '*', '^', ' ', '(', ')', '·']).any(|part| SCALED.contains(&part))
}

/// Reports a unit that is scaled.
fn report(what: &str, identifier: &Identifier, unit: &str, help: &str, findings: &mut Vec<Diagnostic>) {
    if !is_scaled(unit) {
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
