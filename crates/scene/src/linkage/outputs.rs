//! The conversion of outputs of joints into outputs of an ordinary scene.

use super::closures::DRIVE;
use super::forces::force;
use super::moments::{drive, moment};
use super::resolved::Linkage;
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier, JointKind, JointPart, OutputSyntax, OutputValue};
use crate::names::suggestion;
use crate::resolve::misfit;

/// Whether outputs of the scene, or friction, need the force or the moment of a joint.
pub(super) fn are_of_joints(document: &Document) -> bool {
    let part = |output: &OutputSyntax| match output.value {
        OutputValue::Joint { part, .. } => Some(part),
        _ => None,
    };
    let has_friction = document.joints.iter().any(|joint| joint.friction.is_some());
    has_friction || document.outputs.iter().filter_map(part).any(|part| part != JointPart::Drive)
}

/// Whether the scene has an output for the reaction of a constraint.
pub(super) fn are_reactions(document: &Document) -> bool {
    document.outputs.iter().any(|output| matches!(output.value, OutputValue::Reaction { .. }))
}

/// The outputs that replace each output; `None` where the output stays.
pub(super) fn outputs(
    document: &Document,
    linkage: &Linkage,
    findings: &mut Vec<Diagnostic>,
) -> Vec<Option<Vec<OutputSyntax>>> {
    let of = |output: &OutputSyntax| match &output.value {
        OutputValue::Joint { joint, part, on } => match joint_outputs(linkage, output, joint, *part, on.as_ref()) {
            Ok(outputs) => Some(outputs),
            Err(error) => {
                findings.push(error);
                Some(Vec::new())
            }
        },
        OutputValue::Power(name) => power(document, linkage, output, name),
        _ => None,
    };
    document.outputs.iter().map(of).collect()
}

/// The power of a joint's drive, unless a load or a constraint has this name.
fn power(
    document: &Document,
    linkage: &Linkage,
    output: &OutputSyntax,
    name: &Identifier,
) -> Option<Vec<OutputSyntax>> {
    let loads = document.loads.iter().map(|(load, _)| load);
    let constraints = document.constraints.iter().map(|constraint| &constraint.identifier);
    let mut own = loads.chain(constraints).map(|own| &own.name);
    let joint = linkage.graph.joints.iter().find(|joint| joint.syntax.identifier.name == name.name)?;
    if joint.syntax.drive.is_none() || own.any(|own| *own == name.name) {
        return None;
    }
    let constraint = Identifier { name: format!("{}{DRIVE}", name.name), span: name.span.clone() };
    Some(vec![OutputSyntax {
        identifier: output.identifier.clone(),
        value: OutputValue::Power(constraint),
        unit: output.unit.clone(),
        doc: output.doc.clone(),
    }])
}

fn joint_outputs(
    linkage: &Linkage,
    output: &OutputSyntax,
    asked: &Identifier,
    part: JointPart,
    on: Option<&Identifier>,
) -> Result<Vec<OutputSyntax>, Diagnostic> {
    let graph = linkage.graph;
    let names: Vec<&str> = graph.joints.iter().map(|joint| joint.syntax.identifier.name.as_str()).collect();
    let Some(number) = names.iter().position(|name| *name == asked.name) else {
        let help = suggestion(&asked.name, names.iter().copied(), || format!("joints: {}", names.join(", ")));
        let title = format!("unknown joint `{}`", asked.name);
        return Err(Diagnostic::error(title, asked.span.clone(), "not known").help(help));
    };
    let joint = &graph.joints[number];
    let on = match on {
        None => joint.ends[0],
        Some(link) => *joint.ends.iter().find(|end| graph.name(end.link) == link.name).ok_or_else(|| {
            let title = format!("joint `{}` does not join link `{}`", asked.name, link.name);
            let links: Vec<&str> = joint.ends.iter().map(|end| graph.name(end.link)).collect();
            let help = suggestion(&link.name, links.iter().copied(), || format!("its links: {}", links.join(", ")));
            Diagnostic::error(title, link.span.clone(), "not one of its links").help(help)
        })?,
    };
    let part_of = |suffix: &str, what: &str, unit: &str, value: OutputValue| OutputSyntax {
        identifier: Identifier {
            name: format!("{}{suffix}", output.identifier.name),
            span: output.identifier.span.clone(),
        },
        value,
        unit: if output.unit.is_empty() { unit.to_owned() } else { output.unit.clone() },
        doc: if output.doc.is_empty() { format!("{what} on {}", graph.name(on.link)) } else { output.doc.clone() },
    };
    let is_force = joint.syntax.kind.is_slider() || joint.syntax.is_cylinder;
    let expected = match part {
        JointPart::Moment => "N m",
        JointPart::Drive if !is_force => "N m",
        JointPart::Drive | JointPart::Force => "N",
    };
    if let Some(error) = misfit(&output.identifier, &output.unit, expected) {
        return Err(error);
    }
    match part {
        JointPart::Moment => Ok(vec![part_of("", "moment", "N m", moment(linkage, number, on, asked)?)]),
        JointPart::Drive => {
            let (what, unit) = if is_force { ("force", "N") } else { ("torque", "N m") };
            Ok(vec![part_of("", what, unit, drive(linkage, number, on, asked)?)])
        }
        JointPart::Force if joint.syntax.kind == JointKind::Gear => {
            let title = format!("joint `{}` has no force at a point", asked.name);
            let error = Diagnostic::error(title, asked.span.clone(), "it holds angles");
            Err(error.help("ask for its `moment`, or for the forces in the pins of the gears"))
        }
        JointPart::Force => {
            let component =
                |suffix: &str, way: [i32; 2]| part_of(suffix, "force", "N", force(linkage, number, on, way));
            let parts = [component("_x", [1, 0]), component("_y", [0, 1])];
            let components = parts.iter().map(|part| part.identifier.clone()).collect();
            let at = Identifier { name: linkage.places.name(on).to_owned(), span: asked.span.clone() };
            let norm = OutputValue::Norm { components, at: Some(at) };
            Ok(parts.into_iter().chain([part_of("", "force", "N", norm)]).collect())
        }
    }
}
