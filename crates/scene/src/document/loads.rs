//! Entries of `[loads]`.

use super::force_elements::{gas_spring, motor};
use super::reader::{self, Reader};
use super::table::Table;
use super::{Identifier, Target};
use crate::diagnostic::Diagnostic;
use crate::linkage::terms::add;
use crate::parser::Formula;
use crate::unit::Unit;

/// An entry of `[loads]`.
#[derive(Debug)]
pub enum LoadSyntax {
    /// A force on a point, or on the centre of mass of a body.
    Force {
        /// The components of the force.
        force: [Formula; 2],
        /// The link in whose frame the components are; if absent, they are in that of the ground.
        frame: Option<Identifier>,
        /// The point.
        target: Target,
    },
    /// A torque on a body.
    Torque {
        /// The value of the torque, counter-clockwise.
        torque: Formula,
        /// The body.
        body: Identifier,
    },
    /// A field of acceleration on every mass.
    Gravity([Formula; 2]),
    /// Springs, dampers and other loads along a length or an angle.
    Spring(Box<SpringSyntax>),
}

/// A load that acts along a length or an angle.
#[derive(Debug)]
pub struct SpringSyntax {
    /// The length or angle.
    pub along: Along,
    /// Stiffness.
    pub stiffness: Option<Formula>,
    /// The length or angle at which the spring is relaxed.
    pub rest: Option<Formula>,
    /// Damping coefficient.
    pub damping: Option<Formula>,
    /// A potential that depends on the length alone.
    pub potential: Option<Formula>,
    /// A force or torque that is positive if it increases the length or angle.
    pub force: Option<Formula>,
    /// The friction along the length or angle.
    pub friction: Option<FrictionSyntax>,
}

/// A friction force, or a coefficient of friction if a normal force is named.
#[derive(Debug)]
pub struct FrictionSyntax {
    /// The size of the friction force, or the coefficient of friction if a normal force is named.
    pub size: Formula,
    /// The speed at which friction reaches three quarters of its full size.
    pub slip: Formula,
    /// The output that is the normal force.
    pub normal: Option<Identifier>,
}

/// The length or angle that springs and dampers act along.
#[derive(Debug)]
pub enum Along {
    /// A length or an angle.
    Formula(Formula),
    /// The distance of two points.
    Between(Identifier, Identifier),
}

pub(super) fn load(r: &mut Reader, identifier: &Identifier, value: reader::Value) -> Option<LoadSyntax> {
    let table = r.table(&format!("load `{}`", identifier.name), value)?;
    table.string(r, "doc");
    let help = "what acts along a length has `along`, what acts between two points `between`, with `spring`, \
                `damper` and others";
    let kind = match table.is_there("along") || table.is_there("between") {
        true => table.one_of(r, &["along", "between"], help)?,
        false => table.one_of(r, &["force", "torque", "gravity", "along", "between"], help)?,
    };
    let load = match kind {
        "force" => {
            let force = table.required(r, "force").map(|v| r.pair(v, "N"))?;
            let target = table.target(r);
            let frame = table.optional("frame").and_then(|v| r.text(v));
            target.map(|target| LoadSyntax::Force { force, frame, target })
        }
        "torque" => {
            let torque = table.required(r, "torque").map(|v| r.quantity(v, "N m"))?;
            let body = table.required(r, "on").and_then(|v| r.text(v));
            body.map(|body| LoadSyntax::Torque { torque, body })
        }
        "gravity" => table.required(r, "gravity").map(|v| LoadSyntax::Gravity(r.pair(v, "m/s^2"))),
        _ => {
            let spring = spring(r, identifier, &table, kind);
            table.finish(r);
            return spring;
        }
    };
    table.finish(r);
    load
}

