//! Friction with a normal force: the allowed normal forces, and conflicts with other features.

use crate::diagnostic::Diagnostic;
use crate::document::{Document, LoadSyntax};
use crate::linkage::load_of_joint;
use crate::scene::{OutputKind, Scene};

/// Checks that a normal force is a reaction, and that no function that takes accelerations as arguments needs it.
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
            findings
                .push(error.help("name an output with `reaction`, `free_body`, `joint`, or the `norm` of two of them"));
        }
    }
    let Some((load, normal)) = first else { return };
    let owner = owner(document, &load.name);
    let title = |what: &str| format!("{what}, while the friction of {owner} depends on the force in a joint");
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

/// The owner of a friction load in words: a joint, or the load itself.
pub(super) fn owner(document: &Document, load: &str) -> String {
    let joints = document.joints.iter().filter(|joint| joint.friction.is_some());
    let mut joints = joints.map(|joint| &joint.identifier.name);
    match joints.find(|joint| load_of_joint(joint) == load) {
        Some(joint) => format!("joint `{joint}`"),
        None => format!("load `{load}`"),
    }
}

/// Whether an output is a joint force, or the size of one.
fn is_force(scene: &Scene, kind: &OutputKind) -> bool {
    let is_component =
        |kind: &OutputKind| matches!(kind, OutputKind::ReactionForce { .. } | OutputKind::FreeBody { .. });
    match kind {
        OutputKind::Norm { components, .. } => components.iter().all(|i| is_component(&scene.outputs[*i].kind)),
        kind => is_component(kind),
    }
}
