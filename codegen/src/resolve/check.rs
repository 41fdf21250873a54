//! Rules that a scene must keep beyond knowing its names.

use crate::diagnostic::Diagnostic;
use crate::document::{BodySyntax, Document};
use crate::evaluate::{evaluate, first_non_finite};
use crate::expression::Node;
use crate::scene::{LoadKind, OutputKind, Quantity, Scene, Start, Value};

/// Checks a scene whose names are all known and whose parameters have their numbers.
pub(super) fn check(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    finite_constants(scene, findings);
    if !findings.is_empty() {
        return;
    }
    for (syntax, place) in document.bodies.iter().zip(0..) {
        body(syntax, scene, place, findings);
    }
    run(scene, findings);
    for constraint in &scene.constraints {
        if scene.coordinates_of(&constraint.residual).is_empty() {
            findings.push(
                Diagnostic::error(
                    format!("constraint `{}` depends on no coordinate", constraint.name),
                    constraint.span.clone(),
                    "no motion can keep it",
                )
                .help("a loop closure is a formula of coordinates that must stay zero"),
            );
        }
    }
    output_names(document, scene, findings);
    freedoms(document, scene, findings);
    used(document, scene, findings);
}

/// Reports what the generator cannot differentiate.
pub(super) fn differentiable(value: &Value, findings: &mut Vec<Diagnostic>) {
    for (id, node) in value.nodes().iter().enumerate() {
        match node {
            Node::Call(function, _) if !function.is_differentiable() => {
                let name = function.name();
                findings.push(
                    Diagnostic::error(format!("`{name}` cannot be differentiated"), value.span(id), "not smooth here")
                        .help(format!("`{name}` may stand in values of parameters, first guesses and stop conditions")),
                );
            }
            Node::Power(_, exponent) if !is_number(value, *exponent) => findings.push(
                Diagnostic::error("the exponent is not a number", value.span(*exponent), "not a number")
                    .help("write `exp(b*log(a))` for a power `a^b` with a variable exponent"),
            ),
            _ => {}
        }
    }
}

/// Whether the operation and everything below it are made of numbers.
fn is_number(value: &Value, id: usize) -> bool {
    let mut pending = vec![id];
    while let Some(id) = pending.pop() {
        match &value.nodes()[id] {
            Node::Number(_) => {}
            Node::Negate(a) => pending.push(*a),
            Node::Divide(a, b) | Node::Multiply(a, b) | Node::Add(a, b) | Node::Subtract(a, b) => pending.extend([*a, *b]),
            _ => return false,
        }
    }
    true
}

fn constant(scene: &Scene, value: &Value) -> f64 {
    evaluate(value, |quantity| lookup(scene, *quantity))
}

fn lookup(scene: &Scene, quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Parameter(i) => scene.parameters[i].value,
        Quantity::Pi => std::f64::consts::PI,
        _ => f64::NAN,
    }
}

/// Every constant formula must give a number, at the values that the file gives to parameters.
fn finite_constants(scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let mut constants: Vec<&Value> = scene.parameters.iter().map(|p| &p.formula).collect();
    for coordinate in &scene.coordinates {
        for start in [&coordinate.position, &coordinate.rate] {
            if let Start::Given(value) | Start::Guess(value) = start {
                constants.push(value);
            }
        }
    }
    constants.extend([&scene.run.step, &scene.run.end_time]);
    for body in &scene.bodies {
        constants.extend([&body.mass, &body.inertia].into_iter().flatten());
    }
    for load in &scene.loads {
        match &load.kind {
            LoadKind::Gravity(field) => constants.extend(field),
            LoadKind::Spring { stiffness, rest, damping, .. } => {
                constants.extend([stiffness, rest, damping].into_iter().flatten());
            }
            LoadKind::Force { .. } | LoadKind::Torque { .. } => {}
        }
    }
    for value in constants {
        if let Some(id) = first_non_finite(value, |quantity| lookup(scene, *quantity)) {
            let operand = match &value.nodes()[id] {
                Node::Call(function, arguments) => {
                    let upto = |argument: usize| {
                        let mut part = Value::new();
                        for node in &value.nodes()[..=argument] {
                            part.push(node.clone(), 0..0);
                        }
                        constant(scene, &part)
                    };
                    let arguments: Vec<String> = arguments.iter().map(|&a| format!("{}", upto(a))).collect();
                    format!("`{}` of {} is not a number", function.name(), arguments.join(", "))
                }
                Node::Name(_) => continue,
                _ => "this gives no finite number".to_owned(),
            };
            findings.push(Diagnostic::error("a formula has no finite value", value.span(id), operand));
        }
    }
}

