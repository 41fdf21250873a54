//! The judgement on the numbers of a run.

use qrm_core::Description;
use qrm_sim::run::Outcome;

use crate::error::Message;
use crate::format::{counted, seconds};

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
pub(crate) fn accepted_error(tolerance: Option<f64>, steps: u64) -> f64 {
    let accumulation = ACCUMULATION.max(ACCUMULATION_PER_STEP * steps as f64);
    tolerance.map_or(TOLERABLE_ERROR, |tolerance| (accumulation * tolerance).min(TOLERABLE_ERROR))
}

/// The reasons not to trust the numbers of a run that came to its end.
pub(crate) fn distrust(outcome: &Outcome, description: &Description, tolerance: Option<f64>) -> Vec<String> {
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
    let accepted = accepted_error(tolerance, outcome.counts.accepted);
    match outcome.estimated_error {
        Some(error) if !(error <= accepted * largest) => reasons.push(format!(
            "the estimated error of {error:.1e} is beyond the {:.0e} that {} stands for",
            accepted * largest,
            if tolerance.is_some() { "the tolerance" } else { "a run without a tolerance" }
        )),
        None if outcome.companion_failed => reasons.push(match tolerance {
            Some(_) => "the second run that estimates the error, at a tenth of the tolerance, broke off".to_owned(),
            None => {
                "the second run that estimates the error broke off, so the step is near the limit of what is stable"
                    .to_owned()
            }
        }),
        _ => {}
    }
    let moved = outcome.stats.correction;
    if moved > accepted * largest {
        reasons.push(format!(
            "closing the loops after a step moved a coordinate by {moved:.1e}, from residuals up to {:.1e}",
            outcome.stats.residual_before_correction
        ));
    }
    if !reasons.is_empty() {
        reasons.extend(near_singular(outcome, description, SUSPECT).map(|message| message.text));
    }
    reasons
}

/// The place where the constraints were nearest to singular, if their smallest singular value fell below a fraction of
/// its largest.
fn near_singular(outcome: &Outcome, description: &Description, below: f64) -> Option<Message> {
    let nearest = outcome.nearest_singular.filter(|nearest| nearest.fraction() < below)?;
    let name = description.constraints[nearest.constraint].name;
    let (fraction, t) = (nearest.fraction(), seconds(nearest.t));
    let what = if nearest.is_alone { "has no gradient there" } else { "depends on the others there" };
    let message = Message::new(format!(
        "the mechanism came near a singular position: the smallest singular value of C_q fell to {fraction:.0e} of its \
         largest at t = {t}; constraint `{name}` {what}"
    ));
    let help = "write the constraint in a form that does not vanish there, if there is one (a root times a cosine \
                vanishes where `A.x*sin(phi) - A.y*cos(phi)` does not)";
    Some(if nearest.is_alone { message.help(help) } else { message })
}

/// The warnings about a run, beside the reasons to distrust it.
pub(super) fn warnings(outcome: &Outcome, description: &Description, distrust: &[String]) -> Vec<Message> {
    let stats = &outcome.stats;
    let mut warnings = Vec::new();
    if distrust.is_empty() {
        warnings.extend(near_singular(outcome, description, SINGULAR));
    }
    if outcome.counts.stability_bound > 0 {
        let (bound, steps) = (outcome.counts.stability_bound, counted(outcome.counts.accepted, "step"));
        let text = format!("{bound} of {steps} were as long as stability allows: the mechanism is stiff");
        let scene = description.name;
        warnings.push(Message::new(text).help(format!(
            "write `stiff = true` under [run] in scenes/{scene}.toml and build again, for implicit steps"
        )));
    }
    if stats.singular_mass > 0 {
        warnings.push(Message::new(format!(
            "the mass matrix was singular by itself in {}; the constraints made up for it",
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
    if stats.dependent_constraints > 0 {
        let name = stats.constraint.map_or("?", |i| description.constraints[i].name);
        warnings.push(Message::new(format!(
            "constraint `{name}` depended on the others in {}: its multiplier is not unique there",
            counted(stats.dependent_constraints, "solve")
        )));
    }
    warnings
}
