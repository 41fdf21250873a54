//! What the measurements come to: the cheapest way to an accuracy.

use super::ladder::{Measured, Rung};
use super::reference::Reference;

/// Errors of the coordinates that are asked for.
const GOALS: [f64; 5] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-11];
/// The method that others are set against.
const YARDSTICK: &str = "rk4, mass metric";

/// Each goal, and a sentence about it.
pub(super) fn verdict(rungs: &[Rung], reference: &Reference) -> Vec<(String, String)> {
    GOALS.map(|goal| (format!("{goal:.0e}"), cheapest(rungs, reference, goal))).into()
}

fn cheapest(rungs: &[Rung], reference: &Reference, goal: f64) -> String {
    if goal < reference.uncertainty.position {
        return format!("not to be told: the reference is uncertain by {:.1e}", reference.uncertainty.position);
    }
    let reaches = |rung: &&Rung| rung.result.as_ref().is_ok_and(|m| m.errors.position <= goal);
    let time = |rung: &Rung| rung.result.as_ref().map_or(f64::INFINITY, |m| m.seconds[1]);
    let Some(best) = rungs.iter().filter(reaches).min_by(|a, b| time(a).total_cmp(&time(b))) else {
        return "no method gets there".to_owned();
    };
    let needed = |method: &str| time_needed(rungs, method, goal);
    let text = format!("{} at a {}: {:.3} ms", best.method, best.setting.words(), time(best) * 1e3);
    if best.method == YARDSTICK {
        return text;
    }
    match (needed(best.method), needed(YARDSTICK)) {
        (Some(own), Some(other)) => format!(
            "{text}; between the measured points {:.3} ms against {:.3} ms for {YARDSTICK}: {:.2} of it",
            own * 1e3,
            other * 1e3,
            own / other
        ),
        _ => format!("{text}; {YARDSTICK} does not get there"),
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
