//! Facts of a slow full turn: strokes, dead points, locks, torque at rest.

use std::f64::consts::TAU;

use qrm_codegen::scene::OutputKind;
use qrm_mechanism::QuantityDescription;

use super::super::setup::Setup;
use super::super::{Failure, words};
use super::limits::limits;
use super::{Fact, shown, unit_of_force};
use crate::extremes::{Extremes, Tracker};
use crate::turn::{NoTurn, Range, Sample, Turn};

/// The facts in words.
pub(super) fn facts(setup: &Setup) -> Result<Vec<Fact>, Failure> {
    let coordinates = setup.description.coordinates;
    let not_looked_at = |why: String| Ok(vec![Fact::new("turn", [format!("not looked at: {why}")])]);
    let turn = match setup.scene.turn(&setup.replace()) {
        Ok(turn) => turn,
        Err(NoTurn::Freedoms(n)) => return not_looked_at(format!("the mechanism has {n} freedoms, not one")),
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
    let mut facts = vec![Fact::new("turn", [turning(setup, &turn, &driven)])];
    if turn.range.is_none() && !setup.description.constraints.is_empty() {
        facts.extend(needs(setup));
    }
    facts.extend(strokes(setup, &turn, &driven));
    facts.push(at_rest(&turn, &driven));
    Ok(facts)
}

fn turning(setup: &Setup, turn: &Turn, driven: &QuantityDescription) -> String {
    let name = driven.name;
    let Some(Range { low, high }) = &turn.range else {
        let back = if turn.returns { "" } else { ", after which other coordinates are not back" };
        let (angle, margin) = turn.nearest;
        if setup.description.constraints.is_empty() {
            return format!("{name} turns freely");
        }
        let angle = whole(angle);
        return format!("{name} turns all the way{back}; nearest to locking at {angle}, with a margin of {margin:.4}");
    };
    let end = |(angle, constraint): &(f64, Option<usize>)| {
        let why = constraint.map_or_else(
            || "where another branch begins".to_owned(),
            |i| format!("where constraint `{}` holds it", setup.description.constraints[i].name),
        );
        format!("{}, {why}", shown(*angle, "rad"))
    };
    format!("{name} locks: it can move from {}, to {}", end(low), end(high))
}

/// An angle within one turn.
fn whole(angle: f64) -> String {
    shown(angle.rem_euclid(TAU), "rad")
}

/// For which lengths the turn is possible, like Grashof's condition for four bars.
fn needs(setup: &Setup) -> Option<Fact> {
    let line = |limit: &super::limits::Limits| {
        let (name, unit) = (limit.name, limit.unit);
        let range = match (limit.low, limit.high) {
            (None, None) => return None,
            (Some(low), None) => format!("{name} >= {low:.8} {unit}"),
            (None, Some(high)) => format!("{name} <= {high:.8} {unit}"),
            (Some(low), Some(high)) => format!("{low:.8} <= {name} <= {high:.8} {unit}"),
        };
        Some(format!("{}, and is {}", range.trim_end(), limit.value))
    };
    let lines: Vec<String> = limits(setup).iter().filter_map(line).collect();
    (!lines.is_empty()).then(|| Fact::new("needs", lines))
}

/// Extremes of a quantity over the turn, at the values of the driven coordinate.
fn extremes(turn: &Turn, value: impl Fn(&Sample) -> f64) -> Option<Extremes> {
    let mut tracker = Tracker::default();
    turn.samples.iter().for_each(|sample| tracker.row(sample.angle, value(sample)));
    if turn.returns
        && let [first, .., last] = turn.samples.as_slice()
    {
        // Beyond the end the turn begins anew, so that an extreme at the start lies between others as well.
        let offset = last.angle - first.angle;
        turn.samples.iter().skip(1).take(4).for_each(|sample| tracker.row(sample.angle + offset, value(sample)));
    }
    tracker.finish()
}

fn strokes(setup: &Setup, turn: &Turn, driven: &QuantityDescription) -> Vec<Fact> {
    let mut facts = Vec::new();
    for (i, output) in setup.text.outputs.iter().enumerate() {
        let (OutputKind::Value(_), Some(e)) = (&output.kind, extremes(turn, |sample| sample.outputs[i])) else {
            continue;
        };
        let ((low, at_low), (high, at_high)) = (e.minimum, e.maximum);
        let value = |value: f64| format!("{value:.7} {}", output.unit).trim_end().to_owned();
        let (stroke, name) = (value(high - low), driven.name);
        let mut lines = vec![
            format!("smallest  {} at {name} = {}", value(low), whole(at_low)),
            format!("largest   {} at {name} = {}", value(high), whole(at_high)),
            format!("stroke    {stroke}"),
        ];
        if turn.range.is_none() && high > low {
            let way = (turn.samples[1].angle - turn.samples[0].angle).signum();
            let down = ((at_low - at_high) * way).rem_euclid(TAU);
            let (slow, fast) = if down > TAU - down { (down, TAU - down) } else { (TAU - down, down) };
            let way = if down > TAU - down { "downward" } else { "upward" };
            lines.push(format!(
                "time      slow stroke {way} during {} of {name}, fast one back during {}: ratio {:.6} at uniform speed",
                whole(slow),
                whole(fast),
                slow / fast
            ));
        }
        facts.push(Fact::new(&output.name, lines));
    }
    facts
}

fn at_rest(turn: &Turn, driven: &QuantityDescription) -> Fact {
    let what = format!("torque on {} that balances the loads", driven.name);
    let found = extremes(turn, |sample| sample.balance).filter(|_| turn.range.is_none());
    let Some(e) = found else { return Fact::new("at rest", [what + ": grows beyond all bounds where it locks"]) };
    let unit = unit_of_force(driven.unit);
    let line = |which: &str, (value, angle): (f64, f64)| {
        format!("{which}  {value:.7} {unit} at {} = {}", driven.name, whole(angle))
    };
    Fact::new("at rest", [what + ":", line("smallest", e.minimum), line("largest ", e.maximum)])
}