/// Reads a load that acts along a length, an angle or the distance of two points.
fn spring(r: &mut Reader, identifier: &Identifier, table: &Table, kind: &str) -> Option<LoadSyntax> {
    let asked = table.required(r, kind)?;
    // Of a formula that is not known to be a length or an angle, neither are the units of the other keys.
    let mut unit = Unit::parse("m");
    let along = if kind == "along" {
        let (formula, dimension) = r.with_dimension(asked, None);
        unit = dimension.unit;
        Some(Along::Formula(formula))
    } else {
        let points: Vec<Identifier> = r.array(asked).into_iter().filter_map(|item| r.text(item)).collect();
        match <[Identifier; 2]>::try_from(points) {
            Ok([from, to]) => Some(Along::Between(from, to)),
            Err(_) => {
                let error = Diagnostic::error("something acts between two points", asked.span(), "not two names");
                r.findings.push(error.help("name both: `between = [\"P\", \"Q\"]`"));
                None
            }
        }
    };
    // Angles are pure numbers: a torque is an energy.
    let unit = unit.map(|unit| if unit.is_number() { Unit::one() } else { unit });
    let names = [("s", 1, "-"), ("s_dot", 1, "1/s")];
    for (name, power, time) in names {
        let own = unit.as_ref().zip(Unit::parse(time)).map(|(unit, time)| time.times(unit, power));
        r.declarations.declare_unit(name, own);
    }
    let normal = table.optional("normal").and_then(|v| r.text(v));
    let mut quantity = |key: &str, energy: &str, power: i32| {
        let unit = Unit::parse(energy).zip(unit.as_ref()).map(|(energy, unit)| energy.times(unit, power));
        let (formula, dimension) = r.with_dimension(table.optional(key)?, None);
        // The unit of a law is not known where that of its length is not.
        if unit.is_some() || !dimension.is_certain() {
            r.check_dimension(&formula, &dimension, unit.as_ref());
        }
        Some(formula)
    };
    let (spring, rest, damping) =
        (quantity("spring", "J", -2), quantity("rest", "-", 1), quantity("damper", "J s", -2));
    let (potential, force) = (quantity("potential", "J", 0), quantity("force", "J", -1));
    let friction = if normal.is_some() { quantity("friction", "-", 0) } else { quantity("friction", "J", -1) };
    let slip = quantity("slip", "1/s", 1);
    let gas_spring = gas_spring(r, table);
    let has_two_springs = spring.is_some() && gas_spring.is_some();
    let [stiffness, rest] = gas_spring.map_or([spring, rest], |own| own.map(Some));
    let force = [force, motor(r, table, unit.as_ref())].into_iter().flatten().reduce(add);
    names.iter().for_each(|(name, ..)| r.declarations.remove(name));
    let sizes = [&stiffness, &damping, &potential, &force, &friction];
    let mut wrong = |title: String, label: &str, help: &str| {
        r.findings.push(Diagnostic::error(title, identifier.span.clone(), label).help(help));
    };
    let name = &identifier.name;
    if sizes.iter().all(|size| size.is_none()) {
        let help = "add one or more of `spring`, `gas_spring`, `damper`, `potential`, `force`, `motor` and `friction`";
        wrong(format!("load `{name}` has no size"), "does nothing", help);
    }
    if has_two_springs {
        let help = "write a load for each of them";
        wrong(format!("load `{name}` has `spring` and `gas_spring`"), "two springs", help);
    }
    if friction.is_some() != slip.is_some() {
        let help = "friction is `-friction*tanh(s_dot/slip)`: give both, `slip` well below the speeds that matter";
        wrong(format!("load `{name}` has one of `friction` and `slip`"), "the other is missing", help);
    }
    if normal.is_some() && friction.is_none() {
        let help = "the normal force is that of a friction: add `friction`, the coefficient, and `slip`";
        wrong(format!("load `{name}` has `normal` and no `friction`"), "nothing rubs", help);
    }
    let friction = friction.zip(slip).map(|(size, slip)| FrictionSyntax { size, slip, normal });
    let spring = |along| SpringSyntax { along, stiffness, rest, damping, potential, force, friction };
    along.map(|along| LoadSyntax::Spring(Box::new(spring(along))))
}
