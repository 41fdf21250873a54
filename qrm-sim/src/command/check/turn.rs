//! Facts of a slow full turn: strokes, dead points, locks, torque at rest.

use std::f64::consts::TAU;

use qrm_codegen::scene::OutputKind;
use qrm_mechanism::QuantityDescription;

use super::super::setup::Setup;
use super::super::{Failure, words};
use super::limits::limits;
use super::{shown, unit_of_force};
use crate::extremes::{Extremes, Tracker};
use crate::turn::{NoTurn, Range, Turn};

/// The facts in words.
pub(super) fn facts(setup: &Setup) -> Result<String, Failure> {
    let coordinates = setup.description.coordinates;
    let turn = match setup.scene.turn(&setup.replace()) {
        Ok(turn) => turn,
        Err(NoTurn::Freedoms(n)) => {
            return Ok(format!("\n  turn       not looked at: the mechanism has {n} freedoms, not one\n"));
        }
        Err(NoTurn::NotAnAngle(i)) => {
            let name = coordinates[i].name;
            return Ok(format!("\n  turn       not looked at: `{name}`, which [initial] gives, is no angle\n"));
        }
        Err(NoTurn::NotAssembled(reason)) => {
            let report = words::not_assembled_report(&reason, &setup.description, &setup.text, &setup.path);
            return Err(Failure::Use(report));
        }
    };
    let driven = coordinates[turn.coordinate];
    let mut text = format!("\n  turn       {}\n", turning(setup, &turn, &driven));
    if turn.range.is_none() {
        text += &grashof(setup);
    }
    text += &strokes(setup, &turn, &driven);
    text += &at_rest(&turn, &driven);
    Ok(text)
}

fn turning(setup: &Setup, turn: &Turn, driven: &QuantityDescription) -> String {
    let name = driven.name;
    let Some(Range { low, high }) = &turn.range else {
        let back = if turn.returns { "" } else { ", after which other coordinates are not back" };
        let (angle, margin) = turn.nearest;
        let angle = shown(angle.rem_euclid(TAU), "rad");
        return format!("{name} turns all the way{back}; nearest to locking at {angle}, margin {margin:.4} of 1");
    };
    let end = |(angle, constraint): &(f64, Option<usize>)| {
        let why = constraint.map_or_else(
            || "where another branch begins".to_owned(),
            |i| format!("where constraint `{}` ends its way", setup.description.constraints[i].name),
        );
        format!("{}, {why}", shown(*angle, "rad"))
    };
    format!("{name} locks: it can move from {} to {}", end(low), end(high))
}

/// For which lengths the turn is possible.
fn grashof(setup: &Setup) -> String {
    let mut text = String::new();
    for limit in limits(setup) {
        let (name, unit) = (limit.name, limit.unit);
        let range = match (limit.low, limit.high) {
            (None, None) => continue,
            (Some(low), None) => format!("{name} >= {low:.8} {unit}"),
            (None, Some(high)) => format!("{name} <= {high:.8} {unit}"),
            (Some(low), Some(high)) => format!("{low:.8} <= {name} <= {high:.8} {unit}"),
        };
        let lead = if text.is_empty() { "  needs" } else { "" };
        text += &format!("{lead:12} {range} (is {})\n", limit.value);
    }
    text
}

/// Extremes of a quantity over the turn, at the values of the driven coordinate.
fn extremes(turn: &Turn, value: impl Fn(&crate::turn::Sample) -> f64) -> Option<Extremes> {
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

fn strokes(setup: &Setup, turn: &Turn, driven: &QuantityDescription) -> String {
    let mut text = String::new();
    for (i, output) in setup.text.outputs.iter().enumerate() {
        let (OutputKind::Value(_), Some(e)) = (&output.kind, extremes(turn, |sample| sample.outputs[i])) else {
            continue;
        };
        let ((low, at_low), (high, at_high)) = (e.minimum, e.maximum);
        let (name, unit) = (&output.name, &output.unit);
        let angle = |angle: f64| shown(angle.rem_euclid(TAU), "rad");
        text += &format!(
            "\n  {name:10} from {low:.7} {unit} at {} = {} to {high:.7} {unit} at {}: stroke {:.7} {unit}\n",
            driven.name,
            angle(at_low),
            angle(at_high),
            high - low
        );
        if turn.range.is_none() && high > low {
            let way = (turn.samples[1].angle - turn.samples[0].angle).signum();
            let down = ((at_low - at_high) * way).rem_euclid(TAU);
            let (slow, fast) = if down > TAU - down { (down, TAU - down) } else { (TAU - down, down) };
            let direction = if down > TAU - down { "downward" } else { "upward" };
            text += &format!(
                "  {:10} slow stroke ({direction}) {}, fast {} of {}: time ratio {:.6} at uniform speed\n",
                "",
                angle(slow),
                angle(fast),
                driven.name,
                slow / fast
            );
        }
    }
    text
}

fn at_rest(turn: &Turn, driven: &QuantityDescription) -> String {
    let Some(e) = extremes(turn, |sample| sample.balance) else { return String::new() };
    let unit = unit_of_force(driven.unit);
    let at = |(value, angle): (f64, f64)| format!("{value:.7} {unit} at {}", shown(angle.rem_euclid(TAU), "rad"));
    format!("\n  at rest    balancing torque on {} from {} to {}\n", driven.name, at(e.minimum), at(e.maximum))
}
