//! Checks that the start fixes as many values as the mechanism has degrees of freedom.

use crate::diagnostic::Diagnostic;
use crate::document::Document;
use crate::scene::{Scene, Start};

/// Redundant constraints increase the degrees of freedom beyond coordinates minus constraints; the rank of `C_q` shows
/// that only where the mechanism is assembled.
pub(super) fn freedoms(document: &Document, scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let (n, m) = (scene.coordinates.len(), scene.constraints.len());
    let freedoms = n.saturating_sub(m);
    let balance = format!("{} - {} = {}", count(n, "coordinate"), count(m, "constraint"), count(freedoms, "freedom"));
    let given = |start: fn(&crate::scene::Coordinate) -> &Start| {
        scene
            .coordinates
            .iter()
            .filter(|c| matches!(start(c), Start::Given(_)))
            .map(|c| c.name.as_str())
            .collect::<Vec<_>>()
    };
    for (what, names) in [("position", given(|c| &c.position)), ("rate", given(|c| &c.rate))] {
        if names.len() < freedoms {
            let suffix = if what == "rate" { "_dot" } else { "" };
            let listed = names.iter().map(|name| format!("{name}{suffix}")).collect::<Vec<_>>().join(", ");
            let listed = if names.is_empty() { String::new() } else { format!(" ({listed})") };
            let label = format!("{}{listed}", count(names.len(), &format!("given {what}")));
            let title = format!(
                "{balance}, but {} given",
                if names.len() == 1 { format!("1 {what} is") } else { format!("{} {what}s are", names.len()) }
            );
            let help = format!("give as many {what}s as there are freedoms, as `NAME{suffix} = ...` in `given`");
            findings.push(Diagnostic::error(title, document.given_span.clone(), label).help(help));
        }
    }
    for (coordinate, syntax) in scene.coordinates.iter().zip(&document.coordinates) {
        if matches!(coordinate.position, Start::Free) {
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
                Diagnostic::error("a rate needs no first guess", identifier.span.clone(), "not needed").help(
                    "rates that are not given follow from the constraints by one linear solve: remove this entry",
                ),
            );
        }
    }
}

fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
