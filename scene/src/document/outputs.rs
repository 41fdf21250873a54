//! Entries of `[outputs]`.

use super::table::{self, Reader};
use super::{Identifier, Target};
use crate::diagnostic::Diagnostic;
use crate::parser::Formula;

/// An entry of `[outputs]`.
#[derive(Debug)]
pub struct OutputSyntax {
    /// Its name.
    pub identifier: Identifier,
    /// What is computed.
    pub value: OutputValue,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub doc: String,
}

/// What an output is made of.
#[derive(Debug)]
pub enum OutputValue {
    /// A formula of coordinates.
    Value(Formula),
    /// The time derivative of one.
    Rate(Formula),
    /// The second time derivative of one.
    SecondRate(Formula),
    /// The power of a load, or of a constraint that depends on time.
    Power(Identifier),
    /// The physical force of a constraint on a point along a direction, or its moment on a body.
    Reaction {
        /// The constraint.
        constraint: Identifier,
        /// What the force acts on.
        target: Target,
        /// The direction; none for a moment.
        along: Option<[Formula; 2]>,
    },
    /// The force on bodies along a direction, beside loads and constraints that act on points of theirs.
    FreeBody {
        /// The bodies.
        bodies: Vec<Identifier>,
        /// The points that are displaced with them.
        points: Vec<Identifier>,
        /// The direction.
        along: [Formula; 2],
    },
    /// The root of the sum of the squares of two outputs.
    Norm(Vec<Identifier>),
    /// The force in a joint: its components and its size.
    Joint(Identifier),
}

pub(super) fn output(r: &mut Reader, identifier: Identifier, value: table::Value) -> Option<OutputSyntax> {
    if !value.is_table() {
        let value = OutputValue::Value(r.formula(value));
        return Some(OutputSyntax { identifier, value, unit: String::new(), doc: String::new() });
    }
    let table = r.table(&format!("output `{}`", identifier.name), value)?;
    let (unit, doc) = (table.string(r, "unit"), table.string(r, "doc"));
    let help = "an output is a value, its rate, its second rate, the reaction of a constraint, the power of a load or the \
                force in a joint";
    let keys = ["value", "rate", "second_rate", "reaction", "power", "joint", "free_body", "norm"];
    let kind = table.one_of(r, &keys, help)?;
    let asked = table.required(r, kind)?;
    let value = match kind {
        "value" => Some(OutputValue::Value(r.formula(asked))),
        "rate" => Some(OutputValue::Rate(r.formula(asked))),
        "second_rate" => Some(OutputValue::SecondRate(r.formula(asked))),
        "power" => r.text(asked).map(OutputValue::Power),
        "joint" => r.text(asked).map(OutputValue::Joint),
        "norm" => Some(OutputValue::Norm(names(r, asked))),
        "free_body" => {
            let bodies = names(r, asked);
            let points = table.optional("points").map(|v| names(r, v)).unwrap_or_default();
            table.required(r, "along").map(|v| OutputValue::FreeBody { bodies, points, along: r.pair(v) })
        }
        _ => {
            let constraint = r.text(asked);
            let target = table.target(r);
            let along = match target {
                Some(Target::Point(_)) => table.required(r, "along").map(|v| r.pair(v)),
                _ => table.optional("along").map(|v| {
                    let error = Diagnostic::error("a moment has no direction", v.span(), "not needed");
                    r.findings.push(error.help("take `along` out, or ask for the force on a point with `at`"));
                    r.pair(v)
                }),
            };
            constraint.zip(target).map(|(constraint, target)| OutputValue::Reaction { constraint, target, along })
        }
    };
    table.finish(r);
    Some(OutputSyntax { identifier, value: value?, unit, doc })
}

/// A list of names.
fn names(r: &mut Reader, value: table::Value) -> Vec<Identifier> {
    r.array(value).into_iter().filter_map(|item| r.text(item)).collect()
}
