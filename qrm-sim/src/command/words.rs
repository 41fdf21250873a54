//! What went wrong in a run, in words.

use qrm_core::Description;
use qrm_scene::diagnostic::{Diagnostic, Report};
use qrm_scene::scene::Scene as SceneText;

use crate::assembly::NotAssembled;
use crate::motion::Breakdown;
use crate::outcome::{NoStart, Outcome, Status, Undefined};
use crate::trouble::{breakdown, size};

/// Why a run could not begin, with the place in the scene where there is one.
pub(super) fn no_start(reason: &NoStart, description: &Description, scene: &SceneText, path: &str) -> String {
    match reason {
        NoStart::NotAssembled(reason) => not_assembled_report(reason, description, scene, path),
        NoStart::Broken(Breakdown::NotFinite) => "error: the run cannot start: the accelerations are not finite\n  \
             = help: some parameter is too large or too small for double precision"
            .to_owned(),
        NoStart::Broken(reason) => format!("error: the run cannot start: {}", breakdown(reason, description)),
        NoStart::ConditionNotFinite => "error: the stop condition has no finite value at the start\n  \
             = help: look for divisions by zero, roots and logarithms in it"
            .to_owned(),
        NoStart::StepTooShort { step, end_time } => format!(
            "error: a step of {} is too short for a run of {}: time would stand still\n  \
             = help: use a longer step or an earlier end",
            seconds(*step),
            seconds(*end_time)
        ),
    }
}

/// Why a method does not get to the last time.
#[cfg(feature = "pictures")]
pub(super) fn no_way(reason: &NoStart, description: &Description, scene: &SceneText, path: &str) -> String {
    match reason {
        NoStart::Broken(Breakdown::NotFinite) => "breaks off: the state became infinite".to_owned(),
        NoStart::Broken(reason) => format!("breaks off: {}", breakdown(reason, description)),
        other => no_start(other, description, scene, path),
    }
}

/// Why the constraints cannot be met, at their place in the scene.
pub(super) fn not_assembled_report(
    reason: &NotAssembled,
    description: &Description,
    scene: &SceneText,
    path: &str,
) -> String {
    Report::new(path, description.source, vec![not_assembled(reason, scene)]).to_string()
}

fn not_assembled(reason: &NotAssembled, scene: &SceneText) -> Diagnostic {
    let constraint = &scene.constraints[reason.constraint];
    let (name, unit) = (&constraint.name, &constraint.unit);
    if reason.rates {
        return Diagnostic::error(
            format!("the rates at the start cannot be solved for: constraint `{name}` keeps a rate of {} {unit}/s", size(reason.residual)),
            constraint.span.clone(),
            "cannot stay closed with the given rates",
        )
        .help("the mechanism starts at a dead point for the coordinate that is given: start elsewhere, or give another rate");
    }
    if !reason.residual.is_finite() {
        return Diagnostic::error(
            format!("constraint `{name}` has no value at the first guesses"),
            constraint.span.clone(),
            "a root or another function leaves its domain",
        )
        .help("choose other guesses in [initial]");
    }
    let found = scene.coordinates.iter().zip(&reason.q).map(|(c, q)| format!("{} = {q:.6}", c.name));
    Diagnostic::error(
        format!(
            "the mechanism cannot be assembled: constraint `{name}` stays {} {unit} from closed",
            size(reason.residual)
        ),
        constraint.span.clone(),
        format!("not zero anywhere near the first guesses; nearest at {}", found.collect::<Vec<_>>().join(", ")),
    )
    .help("check the lengths that occur here, or start from other guesses in [initial]")
}

/// A method and how its steps are chosen.
#[cfg(any(feature = "fmu", feature = "pictures"))]
pub(super) fn method(name: &str, tolerance: Option<f64>, step: f64) -> String {
    let name = name.to_uppercase();
    match tolerance {
        None => format!("{name}, step {}", seconds(step)),
        Some(tolerance) => format!("{name}, tolerance {tolerance:e}, rows every {}", seconds(step)),
    }
}

