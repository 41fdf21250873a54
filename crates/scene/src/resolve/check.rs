//! Rules of a scene in addition to known names.

mod columns;
mod freedoms;
mod units;

use super::usage::all_values;
use crate::diagnostic::Diagnostic;
use crate::document::{BodySyntax, Document};
use crate::evaluate::{evaluate, known_values};
use crate::expression::Node;
use crate::scene::{Friction, Known, Load, LoadKind, Quantity, Scene, Value};
use columns::columns;
use freedoms::freedoms;
pub(crate) use units::misfit;
use units::{parameters, relaxed_angles, units};

/// Checks the parts of a scene whose parameters have values. Parts with unknown names are skipped.
pub(super) fn parts(document: &Document, scene: &Scene, source: &str, findings: &mut Vec<Diagnostic>) {
    units(document, findings);
    relaxed_angles(scene, source, findings);
    parameters(document, scene, findings);
    finite_constants(scene, findings);
    for (syntax, place) in document.bodies.iter().zip(0..) {
        body(syntax, scene, place, findings);
    }
    prescribed_bodies(scene, findings);
    loads(scene, findings);
    run(scene, findings);
    references(document, scene, findings);
    for constraint in &scene.constraints {
        if Scene::is_known(&constraint.residual) && scene.coordinates_of([&constraint.residual]).is_empty() {
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
}

/// Checks how the parts of a scene fit together, once each has a name and a valid start.
pub(super) fn whole(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    columns(document, findings);
    freedoms(document, scene, findings);
}

/// Reports functions that the generator cannot differentiate; corners are allowed where only the first derivative is
/// needed.
pub(super) fn differentiable(value: &Value, is_smooth: bool, findings: &mut Vec<Diagnostic>) {
    for (id, node) in value.nodes().iter().enumerate() {
        let mut report = |name: &str, before: &str| {
            let loads = if node.is_piecewise() { "loads, " } else { "" };
            let help =
                format!("{before}`{name}` may stand in {loads}values of parameters, first guesses and stop conditions");
            let title = format!("`{name}` cannot be differentiated");
            findings.push(Diagnostic::error(title, value.span(id), "not smooth here").help(help));
        };
        match node {
            Node::Call(function, _) if !function.is_differentiable() && (is_smooth || !node.is_piecewise()) => {
                report(function.name(), "");
            }
            Node::Spline(spline, _) if is_smooth && node.is_piecewise() => {
                report(&spline.name, "lay a spline through the points, `spline = \"natural\"`; without it, ");
            }
            Node::Power(_, exponent) if !is_number(value, *exponent) => findings.push(
                Diagnostic::error("the exponent is not a number", value.span(*exponent), "not made of numbers alone")
                    .help("write `exp(b*log(a))` for a power `a^b` with a variable exponent"),
            ),
            _ => {}
        }
    }
}

/// Whether an operation and its operands consist of numbers alone.
fn is_number(value: &Value, id: usize) -> bool {
    let mut pending = vec![id];
    while let Some(id) = pending.pop() {
        match &value.nodes()[id] {
            Node::Number(_) => {}
            Node::Negate(a) => pending.push(*a),
            Node::Divide(a, b) | Node::Multiply(a, b) | Node::Add(a, b) | Node::Subtract(a, b) => {
                pending.extend([*a, *b])
            }
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

/// Checks that every constant part of a formula has a finite value, for the parameter values of the file.
fn finite_constants(scene: &Scene, findings: &mut Vec<Diagnostic>) {
    for value in all_values(scene) {
        let known = known_values(value, |quantity| match quantity {
            Quantity::Parameter(_) | Quantity::Pi => Some(lookup(scene, *quantity)),
            _ => None,
        });
        let number = |id: usize| known[id].unwrap_or(f64::NAN);
        let is_bad = |id: &usize| known[*id].is_some_and(|v| !v.is_finite());
        let Some(id) = (0..known.len()).find(is_bad) else { continue };
        let label = match &value.nodes()[id] {
            Node::Call(function, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(|&a| format!("{}", number(a))).collect();
                format!("`{}` of {} is not a number", function.name(), arguments.join(", "))
            }
            // The formula of the parameter has been reported already.
            Node::Name(_) => continue,
            Node::Divide(_, divisor) if number(*divisor) == 0.0 => "divides by zero".to_owned(),
            _ => "gives no finite number".to_owned(),
        };
        findings.push(
            Diagnostic::error("a formula has no finite value", value.span(id), label)
                .help("every value must be finite at the values that the parameters have"),
        );
    }
}

fn body(syntax: &BodySyntax, scene: &Scene, place: usize, findings: &mut Vec<Diagnostic>) {
    let body = &scene.bodies[place];
    let name = &body.name;
    if let Some((what, value, number)) = body.negative_inertia(|value| constant(scene, value)) {
        let label = format!("its value is {number}");
        findings.push(
            Diagnostic::error(format!("body `{name}` has a negative {what}"), value.whole_span(), label)
                .help(format!("{} must be zero or positive", article(what))),
        );
    }
    let pairs = [
        ("mass", &body.mass, syntax.com.is_some(), "com"),
        ("inertia", &body.inertia, syntax.angle.is_some(), "angle"),
    ];
    for (what, value, placed, needed) in pairs {
        let Some(value) = value else { continue };
        if !placed {
            findings.push(
                Diagnostic::error(
                    format!(
                        "body `{name}` has {} but no {}",
                        article(what),
                        if needed == "com" { "position" } else { "angle" }
                    ),
                    value.whole_span(),
                    format!("needs `{needed}`"),
                )
                .help(format!("add `{needed} = ...` to the body, or take its {what} away")),
            );
        }
    }
    if syntax.mass.is_none() && syntax.inertia.is_none() && syntax.com.is_none() && syntax.angle.is_none() {
        findings.push(
            Diagnostic::error(format!("body `{name}` is empty"), syntax.identifier.span.clone(), "says nothing")
                .help("give it `mass` and `com`, or `angle` and `inertia`, or take it out"),
        );
    }
}

/// Checks that friction resists motion, and that loads act on something that moves.
fn loads(scene: &Scene, findings: &mut Vec<Diagnostic>) {
    for Load { name, kind } in &scene.loads {
        if let LoadKind::Spring { friction: Some(Friction { size, slip, owner, .. }), .. } = kind {
            // Not a number if it is not constant.
            for (what, value, is_bad) in [
                ("the friction of OWNER is negative", size, constant(scene, size) < 0.0),
                ("the slip of OWNER is not positive", slip, constant(scene, slip) <= 0.0),
            ] {
                if is_bad {
                    let label = format!("its value is {}", constant(scene, value));
                    let title = what.replace("OWNER", owner);
                    let help = "friction is `-friction*tanh(s_dot/slip)`: it would drive the motion instead";
                    findings.push(Diagnostic::error(title, value.whole_span(), label).help(help));
                }
            }
        }
        let places = kind.places();
        if !places.is_empty()
            && places.iter().all(|place| Scene::is_known(place) && scene.coordinates_of([*place]).is_empty())
        {
            let span = places.first().map_or(0..0, |place| place.whole_span());
            findings.push(Diagnostic::warning(
                format!("load `{name}` moves nothing"),
                span,
                "no coordinate moves this",
            ));
        }
    }
}

/// Reports bodies whose position or angle depends on time directly: the energy balance would lack the work of the
/// prescribed motion.
fn prescribed_bodies(scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let places = scene.bodies.iter().flat_map(|body| body.com.iter().flatten().chain(&body.angle));
    if !scene.depends_on_time(places) {
        return;
    }
    for body in &scene.bodies {
        let places = body.com.iter().flatten().chain(&body.angle);
        if let Some(place) = places.into_iter().find(|place| scene.depends_on_time([*place])) {
            findings.push(
                Diagnostic::error(
                    format!("body `{}` is moved by time alone", body.name),
                    place.whole_span(),
                    "depends on `t`",
                )
                .help(
                    "give the motion a coordinate, and drive it by a constraint such as `s - A*sin(w*t)`: its \
                     multiplier is then the force that drives the body",
                ),
            );
        }
    }
}

fn article(what: &str) -> String {
    if what == "inertia" { "an inertia".to_owned() } else { format!("a {what}") }
}

fn run(scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let extremes = scene.extremes.iter().filter_map(|extreme| extreme.end_time.as_ref().map(|t| ("end", t)));
    for (what, value) in [("step", &scene.run.step), ("end", &scene.run.end_time)].into_iter().chain(extremes) {
        let number = constant(scene, value);
        if number <= 0.0 {
            let label = format!("its value is {number}");
            findings.push(
                Diagnostic::error(format!("the {what} of the run is not positive"), value.whole_span(), label)
                    .help("give a time above zero"),
            );
        }
    }
}

/// Checks that reference values have a time within the motion and an attainable accuracy, and are unique.
fn references(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let mut seen: Vec<(f64, Known)> = Vec::new();
    for (reference, syntax) in scene.references.iter().zip(&document.references) {
        let name = &reference.name;
        let mut wrong = |title: String, value: &Value, label: String, help: &str| {
            findings.push(Diagnostic::error(title, value.whole_span(), label).help(help));
        };
        let (t, accuracy) = (constant(scene, &reference.t), constant(scene, &reference.accuracy));
        if t < 0.0 {
            let title = format!("`{name}` is from before the start");
            wrong(title, &reference.t, format!("its value is {t}"), "the motion begins at t = 0");
        }
        if accuracy <= 0.0 {
            let title = format!("the accuracy of `{name}` is not positive");
            wrong(
                title,
                &reference.accuracy,
                format!("its value is {accuracy}"),
                "give the largest error of the values",
            );
        }
        if syntax.values.is_empty() {
            let help = "add values of coordinates, rates or outputs: `values = { NAME = ... }`";
            wrong(format!("`{name}` has no values"), &reference.t, "nothing is known at this time".to_owned(), help);
        }
        for (known, value) in &reference.values {
            if seen.contains(&(t, *known)) {
                let title = format!("`{name}` gives a value a second time");
                wrong(title, value, format!("is known at t = {t} already"), "take one of them out");
            }
            seen.push((t, *known));
        }
    }
    for extreme in &scene.extremes {
        let Some(accuracy) = &extreme.accuracy else { continue };
        let value = constant(scene, accuracy);
        if value <= 0.0 {
            let title = format!("the accuracy of `{}` is not positive", extreme.name);
            let error = Diagnostic::error(title, accuracy.whole_span(), format!("its value is {value}"));
            findings.push(error.help("give the largest error of the values"));
        }
    }
}
