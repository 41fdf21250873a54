//! What the measurements come to: the cheapest way to an accuracy.

use super::super::reference::Reference;
use super::super::words;
use super::ladder::{Climb, Measured, Rung};

/// Errors of the coordinates that are asked for.
const GOALS: [f64; 5] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-11];
/// The method that others are set against.
const YARDSTICK: &str = "rk4, mass metric";

/// An error so many times larger than what the method says of itself is not the method's.
const INCREDIBLE: f64 = 1e3;

/// Each goal, and a sentence about it.
pub(super) fn verdict(climb: &Climb, reference: &Reference) -> Vec<(String, String)> {
    GOALS.map(|goal| (format!("{goal:.0e}"), cheapest(climb, reference, goal))).into()
}

/// Whether fine steps agree with themselves and not with the reference: it may have passed over something short.
pub(super) fn doubt(rungs: &[Rung], reference: &Reference) -> Option<String> {
    let measured = |rung: &&Rung| rung.method == YARDSTICK && rung.result.is_ok();
    let finest = rungs.iter().rfind(measured)?.result.as_ref().ok()?;
    let (error, estimate) = (finest.errors.position, finest.estimate?);
    let is_incredible = error > INCREDIBLE * estimate.max(reference.uncertainty.position);
    is_incredible.then(|| {
        format!(
            "the reference is in doubt: the shortest steps of {YARDSTICK} differ from it by {error:.1e}, but from longer \
             ones by {estimate:.1e} only\n  = help: a load may act for a very short time or way, which long steps pass \
             over, or the motion goes through a singular position"
        )
    })
}

fn cheapest(Climb { rungs, cut }: &Climb, reference: &Reference, goal: f64) -> String {
    if goal < reference.uncertainty.position {
        return format!("not to be told: the reference is uncertain by {:.1e}", reference.uncertainty.position);
    }
    let needed = |method: &str| time_needed(rungs, method, goal);
    let time = |rung: &Rung| rung.result.as_ref().map_or(f64::INFINITY, |m| m.seconds[1]);
    let reaches = |rung: &&Rung| rung.result.as_ref().is_ok_and(|m| m.errors.position <= goal);
    let order = |a: &&Rung, b: &&Rung| {
        // Between the points of a method lies more than they show; of one method, its own fastest point.
        let of = |rung: &Rung| needed(rung.method).unwrap_or(f64::INFINITY);
        of(a).total_cmp(&of(b)).then(time(a).total_cmp(&time(b)))
    };
    let missed = if cut.is_some() { "was not measured so far" } else { "does not get there" };
    let Some(best) = rungs.iter().filter(reaches).min_by(order) else {
        return match cut {
            Some(_) => "no method got there before the measurements ended".to_owned(),
            None => "no method gets there".to_owned(),
        };
    };
    let text = format!("{} at a {}: {}", best.method, best.setting.words(), words::milliseconds(time(best)));
    if best.method == YARDSTICK {
        return text;
    }
    match (needed(best.method), needed(YARDSTICK)) {
        (Some(own), Some(other)) => format!(
            "{text}; between the measured points {} against {} for {YARDSTICK}: {:.2} of it",
            words::milliseconds(own),
            words::milliseconds(other),
            own / other
        ),
        _ => format!("{text}; {YARDSTICK} {missed}"),
    }
}

/// The time in which a method just reaches a goal, on straight lines between its points in the picture.
fn time_needed(rungs: &[Rung], method: &str, goal: f64) -> Option<f64> {
    let points: Vec<&Measured> =
        rungs.iter().filter(|rung| rung.method == method).filter_map(|rung| rung.result.as_ref().ok()).collect();
    let first = points.iter().position(|m| m.errors.position <= goal)?;
    let reached = points[first];
    let Some(before) = first.checked_sub(1).map(|i| points[i]) else { return Some(reached.seconds[1]) };
    let (e0, e1) = (before.errors.position.ln(), reached.errors.position.max(f64::MIN_POSITIVE).ln());
    let (t0, t1) = (before.seconds[1].ln(), reached.seconds[1].ln());
    Some((t0 + (t1 - t0) * (goal.ln() - e0) / (e1 - e0)).exp())
}
