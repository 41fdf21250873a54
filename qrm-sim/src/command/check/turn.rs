//! Facts of a slow full turn: strokes, dead points, locks, torque at rest.

use std::f64::consts::TAU;

use qrm_core::QuantityDescription;
use qrm_scene::scene::OutputKind;

use super::super::setup::Setup;
use super::super::{Failure, words};
use super::limits::limits;
use super::{Fact, number, shown, unit_of_force};
use crate::turn::{Course, NoTurn, Range, Turn};

/// The facts in words.
pub(super) fn facts(setup: &Setup) -> Result<Vec<Fact>, Failure> {
    let coordinates = setup.description.coordinates;
    let not_looked_at = |why: String| Ok(vec![Fact::new("turn", [format!("not looked at: {why}")])]);
    let turn = match setup.scene.turn(&setup.replace()) {
        Ok(turn) => turn,
        Err(NoTurn::Freedoms(n)) => return not_looked_at(format!("the mechanism has {n} freedoms, not one")),
        Err(NoTurn::Driven) => return not_looked_at("a constraint depends on time".to_owned()),
        Err(NoTurn::NotAnAngle(i)) => {
            return not_looked_at(format!("`{}`, which [initial] gives, is not in rad", coordinates[i].name));
        }
        Err(NoTurn::Singular) => return not_looked_at("the start is singular".to_owned()),
        Err(NoTurn::NotAssembled(reason)) => {
            let report = words::not_assembled_report(&reason, &setup.description, &setup.text, &setup.path);
            return Err(Failure::Use(report));
        }
    };
    let driven = coordinates[turn.coordinate];
    let mut facts = vec![Fact::new("turn", turning(setup, &turn, &driven))];
    if !setup.description.constraints.is_empty() {
        facts.extend(lengths(setup, turn.range.is_none()));
    }
    for (output, course) in setup.text.outputs.iter().zip(&turn.outputs) {
        if matches!(output.kind, OutputKind::Value(_)) {
            facts.push(stroke(&output.name, &output.unit, course, &turn, &driven));
        }
    }
    facts.push(at_rest(setup, &turn, &driven));
    Ok(facts)
}

fn turning(setup: &Setup, turn: &Turn, driven: &QuantityDescription) -> Vec<String> {
    let name = driven.name;
    let way = match &turn.range {
        None if setup.description.constraints.is_empty() => format!("{name} turns freely"),
        None if turn.returns => format!("{name} turns all the way"),
        None => format!("{name} turns all the way, after which other coordinates are not back"),
        Some(Range { low, high }) => {
            let end = |lock: &Option<(f64, Option<usize>)>| match lock {
                None => "a turn away or farther".to_owned(),
                Some((angle, None)) => format!("{}, where another branch begins", shown(*angle, "rad")),
                Some((angle, Some(i))) => {
                    let name = setup.description.constraints[*i].name;
                    format!("{}, where constraint `{name}` holds it", shown(*angle, "rad"))
                }
            };
            format!("{name} locks: it can move from {}, to {}", end(low), end(high))
        }
    };
    let Course { smallest, largest, .. } = &turn.inertia;
    let at = |(value, angle): (f64, f64)| format!("{} kg m^2 at {}", number(value), place(angle, turn));
    let inertia = match largest.0 - smallest.0 > 1e-9 * largest.0 {
        true => format!("from {} to {}", at(*smallest), at(*largest)),
        false => format!("always {} kg m^2", number(smallest.0)),
    };
    vec![way, format!("inertia that {name} has to move: {inertia}")]
}

/// An angle within one turn, or as it is between locks.
fn place(angle: f64, turn: &Turn) -> String {
    let within = angle.rem_euclid(TAU);
    // Rounding may leave the beginning of a turn at its end.
    let within = if TAU - within < 1e-7 { 0.0 } else { within };
    shown(if turn.range.is_none() { within } else { angle }, "rad")
}

/// For which lengths the turn is or would be possible, like Grashof's condition for four bars.
fn lengths(setup: &Setup, turns: bool) -> Option<Fact> {
    let line = |limit: &super::limits::Limits| {
        let (name, unit) = (limit.name, limit.unit);
        let range = match (limit.low, limit.high) {
            (None, None) => return None,
            (Some(low), None) => format!("{name} >= {} {unit}", number(low)),
            (None, Some(high)) => format!("{name} <= {} {unit}", number(high)),
            (Some(low), Some(high)) if low <= high => format!("{} <= {name} <= {} {unit}", number(low), number(high)),
            (Some(low), Some(high)) => format!("{name} <= {} {unit} or >= {} {unit}", number(high), number(low)),
        };
        Some(format!("{}, and is {}", range.trim_end(), number(limit.value)))
    };
    let lines: Vec<String> = limits(setup, turns).iter().filter_map(line).collect();
    (!lines.is_empty()).then(|| Fact::new(if turns { "needs" } else { "turns if" }, lines))
}

fn stroke(name: &str, unit: &str, course: &Course, turn: &Turn, driven: &QuantityDescription) -> Fact {
    let value = |value: f64| format!("{} {unit}", number(value)).trim_end().to_owned();
    let at = |angle: f64| format!("{} = {}", driven.name, place(angle, turn));
    let (low, high) = (course.smallest, course.largest);
    if !(low.0.is_finite() && high.0.is_finite()) {
        return Fact::new(name, ["has no finite value somewhere on the way".to_owned()]);
    }
    if low.0 == high.0 {
        return Fact::new(name, [format!("always {}", value(low.0))]);
    }
    let mut lines = vec![
        format!("smallest     {} at {}", value(low.0), at(low.1)),
        format!("largest      {} at {}", value(high.0), at(high.1)),
        format!("stroke       {}", value(high.0 - low.0)),
    ];
    if turn.range.is_none() && turn.returns && !course.comes_back() {
        lines.push(format!("after a turn {} more than before", value(course.ends[1] - course.ends[0])));
        return Fact::new(name, lines);
    }
    let dead: Vec<String> = course.vertices.iter().map(|vertex| place(vertex.angle, turn)).collect();
    if !dead.is_empty() {
        lines.push(format!("dead points  at {} = {}", driven.name, dead.join(", ")));
    }
    if let (None, [one, other]) = (&turn.range, &course.vertices[..]) {
        let way = ((other.angle - one.angle) * turn.way).rem_euclid(TAU);
        let rises = other.value > one.value;
        let (slow, fast) = if way > TAU - way { (way, TAU - way) } else { (TAU - way, way) };
        let direction = if (way > TAU - way) == rises { "rising" } else { "falling" };
        lines.push(format!(
            "time         {direction} during {} of {}, back during {}: ratio {:.6} at uniform speed",
            shown(slow, "rad"),
            driven.name,
            shown(fast, "rad"),
            slow / fast
        ));
    }
    Fact::new(name, lines)
}

fn at_rest(setup: &Setup, turn: &Turn, driven: &QuantityDescription) -> Fact {
    let unit = unit_of_force(driven.unit);
    let line = |which: &str, (value, angle): (f64, f64)| {
        format!("{which} {} {unit} at {} = {}", number(value), driven.name, place(angle, turn))
    };
    let mut title = format!("torque on {} that balances the loads{}", driven.name, super::rest::when(setup));
    if turn.range.is_some() {
        title += ", between the locks";
    }
    let Course { smallest, largest, .. } = &turn.balance;
    Fact::new("at rest", [title + ":", line("smallest    ", *smallest), line("largest     ", *largest)])
}