fn body(syntax: &BodySyntax, scene: &Scene, place: usize, findings: &mut Vec<Diagnostic>) {
    let body = &scene.bodies[place];
    let name = &body.name;
    let pairs = [("mass", &body.mass, body.com.is_some(), "com"), ("inertia", &body.inertia, body.angle.is_some(), "angle")];
    for (what, value, placed, needed) in pairs {
        let Some(value) = value else { continue };
        let number = constant(scene, value);
        if number < 0.0 {
            let label = format!("its value is {number}");
            findings.push(Diagnostic::error(format!("body `{name}` has a negative {what}"), value.whole_span(), label));
        }
        if !placed {
            findings.push(
                Diagnostic::error(
                    format!("body `{name}` has {} but no {}", article(what), if needed == "com" { "position" } else { "angle" }),
                    value.whole_span(),
                    format!("needs `{needed}`"),
                )
                .help(format!("add `{needed} = ...` to the body, or take its {what} away")),
            );
        }
    }
    if syntax.mass.is_none() && syntax.inertia.is_none() && body.com.is_none() && body.angle.is_none() {
        findings.push(Diagnostic::error(format!("body `{name}` is empty"), syntax.identifier.span.clone(), "says nothing"));
    }
}

fn article(what: &str) -> String {
    if what == "inertia" { "an inertia".to_owned() } else { format!("a {what}") }
}

fn run(scene: &Scene, findings: &mut Vec<Diagnostic>) {
    for (what, value) in [("step", &scene.run.step), ("end", &scene.run.end_time)] {
        let number = constant(scene, value);
        if number <= 0.0 {
            let label = format!("its value is {number}");
            findings.push(Diagnostic::error(format!("the {what} of the run must be positive"), value.whole_span(), label));
        }
    }
}

/// An output's name is a column of the trajectory, beside the columns that are always there.
fn output_names(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let mut columns: Vec<String> = ["t", "residual_position", "residual_velocity", "energy"].map(str::to_owned).to_vec();
    for coordinate in &scene.coordinates {
        columns.extend(["", "_dot", "_ddot"].map(|suffix| format!("{}{suffix}", coordinate.name)));
    }
    columns.extend(scene.constraints.iter().map(|c| format!("lambda_{}", c.name)));
    for output in &document.outputs {
        if columns.contains(&output.identifier.name) {
            findings.push(
                Diagnostic::error(
                    format!("output `{}` has the name of another column", output.identifier.name),
                    output.identifier.span.clone(),
                    "every trajectory has this column",
                )
                .help("choose another name, or leave the output away"),
            );
        }
    }
}

fn freedoms(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let (n, m) = (scene.coordinates.len(), scene.constraints.len());
    let Some(freedoms) = n.checked_sub(m) else {
        let span = document.coordinates.first().map_or(0..0, |c| c.identifier.span.clone());
        findings.push(Diagnostic::error(
            format!("more constraints than coordinates: {} but {}", count(m, "constraint"), count(n, "coordinate")),
            span,
            "no freedom is left",
        ));
        return;
    };
    let balance = format!("{} - {} = {}", count(n, "coordinate"), count(m, "constraint"), count(freedoms, "freedom"));
    let given = |start: fn(&crate::scene::Coordinate) -> &Start| {
        scene.coordinates.iter().filter(|c| matches!(start(c), Start::Given(_))).map(|c| c.name.as_str()).collect::<Vec<_>>()
    };
    for (what, names) in [("position", given(|c| &c.position)), ("rate", given(|c| &c.rate))] {
        if names.len() != freedoms {
            let listed = if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) };
            let label = format!("{}{listed}", count(names.len(), &format!("given {what}")));
            let title = format!("{balance}, but {} given", if names.len() == 1 { format!("1 {what} is") } else { format!("{} {what}s are", names.len()) });
            let help = if names.len() > freedoms {
                if what == "position" { "move the others to `solve`, as first guesses".to_owned() } else { "leave the other rates away: they follow from the constraints".to_owned() }
            } else {
                format!("give as many {what}s as there are freedoms{}", if what == "rate" { ", as `NAME_dot`" } else { "" })
            };
            findings.push(Diagnostic::error(title, document.given_span.clone(), label).help(help));
        }
    }
    for (coordinate, syntax) in scene.coordinates.iter().zip(&document.coordinates) {
        if matches!(coordinate.position, Start::Free) && given(|c| &c.position).len() <= freedoms {
            findings.push(
                Diagnostic::error(
                    format!("coordinate `{}` has neither a given value nor a first guess", coordinate.name),
                    syntax.identifier.span.clone(),
                    "where does it start?",
                )
                .help(format!("add `{} = ...` to `solve` in [initial]", coordinate.name)),
            );
        }
    }
    for (identifier, _) in document.solve.iter().filter(|(i, _)| i.name.ends_with("_dot")) {
        if scene.coordinates.iter().any(|c| format!("{}_dot", c.name) == identifier.name) {
            findings.push(
                Diagnostic::error("a rate needs no first guess", identifier.span.clone(), "not needed")
                    .help("rates that are not given follow from the constraints by one linear solve: remove this entry"),
            );
        }
    }
}

fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Coordinates that nothing uses are errors, parameters that nothing uses are warnings.
fn used(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let inertial = scene.bodies.iter().flat_map(|body| {
        let com = body.com.iter().flatten().filter(|_| body.mass.is_some());
        com.chain(body.angle.iter().filter(|_| body.inertia.is_some()))
    });
    let moving: Vec<&Value> = inertial.chain(scene.constraints.iter().map(|c| &c.residual)).collect();
    let moved: Vec<usize> = moving.iter().flat_map(|value| scene.coordinates_of(value)).collect();
    for (i, syntax) in document.coordinates.iter().enumerate() {
        if !moved.contains(&i) {
            let name = &syntax.identifier.name;
            findings.push(
                Diagnostic::error(
                    format!("nothing depends on coordinate `{name}`"),
                    syntax.identifier.span.clone(),
                    "no mass moves with it and no constraint holds it",
                )
                .help("use it in a position, an angle or a constraint, or take it out"),
            );
        }
    }
    let mentioned: Vec<&Quantity> = all_values(scene).into_iter().flat_map(crate::expression::Expression::names).collect();
    for (i, syntax) in document.parameters.iter().enumerate() {
        if !mentioned.contains(&&Quantity::Parameter(i)) {
            let name = &syntax.identifier.name;
            findings.push(Diagnostic::warning(
                format!("parameter `{name}` is never used"),
                syntax.identifier.span.clone(),
                "nothing depends on it",
            ));
        }
    }
}

fn all_values(scene: &Scene) -> Vec<&Value> {
    let mut values: Vec<&Value> = scene.parameters.iter().map(|p| &p.formula).collect();
    values.extend(scene.points.iter().flat_map(|p| &p.position));
    for body in &scene.bodies {
        values.extend([&body.mass, &body.inertia, &body.angle].into_iter().flatten());
        values.extend(body.com.iter().flatten());
    }
    values.extend(scene.constraints.iter().map(|c| &c.residual));
    for load in &scene.loads {
        match &load.kind {
            LoadKind::Force { force, at } => values.extend(force.iter().chain(at)),
            LoadKind::Torque { torque, angle } => values.extend([torque, angle]),
            LoadKind::Gravity(field) => values.extend(field),
            LoadKind::Spring { along, stiffness, rest, damping } => {
                values.push(along);
                values.extend([stiffness, rest, damping].into_iter().flatten());
            }
        }
    }
    for output in &scene.outputs {
        match &output.kind {
            OutputKind::Value(v) | OutputKind::Rate(v) | OutputKind::SecondRate(v) => values.push(v),
            OutputKind::ReactionForce { along, .. } => values.extend(along),
            OutputKind::ReactionMoment { .. } => {}
        }
    }
    for coordinate in &scene.coordinates {
        for start in [&coordinate.position, &coordinate.rate] {
            if let Start::Given(value) | Start::Guess(value) = start {
                values.push(value);
            }
        }
    }
    values.extend([&scene.run.step, &scene.run.end_time]);
    values.extend(scene.run.until.iter().map(|c| &c.difference));
    values
}
