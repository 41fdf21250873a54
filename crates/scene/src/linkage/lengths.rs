//! Lengths of links and rods that no part can have.

use super::constants::Constants;
use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier, JointKind, Shape};
use crate::parser::Formula;

/// Reports bars, triangles and rods with a side that is not above zero.
pub(super) fn check(document: &Document, constants: &Constants, findings: &mut Vec<Diagnostic>) {
    let mut check = |what: &str, identifier: &Identifier, lengths: &[Formula]| {
        for length in lengths {
            let value = constants.value(length);
            if value <= 0.0 {
                let title = format!("{what} `{}` has a length of {value} m", identifier.name);
                let error = Diagnostic::error(title, length.whole_span(), "not above zero");
                findings.push(error.help("a length is positive; directions are given by angles and points"));
            }
        }
    };
    for link in &document.links {
        match &link.shape {
            Some(Shape::Bar(length)) => check("link", &link.identifier, std::slice::from_ref(length)),
            Some(Shape::Triangle(sides)) => check("link", &link.identifier, sides),
            None => {}
        }
    }
    for joint in document.joints.iter().filter(|joint| joint.kind == JointKind::Rod) {
        check(if joint.is_cylinder { "cylinder" } else { "rod" }, &joint.identifier, joint.size.as_slice());
    }
}
