//! A quasi-static full turn, or motion along a length: strokes, dead points, limit positions, torque at rest.

use std::f64::consts::TAU;

use qrm_core::QuantityDescription;
use qrm_scene::scene::OutputKind;
use qrm_sim::analysis::{NoRevolution, Range, Revolution, Series, revolution};

use super::full_turn::{ParameterRange, parameter_ranges};
use super::motors::Motors;
use super::{Topic, equilibrium, released};
use crate::error::Error;
use crate::format::{number, quantity, unit_of_force};
use crate::setup::Setup;

/// The lines about the revolution of the driven coordinate, or of each drive.
pub(super) fn report_lines(setup: &Setup) -> Result<Vec<Topic>, Error> {
    let drives = setup.scene.drives();
    if drives.is_empty() {
        return input_topics(setup, None);
    }
    let topics: Vec<Vec<Topic>> =
        drives.into_iter().map(|drive| input_topics(setup, Some(drive))).collect::<Result<_, _>>()?;
    Ok(topics.into_iter().flatten().collect())
}

/// The lines about the coordinate that the scene gives, or that a drive prescribes.
fn input_topics(setup: &Setup, drive: Option<usize>) -> Result<Vec<Topic>, Error> {
    let not_looked_at = |why: String| Ok(vec![Topic::new("turn", [format!("not looked at: {why}")])]);
    let mechanism = released(setup, drive.as_slice())?;
    let coordinates = mechanism.description().coordinates;
    let motors = Motors::new(setup);
    let turn = match revolution(&*mechanism, &|q, dq| motors.work(q, dq)) {
        Ok(turn) => turn,
        Err(NoRevolution::DegreesOfFreedom(n)) => {
            let without = if drive.is_some() { "without the drive " } else { "" };
            let freedoms = if n == 1 { "degree" } else { "degrees" };
            return not_looked_at(format!("{without}the mechanism has {n} {freedoms} of freedom, not one"));
        }
        Err(NoRevolution::NothingGiven) => {
            return not_looked_at("no coordinate is given: move one from `solve` to `given` in [initial]".to_owned());
        }
        Err(NoRevolution::Driven) => return not_looked_at("a constraint depends on time".to_owned()),
        Err(NoRevolution::Singular) => return not_looked_at("the start is a dead point or a change point".to_owned()),
        Err(NoRevolution::NotAssembled(reason)) => {
            return Err(setup.not_assembled(&reason));
        }
    };
    let driven = coordinates[turn.coordinate];
    let is_angle = driven.unit == "rad";
    let mut topics = vec![Topic::new(if is_angle { "turn" } else { "way" }, turning(setup, &turn, &driven))];
    if is_angle && !setup.description.constraints.is_empty() {
        topics.extend(lengths(setup, drive, turn.range.is_none()));
    }
    for (output, series) in setup.scene.outputs.iter().zip(&turn.outputs) {
        if matches!(output.kind, OutputKind::Value(_)) && !output.kind.needs_motion(&setup.scene) {
            topics.push(stroke(&output.name, &output.unit, series, &turn, &driven));
        }
    }
    topics.push(at_rest(setup, &turn, &driven, &motors.left_out()));
    Ok(topics)
}

fn turning(setup: &Setup, turn: &Revolution, driven: &QuantityDescription) -> Vec<String> {
    let name = driven.name;
    let unit = driven.unit;
    let way = match &turn.range {
        None if setup.description.constraints.is_empty() => format!("{name} turns freely"),
        None if turn.returns => format!("{name} turns all the way"),
        None => format!("{name} turns all the way, after which other coordinates are not back"),
        Some(Range { low, high }) => {
            let end = |limit: &Option<(f64, Option<usize>)>| match limit {
                None if unit == "rad" => "a turn away or farther".to_owned(),
                None => "farther than its parts are long".to_owned(),
                Some((value, None)) => format!("{}, where another branch begins", quantity(*value, unit)),
                Some((value, Some(i))) if setup.scene.constraints[*i].is_drive => {
                    format!("{}, its dead point", quantity(*value, unit))
                }
                Some((value, Some(i))) => {
                    let name = setup.description.constraints[*i].name;
                    format!("{}, where constraint `{name}` holds it", quantity(*value, unit))
                }
            };
            match (low, high) {
                (None, None) => format!("{name} moves freely"),
                _ => format!("{name} locks: it can move from {}, to {}", end(low), end(high)),
            }
        }
    };
    let mut lines = vec![way];
    if setup.description.constraints.iter().any(|constraint| constraint.name == name) {
        lines.push(format!("{name} is what the drive prescribes, counted from the start"));
    }
    let angles: Vec<String> = turn.change_points.iter().map(|value| place(*value, turn, unit)).collect();
    if !angles.is_empty() {
        lines.push(format!("change points, where the mechanism may go over to another branch: {}", angles.join(", ")));
    }
    let Series { smallest, largest, .. } = &turn.inertia;
    let unit_of_inertia = if unit == "rad" { "kg m^2" } else { "kg" };
    let at = |(value, angle): (f64, f64)| match value.is_finite() {
        true => format!("{} {unit_of_inertia} at {}", number(value), place(angle, turn, unit)),
        false => format!("beyond all bounds at {}", place(angle, turn, unit)),
    };
    let inertia = match largest.0.is_infinite() || largest.0 - smallest.0 > 1e-9 * largest.0 {
        true => format!("from {} to {}", at(*smallest), at(*largest)),
        false => format!("always {} {unit_of_inertia}", number(smallest.0)),
    };
    let kind = if unit == "rad" { "inertia" } else { "mass" };
    lines.push(format!("effective {kind} at {name}: {inertia}"));
    lines
}

