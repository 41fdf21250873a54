//! Finds declarations that a scene does not use.

use crate::diagnostic::Diagnostic;
use crate::document::Document;
use crate::scene::{Quantity, Scene, Start, Value};

/// Reports unused coordinates as errors and unused parameters as warnings.
pub(super) fn used(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let inertial = scene.bodies.iter().flat_map(|body| {
        let com = body.com.iter().flatten().filter(|_| body.mass.is_some());
        com.chain(body.angle.iter().filter(|_| body.inertia.is_some()))
    });
    let moved = scene.coordinates_of(inertial.chain(scene.constraints.iter().map(|c| &c.residual)));
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
    let mut is_mentioned = vec![false; scene.parameters.len()];
    for name in all_values(scene).into_iter().flat_map(crate::expression::Expression::names) {
        if let Quantity::Parameter(i) = *name {
            is_mentioned[i] = true;
        }
    }
    for (i, syntax) in document.parameters.iter().enumerate() {
        if !is_mentioned[i] {
            let name = &syntax.identifier.name;
            findings.push(Diagnostic::warning(
                format!("parameter `{name}` is never used"),
                syntax.identifier.span.clone(),
                "nothing depends on it",
            ));
        }
    }
}

/// Every formula of a scene.
pub fn all_values(scene: &Scene) -> Vec<&Value> {
    let mut values: Vec<&Value> = scene.parameters.iter().map(|p| &p.formula).collect();
    values.extend(scene.points.iter().flat_map(|p| &p.position));
    values.extend(motion_values(scene));
    for coordinate in &scene.coordinates {
        for start in [&coordinate.position, &coordinate.rate] {
            if let Start::Given(value) | Start::Guess(value) = start {
                values.push(value);
            }
        }
    }
    values.extend(scene.drawing.iter().flat_map(|drawn| drawn.kind.values()));
    for reference in &scene.references {
        values.extend([&reference.t, &reference.accuracy]);
        values.extend(reference.values.iter().map(|(_, value)| value));
    }
    for extreme in &scene.extremes {
        values.extend(extreme.set.iter().map(|(_, value)| value));
        values.extend([&extreme.end_time, &extreme.accuracy].into_iter().flatten());
        values.extend(extreme.values.iter().map(|(_, value)| value));
    }
    values.extend([&scene.run.step, &scene.run.end_time]);
    values.extend(scene.run.until.iter().map(|c| &c.difference));
    values
}

/// The formulae of bodies, constraints, loads and outputs.
pub fn motion_values(scene: &Scene) -> Vec<&Value> {
    let mut values = Vec::new();
    for body in &scene.bodies {
        values.extend([&body.mass, &body.inertia, &body.angle].into_iter().flatten());
        values.extend(body.com.iter().flatten());
    }
    values.extend(scene.constraints.iter().map(|c| &c.residual));
    values.extend(scene.loads.iter().flat_map(|load| load.kind.formulae()));
    values.extend(scene.outputs.iter().flat_map(|output| output.kind.formulae()));
    values
}
