//! Comparison of derivatives with difference quotients, and their estimated errors.

use std::collections::BTreeSet;

use qrm_sim::analysis::{DerivativeErrors, Derivatives, SensitivityRequest};
use qrm_sim::integrate::MethodSettings;

use super::quantities::{Quantity, quantities};
use crate::error::Error;
use crate::progress::{Progress, interrupted};
use crate::setup::Setup;

/// The relative change of a parameter, or the absolute one if its value is zero.
const CHANGE: f64 = 1e-4;
/// The difference quotient of order 4: places and weights.
const QUOTIENT: [(f64, f64); 4] = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
/// The smallest size of a derivative, relative to a significant value over the parameter: smaller ones count as this.
const SMALL: f64 = 1e-2;
/// The relative difference above which a derivative counts as wrong.
const WRONG: f64 = 1e-3;

/// The relative error of a difference quotient that is due to rounding.
const ROUNDING: f64 = 3e-10;

/// The factor by which the tolerance is reduced at other parameter values: a difference quotient amplifies irregular
/// errors of the steps.
const TIGHTER: f64 = 1e-3;
/// The smallest tolerance.
const TIGHTEST: f64 = 1e-13;

/// The reliability of the derivatives with respect to a parameter.
pub(super) struct Check {
    parameter: &'static str,
    /// The largest relative difference from difference quotients, and its quantity; `None` if the motion does not reach
    /// its end for slightly different values of the parameter.
    differences: Option<(f64, String)>,
    /// The largest estimated relative error, and its quantity.
    estimated: (f64, String),
    /// The difference of each derivative from its difference quotient, where rounding does not explain it; else zero.
    unexplained: Vec<f64>,
    /// Quantities whose extreme jumps to another time when the parameter changes slightly.
    jumps: Vec<String>,
}

impl Check {
    /// Widens the errors of the derivatives by the parameter in this place where difference quotients contradict them.
    pub(super) fn widen_errors(&self, place: usize, rows: &mut [Quantity]) {
        for (row, difference) in rows.iter_mut().zip(&self.unexplained) {
            if let Some(errors) = &mut row.errors {
                errors.by[place] = errors.by[place].max(*difference);
            }
        }
    }
}

/// The number of motions for the check of this number of parameters.
pub(super) fn motions(parameters: usize) -> usize {
    SensitivityRequest::motions(parameters) + QUOTIENT.len() * parameters
}

/// Computes every derivative in a second way, until interrupted, and assesses its estimated error.
pub(super) fn check(
    (setup, progress): (&Setup, &Progress),
    by: &[&'static str],
    exact: &[Quantity],
    of: &[String],
) -> Vec<Check> {
    let tolerance = (TIGHTER * setup.settings.tolerance).max(TIGHTEST);
    let settings = MethodSettings { tolerance, ..setup.settings };
    let values = setup.model.parameter_values(&setup.replace());
    let outputs = super::outputs(setup, of);
    let mut checks = Vec::new();
    for (place, parameter) in by.iter().enumerate() {
        let at = setup.description.parameters.iter().position(|p| p.name == *parameter).map_or(0.0, |i| values[i]);
        let change = CHANGE * if at == 0.0 { 1.0 } else { at.abs() };
        let mut quotients = vec![0.0; exact.len()];
        let mut has_jumped = vec![false; exact.len()];
        for (steps, weight) in QUOTIENT {
            let own = setup.replace();
            let replace = |name: &str| if name == *parameter { Some(at + steps * change) } else { own(name) };
            let outputs = outputs.as_deref();
            let request = SensitivityRequest { settings, outputs, ..SensitivityRequest::default() };
            let Ok(moved) = super::derive((setup, progress), &replace, request) else {
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
            let is_time = exact[i].what.starts_with("time");
            let is_far = |errors: &DerivativeErrors| errors.value > 2.0 * setup.step();
            has_jumped[i] || is_time && exact[i].value.errors.as_ref().is_some_and(is_far)
        };
        // An extreme that another one replaces has two one-sided derivatives.
        let jumps_at = |i: usize| jumps_at(i) || ["minimum", "maximum"].contains(&exact[i].what) && jumps_at(i + 1);
        let worst = |distance: &dyn Fn(usize, &Derivatives) -> f64| {
            let distances = exact.iter().enumerate().filter(|(i, _)| !jumps_at(*i)).map(|(i, row)| {
                // A derivative that is small compared with its quantity has fewer digits.
                let size = row.value.by[place].abs().max(SMALL * row.scale / scale);
                (distance(i, row.value) / size, format!("{} {}", row.what, row.name))
            });
            distances.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
        };
        let unexplained = quotients.iter().zip(exact).enumerate().map(|(i, (quotient, row))| {
            let difference = (row.value.by[place] - quotient).abs();
            let rounding = ROUNDING * row.value.by[place].abs().max(SMALL * row.scale / scale);
            if jumps_at(i) || difference <= rounding { 0.0 } else { difference }
        });
        let unexplained = unexplained.collect();
        let jumping = exact.iter().enumerate().filter(|(i, _)| jumps_at(*i));
        checks.push(Check {
            parameter,
            differences: (!quotients.is_empty()).then(|| worst(&|i, own| (own.by[place] - quotients[i]).abs())),
            estimated: worst(&|_, own| own.errors.as_ref().map_or(0.0, |errors| errors.by[place])),
            unexplained,
            jumps: jumping.map(|(_, row)| format!("{} {}", row.what, row.name)).collect(),
        });
    }
    checks
}

/// The checks as text.
pub(super) fn text(checks: &[Check]) -> String {
    if checks.is_empty() {
        return String::new();
    }
    let worst = |which: fn(&Check) -> Option<&(f64, String)>| {
        let known = checks.iter().filter_map(|check| Some((check.parameter, which(check)?)));
        let line = |(parameter, (distance, quantity)): (&str, &(f64, String))| {
            format!("{distance:.1e} of the derivative ({quantity} by {parameter})")
        };
        known.max_by(|a, b| a.1.0.total_cmp(&b.1.0)).map_or("not possible: that motion has none".to_owned(), line)
    };
    let mut text = format!(
        "\n  estimated error               {}\n  against difference quotients  {}\n",
        worst(|check| Some(&check.estimated)),
        worst(|check| check.differences.as_ref()),
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

/// Returns an error if the derivatives are unreliable.
pub(super) fn verdict(checks: &[Check]) -> Result<(), Error> {
    let wrong = |found: &(f64, String)| (!(found.0 < WRONG)).then(|| found.1.clone());
    let found = checks.iter().find_map(|check| {
        let (estimated, differences) = (wrong(&check.estimated), check.differences.as_ref().and_then(wrong));
        let is_estimated = estimated.is_some();
        estimated.or(differences).map(|quantity| (check.parameter, quantity, is_estimated))
    });
    let Some((parameter, quantity, is_estimated)) = found else { return Ok(()) };
    let (how, help) = if is_estimated {
        (
            "steps half as long contradict it",
            "try a shorter --step or a smaller --tolerance; corners in loads, and steps so short that rounding errors \
             add up, do the same",
        )
    } else {
        (
            "difference quotients contradict it",
            "a corner in a load, two extremes of about the same size or a motion that soon loses its memory have no \
             useful derivative",
        )
    };
    let text = format!("the derivative of {quantity} by {parameter} cannot be relied on: {how}");
    Err(Error::run(text).help(help))
}