/// A value of the driven coordinate: an angle modulo one turn, or the plain value between locks.
fn place(value: f64, turn: &Revolution, unit: &str) -> String {
    let within = value.rem_euclid(TAU);
    // Rounding may move the beginning of a turn to its end.
    let within = if TAU - within < 1e-7 { 0.0 } else { within };
    quantity(if turn.range.is_none() && turn.returns { within } else { value }, unit)
}

/// The ranges of lengths for which a turn is possible, like Grashof's condition for four-bar linkages.
fn lengths(setup: &Setup, drive: Option<usize>, turns: bool) -> Option<Topic> {
    let line = |limit: &ParameterRange| {
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
    let lines: Vec<String> = parameter_ranges(setup, drive, turns).iter().filter_map(line).collect();
    (!lines.is_empty()).then(|| Topic::new(if turns { "needs" } else { "turns if" }, lines))
}

fn stroke(name: &str, unit: &str, series: &Series, turn: &Revolution, driven: &QuantityDescription) -> Topic {
    let value = |value: f64| format!("{} {unit}", number(value)).trim_end().to_owned();
    let at = |angle: f64| format!("{} = {}", driven.name, place(angle, turn, driven.unit));
    let (low, high) = (series.smallest, series.largest);
    if !(low.0.is_finite() && high.0.is_finite()) {
        return Topic::new(name, ["has no finite value somewhere on the way".to_owned()]);
    }
    if low.0 == high.0 {
        return Topic::new(name, [format!("always {}", value(low.0))]);
    }
    let mut lines = vec![
        format!("smallest     {} at {}", value(low.0), at(low.1)),
        format!("largest      {} at {}", value(high.0), at(high.1)),
        format!("stroke       {}", value(high.0 - low.0)),
    ];
    if turn.range.is_none() && turn.returns && !series.is_periodic() {
        lines.push(format!("after a turn {} more than before", value(series.ends[1] - series.ends[0])));
        return Topic::new(name, lines);
    }
    let dead: Vec<String> = series.vertices.iter().map(|vertex| place(vertex.angle, turn, driven.unit)).collect();
    if !dead.is_empty() {
        lines.push(format!("dead points  at {} = {}", driven.name, dead.join(", ")));
    }
    if let (None, [one, other]) = (&turn.range, &series.vertices[..]) {
        let way = ((other.angle - one.angle) * turn.direction).rem_euclid(TAU);
        let rises = other.value > one.value;
        let (slow, fast) = if way > TAU - way { (way, TAU - way) } else { (TAU - way, way) };
        let direction = if (way > TAU - way) == rises { "rising" } else { "falling" };
        lines.push(format!(
            "time         {direction} during {} of {}, back during {}: ratio {:.6} at uniform speed",
            quantity(slow, "rad"),
            driven.name,
            quantity(fast, "rad"),
            slow / fast
        ));
    }
    Topic::new(name, lines)
}

fn at_rest(setup: &Setup, turn: &Revolution, driven: &QuantityDescription, left_out: &str) -> Topic {
    let unit = unit_of_force(driven.unit);
    let line = |which: &str, (value, angle): (f64, f64)| {
        let at = format!("{} = {}", driven.name, place(angle, turn, driven.unit));
        match value.is_finite() {
            true => format!("{which} {} {unit} at {at}", number(value)),
            false => format!("{which} without bound towards {at}"),
        }
    };
    let force = if driven.unit == "rad" { "torque" } else { "force" };
    let mut title = format!("{force} on {} that balances the loads{left_out}{}", driven.name, equilibrium::when(setup));
    if turn.range.is_some_and(|range| range.low.is_some() || range.high.is_some()) {
        title += ", between the limit positions";
    } else if !turn.returns {
        title += ", in the first turn";
    }
    let Series { smallest, largest, .. } = &turn.balance;
    if smallest.0 == largest.0 {
        return Topic::new("at rest", [format!("{title}: always {} {unit}", number(smallest.0))]);
    }
    Topic::new("at rest", [title + ":", line("smallest    ", *smallest), line("largest     ", *largest)])
}
