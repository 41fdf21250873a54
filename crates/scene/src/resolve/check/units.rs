//! Units that differ from those in which a scene computes.

use crate::diagnostic::Diagnostic;
use crate::document::{CoordinateSyntax, Document, Identifier, OutputSyntax, OutputValue};
use crate::expression::Node;

/// Units other than rad, m, kg, s, N and W, and the unit that takes their place.
const SCALED: [(&str, &str); 24] = [
    ("deg", "rad"),
    ("degree", "rad"),
    ("degrees", "rad"),
    ("°", "rad"),
    ("grad", "rad"),
    ("turn", "rad"),
    ("turns", "rad"),
    ("rev", "rad"),
    ("rpm", "rad/s"),
    ("um", "m"),
    ("mm", "m"),
    ("cm", "m"),
    ("dm", "m"),
    ("km", "m"),
    ("in", "m"),
    ("inch", "m"),
    ("ft", "m"),
    ("mN", "N"),
    ("kN", "N"),
    ("MN", "N"),
    ("lbf", "N"),
    ("mW", "W"),
    ("kW", "W"),
    ("ms", "s"),
];

/// Reports units of coordinates, and of outputs that are computed without a factor, that the numbers do not have.
pub(super) fn units(document: &Document, findings: &mut Vec<Diagnostic>) {
    let converted = "`value = 'phi*180/pi'` or `value = 'x*1000'`";
    for CoordinateSyntax { identifier, unit, .. } in &document.coordinates {
        let help = |own: &str| format!("write `unit = \"{own}\"`; an output converts: {converted}");
        report("coordinate", identifier, unit, &help, findings);
    }
    for OutputSyntax { identifier, value, unit, .. } in &document.outputs {
        let help = |own: &str| match value {
            OutputValue::Value(_) => format!("write the factor in the formula: {converted}"),
            _ => format!("write `unit = \"{own}\"`"),
        };
        if has_no_factor(document, value) {
            report("output", identifier, unit, &help, findings);
        }
    }
}

/// Reports a unit that is scaled; the help depends on the unit that takes its place.
fn report(
    what: &str,
    identifier: &Identifier,
    unit: &str,
    help: &dyn Fn(&str) -> String,
    findings: &mut Vec<Diagnostic>,
) {
    let mut parts = unit.split(|c: char| !(c.is_alphabetic() || c == '°'));
    let known = parts.find_map(|part| SCALED.iter().find(|(scaled, _)| *scaled == part));
    let Some((scaled, plain)) = known else { return };
    let own = unit.replacen(scaled, plain, 1);
    let title = format!("{what} `{}` is in {own}, not in {unit}", identifier.name);
    let error = Diagnostic::error(title, identifier.span.clone(), "a unit does not convert numbers");
    findings.push(error.help(help(&own)));
}

/// Whether an output is not a formula, or is a coordinate, its rate, or the coordinate of a point.
fn has_no_factor(document: &Document, value: &OutputValue) -> bool {
    match value {
        OutputValue::Value(formula) | OutputValue::Rate(formula) | OutputValue::SecondRate(formula) => {
            let [Node::Name(name)] = formula.nodes() else { return false };
            !document.parameters.iter().any(|parameter| parameter.identifier.name == *name)
        }
        _ => true,
    }
}
