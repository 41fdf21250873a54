//! Entries of `[outputs]`.

use super::reader::{self, Reader};
use super::{Identifier, Target};
use crate::diagnostic::Diagnostic;
use crate::linkage::terms;
use crate::parser::Formula;
use crate::unit::Unit;

/// An entry of `[outputs]`.
#[derive(Debug)]
pub struct OutputSyntax {
    /// The name of the output.
    pub identifier: Identifier,
    /// The quantity that is computed.
    pub value: OutputValue,
    /// The unit of the output.
    pub unit: String,
    /// The description of the output.
    pub doc: String,
}

/// The quantity that an output computes.
#[derive(Debug)]
pub enum OutputValue {
    /// A formula of coordinates.
    Value(Formula),
    /// The time derivative of a formula.
    Rate(Formula),
    /// The second time derivative of a formula.
    SecondRate(Formula),
    /// The power of a load, or of a constraint that depends on time.
    Power(Identifier),
    /// The physical force of a constraint on a point along a direction, or its moment on a body.
    Reaction {
        /// The constraint.
        constraint: Identifier,
        /// The point or body that the reaction acts on.
        target: Target,
        /// The direction; `None` for a moment.
        along: Option<[Formula; 2]>,
    },
    /// The force or moment on bodies other than loads and constraints, by a virtual displacement of the bodies.
    FreeBody {
        /// The virtual displacements, all made simultaneously.
        displacements: Vec<DisplacementSyntax>,
        /// Further terms: constraints and the factors of their multipliers.
        multipliers: Vec<(Identifier, Formula)>,
        /// Further terms: loads along a length and the factors of their forces.
        loads: Vec<(Identifier, Formula)>,
    },
    /// The force on the ground along a direction.
    ShakingForce([Formula; 2]),
    /// The moment on the ground about a point.
    ShakingMoment(Identifier),
    /// The size of the vector of two outputs.
    Norm {
        /// The names of the outputs that are the components of the vector.
        components: Vec<Identifier>,
        /// The point at which the vector is drawn.
        at: Option<Identifier>,
    },
    /// The force, the moment or the drive of a joint, by the name of the joint.
    Joint {
        /// The joint.
        joint: Identifier,
        /// The quantity of the joint that is computed.
        part: JointPart,
        /// The link on which it acts; by default the first one of the joint.
        on: Option<Identifier>,
    },
}

/// The force, the moment or the drive of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointPart {
    /// The components of the joint force and their size.
    Force,
    /// The joint moment.
    Moment,
    /// The torque or force of its drive.
    Drive,
}

/// A virtual displacement.
#[derive(Debug)]
pub struct DisplacementSyntax {
    /// The bodies.
    pub bodies: Vec<Identifier>,
    /// The points.
    pub points: Vec<Identifier>,
    /// The vector.
    pub along: Option<[Formula; 2]>,
    /// The size of an angle, the point about which the bodies turn, and the coordinate that turns.
    pub turn: Option<(Formula, Identifier, Option<Identifier>)>,
    /// The change of the place along a slider, and its coordinate.
    pub slide: Option<(Formula, Identifier)>,
}

/// The kinds of outputs.
const KEYS: [&str; 12] = [
    "value",
    "rate",
    "second_rate",
    "reaction",
    "power",
    "joint",
    "moment",
    "drive",
    "free_body",
    "shaking_force",
    "shaking_moment",
    "norm",
];

/// Whether an output is the force of a joint: its components have names of their own.
pub(super) fn is_force_of_joint(value: &OutputValue) -> bool {
    matches!(value, OutputValue::Joint { part: JointPart::Force, .. })
}

