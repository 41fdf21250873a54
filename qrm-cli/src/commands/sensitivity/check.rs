//! Derivatives against difference quotients, and against derivatives of a motion at twice the step.

use std::collections::BTreeSet;

use qrm_sim::analysis::SensitivityRequest;

use super::quantities::{Quantity, quantities};
use crate::error::Error;
use crate::progress::{MotionProgress, interrupted};
use crate::setup::Setup;

/// Parameters are changed by this part of their value, or by this where they are zero.
const CHANGE: f64 = 1e-4;
/// The difference quotient of order 4: places and weights.
const QUOTIENT: [(f64, f64); 4] = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
/// Derivatives below this part of a size that matters, over the parameter, count as that.
const SMALL: f64 = 1e-2;
/// From this difference on, relative to the derivative, something is wrong.
const WRONG: f64 = 1e-3;

/// The distance of the derivatives by a parameter from others.
pub(super) struct Check {
    parameter: &'static str,
    /// From difference quotients, relative to the derivative, and for which quantity; `None` if the motion does not
    /// come to its end
    /// where the parameter is a little different.
    differences: Option<(f64, String)>,
    /// From those of a motion at twice the step, likewise.
    coarse: Option<(f64, String)>,
    /// Times of extremes that jump to another one when the parameter changes a little.
    jumps: Vec<String>,
}

/// The number of motions that check derivatives by so many parameters.
pub(super) fn motions(parameters: usize) -> usize {
    SensitivityRequest::motions(parameters) + QUOTIENT.len() * parameters
}

/// Takes every derivative in two other ways, until it is interrupted.
pub(super) fn check(
    (setup, progress): (&Setup, &MotionProgress),
    by: &[&'static str],
    exact: &[Quantity],
    of: &[String],
) -> Vec<Check> {
    // Steps twice as long may lead nowhere, where these do.
    let coarse = super::derive((setup, progress), by, &setup.replace(), 2.0 * setup.step()).ok();
    let coarse = coarse.as_ref().map(|coarse| quantities(setup, coarse, of));
    let values = setup.model.parameter_values(&setup.replace());
    let mut checks = Vec::new();
    for (place, parameter) in by.iter().enumerate() {
        let at = setup.description.parameters.iter().position(|p| p.name == *parameter).map_or(0.0, |i| values[i]);
        let change = CHANGE * if at == 0.0 { 1.0 } else { at.abs() };
        let mut quotients = vec![0.0; exact.len()];
        let mut has_jumped = vec![false; exact.len()];
        for (steps, weight) in QUOTIENT {
            let own = setup.replace();
            let replace = |name: &str| if name == *parameter { Some(at + steps * change) } else { own(name) };
            let Ok(moved) = super::derive((setup, progress), &[], &replace, setup.step()) else {
                quotients.clear();
                break;
            };
            for (i, row) in quantities(setup, &moved, of).iter().enumerate() {
                quotients[i] += weight * row.value.value / (12.0 * change);
                let expected = exact[i].value.value + exact[i].value.by[place] * steps * change;
                has_jumped[i] |= row.what.starts_with("time") && (row.value.value - expected).abs() > setup.step();
            }
        }
        if interrupted() {
            break;
        }
        let scale = if at == 0.0 { 1.0 } else { at.abs() };
        let jumps_at = |i: usize| {
            let value = |row: &Quantity| row.value.value;
            let is_time = exact[i].what.starts_with("time");
            let is_far = |coarse: &Vec<Quantity>| (value(&exact[i]) - value(&coarse[i])).abs() > 2.0 * setup.step();
            has_jumped[i] || is_time && coarse.as_ref().is_some_and(is_far)
        };
        // An extreme that another one replaces has a derivative for each.
        let jumps_at = |i: usize| jumps_at(i) || ["minimum", "maximum"].contains(&exact[i].what) && jumps_at(i + 1);
        let worst = |others: &dyn Fn(usize) -> f64| {
            let distances = exact.iter().enumerate().filter(|(i, _)| !jumps_at(*i)).map(|(i, row)| {
                let (derivative, other) = (row.value.by[place], others(i));
                // A derivative that is small against what it is taken of has fewer digits.
                let size = derivative.abs().max(SMALL * row.scale / scale);
                ((derivative - other).abs() / size, format!("{} {}", row.what, row.name))
            });
            distances.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
        };
        let jumping = exact.iter().enumerate().filter(|(i, _)| jumps_at(*i));
        checks.push(Check {
            parameter,
            differences: (!quotients.is_empty()).then(|| worst(&|i| quotients[i])),
            coarse: coarse.as_ref().map(|coarse| worst(&|i| coarse[i].value.by[place])),
            jumps: jumping.map(|(_, row)| format!("{} {}", row.what, row.name)).collect(),
        });
    }
    checks
}

/// The checks as text.
pub(super) fn text(checks: &[Check], step: f64) -> String {
    if checks.is_empty() {
        return String::new();
    }
    let worst = |which: fn(&Check) -> &Option<(f64, String)>| {
        let known = checks.iter().filter_map(|check| Some((check.parameter, which(check).as_ref()?)));
        let line = |(parameter, (distance, quantity)): (&str, &(f64, String))| {
            format!("{distance:.1e} of the derivative ({quantity} by {parameter})")
        };
        known.max_by(|a, b| a.1.0.total_cmp(&b.1.0)).map_or("not possible: that motion has none".to_owned(), line)
    };
    let mut text = format!(
        "\n  against difference quotients  {}\n  {:28}  {}\n",
        worst(|check| &check.differences),
        format!("against steps of {} s", 2.0 * step),
        worst(|check| &check.coarse)
    );
    let jumps: BTreeSet<&str> = checks.iter().flat_map(|check| &check.jumps).map(String::as_str).collect();
    if !jumps.is_empty() {
        let jumps: Vec<&str> = jumps.into_iter().collect();
        text += &format!(
            "  not checked                   {}: another extreme of about the same size may take its place\n",
            jumps.join(", ")
        );
    }
    text
}

/// Whether the derivatives can be relied on.
pub(super) fn verdict(checks: &[Check]) -> Result<(), Error> {
    let wrong = |found: &Option<(f64, String)>| found.clone().filter(|(distance, _)| !(*distance < WRONG));
    let found = checks.iter().find_map(|check| match (wrong(&check.coarse), wrong(&check.differences)) {
        (Some((_, quantity)), _) => Some((check.parameter, quantity, true)),
        (None, Some((_, quantity))) => Some((check.parameter, quantity, false)),
        (None, None) => None,
    });
    let Some((parameter, quantity, is_coarse)) = found else { return Ok(()) };
    let (how, help) = if is_coarse {
        (
            "steps twice as long",
            "try a shorter --step; corners in loads, and steps so short that rounding errors add up, do the same",
        )
    } else {
        (
            "difference quotients",
            "a corner in a load, two extremes of about the same size or a motion that soon loses its memory have no \
             useful derivative",
        )
    };
    let text = format!("the derivative of {quantity} by {parameter} cannot be relied on: {how} contradict it");
    Err(Error::run(text).help(help))
}
