//! The names of the columns of a trajectory.

use std::collections::HashSet;

use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier};

/// Checks that the names of all columns of a trajectory are unique.
pub(super) fn columns(document: &Document, findings: &mut Vec<Diagnostic>) {
    let mut columns: Vec<String> =
        ["t", "residual_position", "residual_velocity", "energy"].map(str::to_owned).to_vec();
    let coordinates =
        document.coordinates.iter().flat_map(|c| ["", "_dot", "_ddot"].map(|suffix| ("", &c.identifier, suffix)));
    let constraints = document.constraints.iter().map(|c| ("lambda_", &c.identifier, ""));
    for (prefix, Identifier { name, span }, suffix) in coordinates.chain(constraints) {
        let column = format!("{prefix}{name}{suffix}");
        if columns.contains(&column) {
            let title = format!("`{name}` makes a second column `{column}`");
            findings.push(
                Diagnostic::error(title, span.clone(), "every trajectory has this column already")
                    .help("choose another name"),
            );
        }
        columns.push(column);
    }
    let mut outputs = HashSet::new();
    for output in &document.outputs {
        let name = &output.identifier.name;
        if !outputs.insert(name) {
            let title = format!("two outputs make the column `{name}`");
            findings.push(
                Diagnostic::error(title, output.identifier.span.clone(), "a force in a joint has `_x` and `_y`")
                    .help("choose another name"),
            );
        }
        if columns.contains(&output.identifier.name) {
            findings.push(
                Diagnostic::error(
                    format!("output `{}` has the name of another column", output.identifier.name),
                    output.identifier.span.clone(),
                    "every trajectory has this column",
                )
                .help("choose another name, or take the output out"),
            );
        }
    }
}