pub(super) fn output(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<OutputSyntax> {
    if !value.is_table() {
        let value = OutputValue::Value(r.formula(value));
        return Some(OutputSyntax { identifier, value, unit: String::new(), doc: String::new() });
    }
    let table = r.table(&format!("output `{}`", identifier.name), value)?;
    let doc = table.string(r, "doc");
    let help = "an output is a value, its rate, its second rate, the reaction of a constraint, the power of a load, or \
                the force in a joint, its moment, or its drive";
    let kind = table.one_of(r, &KEYS, help)?;
    let (text, unit) = table.unit(r);
    let text = match kind {
        "shaking_force" if text.is_empty() => "N".to_owned(),
        "shaking_moment" if text.is_empty() => "N m".to_owned(),
        _ => text,
    };
    let asked = table.required(r, kind)?;
    let mut formula = |times: &str| {
        let unit = unit.as_ref().zip(Unit::parse(times)).map(|(unit, time)| unit.times(&time, 1));
        let (formula, dimension) = r.with_dimension(asked, unit.as_ref());
        // A conversion needs a quantity; units of other outputs are those of their numbers.
        if let Some(unit) = unit.as_ref().filter(|unit| unit.is_scaled() && !formula.names().any(String::is_empty)) {
            r.findings.extend(dimension.converted().misfit(unit, formula.whole_span()));
        } else {
            r.check_dimension(&formula, &dimension, unit.as_ref());
        }
        formula
    };
    let value = match kind {
        "value" => Some(OutputValue::Value(formula("-"))),
        "rate" => Some(OutputValue::Rate(formula("s"))),
        "second_rate" => Some(OutputValue::SecondRate(formula("s^2"))),
        "power" => r.text(asked).map(OutputValue::Power),
        "joint" | "moment" | "drive" => {
            let part = match kind {
                "joint" => JointPart::Force,
                "moment" => JointPart::Moment,
                _ => JointPart::Drive,
            };
            let on = table.optional("on").and_then(|v| r.text(v));
            r.text(asked).map(|joint| OutputValue::Joint { joint, part, on })
        }
        "norm" => {
            let at = table.optional("at").and_then(|v| r.text(v));
            Some(OutputValue::Norm { components: names(r, asked), at })
        }
        "shaking_force" => Some(OutputValue::ShakingForce(r.pair(asked, "-"))),
        "shaking_moment" => r.text(asked).map(OutputValue::ShakingMoment),
        "free_body" => {
            let displacements = r.array(asked).into_iter().filter_map(|value| displacement(r, value)).collect();
            let mut factors = |key: &str| {
                let factors = table.optional(key).and_then(|v| r.table(&format!("the {key}"), v));
                let factors = factors.map_or_else(Vec::new, |table| table.all());
                factors.into_iter().map(|(name, v)| (name, r.formula(v))).collect()
            };
            let (multipliers, loads) = (factors("multipliers"), factors("loads"));
            Some(OutputValue::FreeBody { displacements, multipliers, loads })
        }
        _ => {
            let constraint = r.text(asked);
            let target = table.target(r);
            let along = match target {
                Some(Target::Point(_)) => table.required(r, "along").map(|v| r.pair(v, "-")),
                _ => table.optional("along").map(|v| {
                    let error = Diagnostic::error("a moment has no direction", v.span(), "not needed");
                    r.findings.push(error.help("take `along` out, or ask for the force on a point with `at`"));
                    r.pair(v, "-")
                }),
            };
            constraint.zip(target).map(|(constraint, target)| OutputValue::Reaction { constraint, target, along })
        }
    };
    table.finish(r);
    Some(OutputSyntax { identifier, value: value?, unit: text, doc })
}

fn displacement(r: &mut Reader, value: reader::Value) -> Option<DisplacementSyntax> {
    let table = r.table("a displacement", value)?;
    let mut list = |key: &str| table.optional(key).map(|v| names(r, v)).unwrap_or_default();
    let (bodies, points) = (list("bodies"), list("points"));
    let (size, angle) = (table.optional("turn"), table.optional("angle"));
    let turns = size.is_some() || angle.is_some();
    let about = if turns { table.required(r, "about") } else { table.optional("about") };
    let moves = about.is_none() && !turns;
    let along = if moves { table.required(r, "along") } else { table.optional("along") }.map(|v| r.pair(v, "-"));
    let size = size.map_or_else(|| terms::whole(1), |v| r.formula(v));
    let angle = angle.and_then(|v| r.text(v));
    let turn = about.and_then(|v| r.text(v)).map(|about| (size, about, angle));
    let slide = table.optional("slide").map(|v| r.formula(v));
    let coordinate = if slide.is_some() { table.required(r, "coordinate") } else { None };
    let slide = slide.zip(coordinate.and_then(|v| r.text(v)));
    table.finish(r);
    Some(DisplacementSyntax { bodies, points, along, turn, slide })
}

/// A list of names.
fn names(r: &mut Reader, value: reader::Value) -> Vec<Identifier> {
    r.array(value).into_iter().filter_map(|item| r.text(item)).collect()
}
