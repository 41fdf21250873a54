//! The judgement on the results of a run.

use qrm_core::{Description, QuantityDescription};
use qrm_scene::document::Side;
use qrm_sim::batch::DesignResult;
use qrm_sim::columns::Kind;
use qrm_sim::run::{NearestSingularity, Outcome, Redundancy, Status};

use crate::error::Message;
use crate::format::{counted, seconds};
use crate::setup::Setup;
use qrm_pictures::Recording;

/// The ratio of the smallest singular value to its largest value below which it explains other problems.
pub(super) const EXPLAINS_FAILURE: f64 = 0.1;
/// The ratio of the smallest singular value to its largest value below which it deserves a warning.
const SINGULAR: f64 = 1e-2;
/// The reaction, relative to the largest multiplier, up to which it is a rounding error.
const ROUNDING: f64 = 1e-9;

/// The reasons not to trust the results of a completed run.
pub(crate) fn rejection_reasons(setup: &Setup, outcome: &Outcome) -> Vec<String> {
    let description = setup.description;
    let rejection_reasons = outcome.rejection_reasons(description);
    let mut reasons: Vec<String> =
        rejection_reasons.iter().map(|reason| reason.text(outcome.tolerance, description)).collect();
    if !reasons.is_empty() {
        let near = near_singular(setup, outcome.nearest_singular, EXPLAINS_FAILURE);
        reasons.extend(near.map(|message| message.text));
    }
    reasons
}

/// The position at which the constraints were nearest to singular, if the ratio of their smallest singular value to its
/// largest value fell below a limit.
fn near_singular(setup: &Setup, nearest: Option<NearestSingularity>, below: f64) -> Option<Message> {
    let nearest = nearest.filter(|nearest| nearest.fraction() < below)?;
    let name = setup.description.constraints[nearest.constraint].name;
    let (fraction, t) = (nearest.fraction(), seconds(nearest.t));
    let what = if nearest.is_alone { "has no gradient there" } else { "depends on the others there" };
    let message = Message::new(format!(
        "the mechanism came near a singular position: the smallest singular value of C_q fell to {fraction:.0e} of its \
         largest at t = {t}; constraint `{name}` {what}"
    ));
    if setup.scene.has_links {
        return Some(message.help("if the mechanism is not meant to pass it, change its dimensions or its drive"));
    }
    let help = "write the constraint in a form that does not vanish there, if there is one";
    Some(if nearest.is_alone { message.help(help) } else { message })
}

/// The warnings about a run, in addition to the reasons to distrust it.
pub(super) fn warnings(setup: &Setup, outcome: &Outcome, distrust: &[String]) -> Vec<Message> {
    let description = setup.description;
    let stats = &outcome.stats;
    let mut warnings = Vec::new();
    if distrust.is_empty() {
        warnings.extend(near_singular(setup, outcome.nearest_singular, SINGULAR));
    }
    if let Some((coordinate, error)) = outcome.start_uncertainty {
        let QuantityDescription { name, unit, .. } = description.coordinates[coordinate];
        let text = format!(
            "at the start the given coordinates determine `{name}` only within {error:.0e} {unit}: they hardly change \
             with it there"
        );
        let help = if setup.scene.has_links {
            format!("give an `angle` and a `rate` to the link of `{name}` instead, or to a link that is joined to it")
        } else {
            format!("give `{name}` in their place, under [initial]")
        };
        warnings.push(Message::new(text).help(help));
    }
    if matches!(outcome.status, Status::Stopped) && outcome.errors.as_ref().is_some_and(|e| e.end_time().is_none()) {
        let text = "the error of the end time is not known: the condition jumps, stays as it is or has a pole there";
        warnings.push(Message::new(text.to_owned()).help("end at a condition that rises steadily through its bound"));
    }
    for output in &outcome.extremes_of_rows {
        let name = description.outputs[*output].name;
        warnings.push(
            Message::new(format!("the extremes of `{name}` are those of rows: bounds between rows do not tell more"))
                .help("write its formula with fewer operations, or ask for more rows by a shorter --step"),
        );
    }
    if outcome.counts.stability_bound > 0 {
        let (bound, steps) = (outcome.counts.stability_bound, counted(outcome.counts.accepted, "step"));
        let text = format!("{bound} of {steps} were as long as stability allows: the mechanism is stiff");
        warnings.push(
            Message::new(text).help(
                "write `stiff = true` under [run] in the scene, for implicit steps; build again if it is compiled",
            ),
        );
    }
    // A few positions at which a kernel is not valid do not call for another method.
    if outcome.counts.fallback > outcome.counts.accepted / 50 {
        let (fallback, steps) = (outcome.counts.fallback, counted(outcome.counts.accepted, "step"));
        warnings.push(
            Message::new(format!("`auto` made {fallback} of {steps}, where the Gauss method does not apply")).help(
                "it needs smooth loads, a motion that is not stiff, independent constraints, positions and a size that \
                 suit a kernel in vectors, and a processor with AVX2; `--method auto` suits every scene",
            ),
        );
    }
    if stats.singular_mass > 0 {
        warnings.push(Message::new(format!(
            "the mass matrix was singular in {}; the constraints made up for it",
            counted(stats.singular_mass, "solve")
        )));
    }
    if stats.stalled_projections > 0 {
        let constraint = description.constraints[stats.largest_stalled_residual.0];
        warnings.push(Message::new(format!(
            "after {} rounding errors kept constraint `{}` open by up to {:.1e} {}: the mechanism came near a \
             singular position",
            counted(stats.stalled_projections, "step"),
            constraint.name,
            stats.largest_stalled_residual.1,
            constraint.unit
        )));
    }
    warnings.extend(outcome.redundancy.as_ref().map(|redundancy| not_unique(redundancy, description)));
    if stats.dependent_constraints > 0 {
        let name = stats.constraint.map_or("?", |i| description.constraints[i].name);
        warnings.push(Message::new(format!(
            "constraint `{name}` depended on the others in {}: its multiplier is not unique there",
            counted(stats.dependent_constraints, "solve")
        )));
    }
    warnings
}

