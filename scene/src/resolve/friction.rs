//! Friction that follows from the load of a joint: what may be its normal force, and what rules it out.

use crate::diagnostic::Diagnostic;
use crate::document::{Document, LoadSyntax};
use crate::scene::{OutputKind, Scene};

/// A normal force is a reaction; functions that take accelerations as given know nothing of the forces behind them.
pub(super) fn check(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let mut first = None;
    for (load, syntax) in &document.loads {
        let LoadSyntax::Spring(spring) = syntax else { continue };
        let Some(normal) = spring.friction.as_ref().and_then(|friction| friction.normal.as_ref()) else { continue };
        first.get_or_insert((load, normal));
        let known = scene.outputs.iter().find(|output| output.name == normal.name);
        if known.is_some_and(|output| !is_force(scene, &output.kind)) {
            let title = format!("output `{}` is not the force in a joint", normal.name);
            let error = Diagnostic::error(title, normal.span.clone(), "no normal force");
            findings.push(error.help("name an output with `reaction`, `free_body`, `joint`, or the `norm` of two of them"));
        }
    }
    let Some((load, normal)) = first else { return };
    let title = |what: &str| format!("{what}, while the friction of load `{}` depends on the force in a joint", load.name);
    for (span, what, help) in [
        (&document.run.stiff, "`stiff = true`", "take `stiff` out; explicit methods and `gauss` need no Jacobians"),
        (
            &document.run.inverse,
            "`inverse = true`",
            "prescribe the motion by a `drive` instead, and ask for its torque in [outputs]",
        ),
    ] {
        let Some(span) = span else { continue };
        let error = Diagnostic::error(title(what), span.clone(), "not possible together");
        findings.push(error.context(normal.span.clone(), "the normal force").help(help));
    }
}

/// Whether an output is the force in a joint, or the size of one.
fn is_force(scene: &Scene, kind: &OutputKind) -> bool {
    let is_component =
        |kind: &OutputKind| matches!(kind, OutputKind::ReactionForce { .. } | OutputKind::FreeBody { .. });
    match kind {
        OutputKind::Norm { components, .. } => components.iter().all(|i| is_component(&scene.outputs[*i].kind)),
        kind => is_component(kind),
    }
}