/// A sentence in lines of a width.
#[cfg(feature = "stability")]
pub(super) fn in_lines(text: &str, width: usize) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last().map_or(0, String::len);
        if line > 0 && line + 1 + word.len() > width {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(if line.is_empty() { "" } else { " " });
            line.push_str(word);
        }
    }
    lines.join("\n")
}

/// The beginning of a sentence.
#[cfg(feature = "stability")]
pub(super) fn shortened(text: &str, width: usize) -> String {
    match text.char_indices().nth(width) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// A time without the rounding errors of its last digits.
pub(super) fn seconds(t: f64) -> String {
    let rounded: f64 = format!("{t:.13e}").parse().unwrap_or(t);
    let digits = format!("{rounded:?}");
    format!("{} s", digits.strip_suffix(".0").unwrap_or(&digits))
}

/// A run time, with three digits at least.
#[cfg(feature = "pictures")]
pub(super) fn milliseconds(seconds: f64) -> String {
    if seconds < 1e-5 { format!("{:.3} us", seconds * 1e6) } else { format!("{:.3} ms", seconds * 1e3) }
}

/// How a run ended, in one sentence or a few.
pub(super) fn ending(outcome: &Outcome, description: &Description, until: &str) -> String {
    status(&outcome.status, outcome.end_time, description, until)
}

/// The same of a status at a time.
pub(super) fn status(status: &Status, end_time: f64, description: &Description, until: &str) -> String {
    let t = seconds(end_time);
    match status {
        Status::Completed => format!("reached the end time {t}"),
        Status::Stopped => format!("`{until}` became true at t = {t}"),
        Status::StoppedAtStart => format!("`{until}` holds at the start: there is no motion to compute"),
        Status::StopNotReached { nearest_time, missing } => {
            let mut text = format!(
                "`{until}` did not become true by the latest end, t = {t}: it was nearest at t = {}, {missing:.6} short",
                seconds(*nearest_time)
            );
            if *nearest_time < end_time {
                text += ", and has moved away since: the mechanism turned back or stalled, or met the condition only between two steps";
            } else {
                text += ", and was still coming nearer";
            }
            text
        }
        Status::Interrupted => format!("interrupted at t = {t}"),
        Status::Broken(reason) => format!("broke off after t = {t}: {}", breakdown(reason, description)),
        Status::NotFinite { t, what } => {
            let what = match what {
                Undefined::Output(i) => format!("output `{}`", description.outputs[*i].name),
                Undefined::Energy => "the energy".to_owned(),
                Undefined::Condition => format!("the stop condition `{until}`"),
            };
            format!("{what} is not finite at t = {}; the rows before that are kept", seconds(*t))
        }
        Status::Unwritable(e) => format!("a row could not be written: {e}"),
    }
}

/// Energy and work must not differ by more than this fraction of the largest kinetic energy.
const TOLERABLE_IMBALANCE: f64 = 1e-3;
/// Errors of coordinates, in rad or m or relative to larger ones, that a run may have without being asked for less.
const TOLERABLE_ERROR: f64 = 1e-3;
/// A smallest singular value that falls below this fraction of its largest explains what else is wrong.
pub(super) const SUSPECT: f64 = 0.1;
/// One that falls below this fraction is worth a warning by itself.
const SINGULAR: f64 = 1e-2;
/// Errors of a run may be larger than those of its steps by this factor.
const ACCUMULATION: f64 = 1e4;
const ACCUMULATION_PER_STEP: f64 = 10.0;

/// The error of a coordinate, in rad or m or relative to larger ones, that an accepted run stays below.
pub(super) fn claimed(tolerance: Option<f64>, steps: u64) -> f64 {
    let accumulation = ACCUMULATION.max(ACCUMULATION_PER_STEP * steps as f64);
    tolerance.map_or(TOLERABLE_ERROR, |tolerance| (accumulation * tolerance).min(TOLERABLE_ERROR))
}

/// Why the numbers of a run that came to its end are not to be trusted; empty if nothing speaks against them.
pub(super) fn distrust(outcome: &Outcome, description: &Description, tolerance: Option<f64>) -> Vec<String> {
    let mut reasons = Vec::new();
    let imbalance = outcome.energy_imbalance;
    if imbalance > TOLERABLE_IMBALANCE * outcome.largest_kinetic_energy + 1e-12 * outcome.largest_energy {
        let against = match outcome.energy_drift {
            Some(_) => "although every load has a potential",
            None => "more than the loads without potential did work",
        };
        reasons.push(format!("the energy changed by {imbalance:.1e} J {against}"));
    }
    let largest = outcome.q.iter().fold(1.0, |most: f64, q| most.max(q.abs()));
    let claimed = claimed(tolerance, outcome.counts.accepted);
    match outcome.estimated_error {
        Some(error) if !(error <= claimed * largest) => reasons.push(format!(
            "the estimated error of {error:.1e} is beyond the {:.0e} that {} stands for",
            claimed * largest,
            if tolerance.is_some() { "the tolerance" } else { "a run without a tolerance" }
        )),
        None if outcome.error_unknown => reasons.push(match tolerance {
            Some(_) => "the second run that tells the error, at a tenth of the tolerance, broke off".to_owned(),
            None => "the second run that tells the error broke off, so the step is near the limit of what is stable"
                .to_owned(),
        }),
        _ => {}
    }
    let moved = outcome.care.moved;
    if moved > claimed * largest {
        reasons.push(format!(
            "closing the loops after a step moved a coordinate by {moved:.1e}, from residuals up to {:.1e}",
            outcome.care.open
        ));
    }
    if !reasons.is_empty() {
        reasons.extend(near_singular(outcome, description, SUSPECT));
    }
    reasons
}

/// Where the constraints said too little, if their smallest singular value fell below a fraction of its largest.
fn near_singular(outcome: &Outcome, description: &Description, below: f64) -> Option<String> {
    let nearest = outcome.nearest_singular.filter(|nearest| nearest.fraction() < below)?;
    let name = description.constraints[nearest.constraint].name;
    let what = if nearest.is_alone {
        format!(
            "constraint `{name}` says nothing there. If another form of the closure does not vanish there, write that one (a root \
             times a cosine vanishes where `A.x*sin(phi) - A.y*cos(phi)` does not)"
        )
    } else {
        format!("constraint `{name}` says there what the others say")
    };
    Some(format!(
        "the mechanism came near a singular position: the smallest singular value of C_q fell to {:.0e} of its largest at t = {}; {what}",
        nearest.fraction(),
        seconds(nearest.t)
    ))
}

/// What needed care on the way, beside what a run is distrusted for.
pub(super) fn warnings(outcome: &Outcome, description: &Description, distrust: &[String]) -> Vec<String> {
    let care = &outcome.care;
    let mut warnings = Vec::new();
    if distrust.is_empty() {
        warnings.extend(near_singular(outcome, description, SINGULAR));
    }
    if outcome.counts.bound > 0 {
        warnings.push(format!(
            "{} of {} steps were as long as stability allows: the mechanism is stiff. Write `stiff = true` under [run] in \
             scenes/{}.toml and build again, for implicit steps",
            outcome.counts.bound, outcome.counts.accepted, description.name
        ));
    }
    if care.singular_mass > 0 {
        warnings.push(format!(
            "the mass matrix was singular by itself in {} solves; the constraints made up for it",
            care.singular_mass
        ));
    }
    if care.settled > 0 {
        let constraint = &description.constraints[care.farthest.0];
        warnings.push(format!(
            "after {} steps rounding errors kept constraint `{}` open by up to {:.1e} {}: the mechanism came near a singular \
             position",
            care.settled, constraint.name, care.farthest.1, constraint.unit
        ));
    }
    if care.dependent_constraints > 0 {
        let name = care.constraint.map_or("?", |i| description.constraints[i].name);
        warnings.push(format!(
            "constraint `{name}` depended on the others in {} solves: its multiplier is not unique there",
            care.dependent_constraints
        ));
    }
    warnings
}
