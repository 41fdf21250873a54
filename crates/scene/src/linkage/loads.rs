//! Loads between points of links.

use super::graph::PointId;
use super::resolved::Linkage;
use crate::diagnostic::Diagnostic;
use crate::document::{Along, Document, Identifier, LoadSyntax};

/// Reports loads between two points that always coincide.
pub(super) fn check(document: &Document, linkage: &Linkage, findings: &mut Vec<Diagnostic>) {
    for (_, load) in &document.loads {
        let LoadSyntax::Spring(spring) = load else { continue };
        let Along::Between(first, second) = &spring.along else { continue };
        let Some(joint) = pin_of_both(linkage, first, second) else { continue };
        let title = format!("points `{}` and `{}` are always in one place", first.name, second.name);
        let label = format!("joint `{joint}` holds them together");
        findings.push(Diagnostic::error(title, second.span.clone(), label).help("name points that can move apart"));
    }
}

/// The pin that holds two different points together.
fn pin_of_both<'l>(linkage: &Linkage<'l>, first: &Identifier, second: &Identifier) -> Option<&'l str> {
    let has = |ends: &[PointId], name: &Identifier| ends.iter().any(|end| linkage.places.name(*end) == name.name);
    let joints = linkage.graph.joints.iter().filter(|joint| joint.syntax.kind.is_pin());
    let joint = joints.into_iter().find(|joint| has(&joint.ends, first) && has(&joint.ends, second))?;
    Some(&joint.syntax.identifier.name)
}
