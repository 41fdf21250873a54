//! Units that differ from those in which a scene computes.

use crate::diagnostic::Diagnostic;
use crate::document::{CoordinateSyntax, Document, Identifier, OutputSyntax, OutputValue};
use crate::expression::Node;

/// Units other than rad, m, s, N, J and W.
const SCALED: [&str; 27] = [
    "deg", "°", "grad", "rev", "rpm", "um", "µm", "mm", "cm", "dm", "km", "in", "inch", "ft", "mN", "kN", "MN", "lbf",
    "mJ", "kJ", "MJ", "mW", "kW", "MW", "ms", "min", "h",
];

/// Reports units of coordinates, and of outputs that are computed without a factor, that the numbers do not have.
pub(super) fn units(document: &Document, findings: &mut Vec<Diagnostic>) {
    for CoordinateSyntax { identifier, unit, .. } in &document.coordinates {
        let help = "write `unit = \"rad\"` or `unit = \"m\"`; an output converts, such as `value = 'phi*180/pi'`";
        report("coordinate", identifier, unit, help, findings);
    }
    for OutputSyntax { identifier, value, unit, .. } in &document.outputs {
        let help = match value {
            OutputValue::Value(_) => "write the factor in the formula: `value = 'phi*180/pi'` or `value = 'x*1000'`",
            _ => "write the unit of the number",
        };
        if has_no_factor(document, value) {
            report("output", identifier, unit, help, findings);
        }
    }
}

/// Reports a unit that is scaled.
fn report(what: &str, identifier: &Identifier, unit: &str, help: &str, findings: &mut Vec<Diagnostic>) {
    let mut parts = unit.split(['/', '*', '^', ' ']);
    if !parts.next().is_some_and(|first| SCALED.contains(&first)) && !parts.any(|part| part == "min" || part == "h") {
        return;
    }
    let title = format!("{what} `{}` has the unit `{unit}`, and its numbers do not", identifier.name);
    let label = "in rad, m, s, N, J and W: a unit does not convert numbers";
    findings.push(Diagnostic::error(title, identifier.span.clone(), label).help(help));
}

/// Whether an output takes no formula, or is a coordinate, its rate, or the coordinate of a point.
fn has_no_factor(document: &Document, value: &OutputValue) -> bool {
    match value {
        OutputValue::Value(formula) | OutputValue::Rate(formula) | OutputValue::SecondRate(formula) => {
            let [Node::Name(name)] = formula.nodes() else { return false };
            !document.parameters.iter().any(|parameter| parameter.identifier.name == *name)
        }
        OutputValue::ShakingForce(_) | OutputValue::Reaction { along: Some(_), .. } | OutputValue::FreeBody { .. } => {
            false
        }
        _ => true,
    }
}