/// The warning that constraints are redundant.
fn not_unique(Redundancy { rank, multipliers, outputs }: &Redundancy, description: &Description) -> Message {
    let freedoms = match description.coordinates.len() - rank {
        1 => "1 degree of freedom".to_owned(),
        freedoms => format!("{freedoms} degrees of freedom"),
    };
    let constraints: Vec<&str> = multipliers.iter().map(|&k| description.constraints[k].name).collect();
    let outputs: Vec<&str> = outputs.iter().map(|&i| description.outputs[i].name).collect();
    Message::new(format!(
        "C_q has rank {rank} with {}, which leaves {freedoms}: some constraints repeat others. The motion is \
         unique. The multipliers of {} are not: those of least norm are given{}",
        counted(description.constraints.len() as u64, "constraint"),
        constraints.join(", "),
        if outputs.is_empty() { String::new() } else { format!(", and {} with them", outputs.join(", ")) },
    ))
}

/// The warnings of the run of a design that concern its numbers.
pub(crate) fn design_warnings(setup: &Setup, finished: &DesignResult) -> Vec<Message> {
    let near = near_singular(setup, finished.nearest_singular, SINGULAR);
    near.into_iter().chain(finished.redundancy.as_ref().map(|found| not_unique(found, setup.description))).collect()
}

/// A warning for each one-sided joint that would have opened.
pub(super) fn open_joints(setup: &Setup, recording: &Recording) -> Vec<Message> {
    let joints = setup.scene.constraints.iter().enumerate().filter_map(|(i, joint)| Some((i, joint, joint.one_sided?)));
    let open = joints.filter_map(|(i, joint, side)| {
        let mut series = recording.series(Kind::Multiplier(i));
        // The extremes include those between rows.
        let extremes = recording.extremes(Kind::Multiplier(i));
        series.extend(extremes.iter().flat_map(|found| [found.minimum, found.maximum]).map(|(value, t)| (t, value)));
        series.sort_by(|a, b| a.0.total_cmp(&b.0));
        let t = opening(side, &series)?;
        let sign = if side == Side::Below { "negative" } else { "positive" };
        Some(Message::new(format!(
            "`lambda_{0}` is {sign} by t = {1}: the joint `{0}` is one-sided and would open there, and what follows is \
             another motion",
            joint.name,
            seconds(t)
        )))
    });
    open.collect()
}

/// The first time at which a one-sided joint would have to act in the other direction.
fn opening(side: Side, multipliers: &[(f64, f64)]) -> Option<f64> {
    let sign = if side == Side::Below { 1.0 } else { -1.0 };
    let largest = multipliers.iter().fold(0.0_f64, |most, (_, value)| most.max(value.abs()));
    // Rounding errors do not count.
    multipliers.iter().find(|(_, value)| sign * value < -ROUNDING * largest).map(|(t, _)| *t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_one_sided_joint_opens_where_it_would_have_to_act_on_the_other_side() {
        let multipliers = [(0.0, 50.0), (0.1, 1e-9), (0.2, -1e-9), (0.3, -2.0), (0.4, 3.0)];
        assert_eq!(opening(Side::Below, &multipliers), Some(0.3));
        assert_eq!(opening(Side::Above, &multipliers), Some(0.0));
        assert_eq!(opening(Side::Below, &multipliers[..3]), None);
        assert_eq!(opening(Side::Above, &[]), None);
    }
}
