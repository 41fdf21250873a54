//! A survey as text and as numbers.

use qrm_scene::evaluate::constant;
use qrm_scene::scene::{LoadKind, Value};
use qrm_sim::analysis::Spectrum;

use super::TOLERANCE;
use super::limit::Limit;
use super::survey::{Sample, Survey};
use crate::error::Error;
use crate::format::{seconds, wrapped};
use crate::setup::Setup;

/// The ratio of singular values to their largest below which they are reported.
const NEAR: f64 = 0.1;
/// The fraction of the predicted limit beyond which another cause than stability ended a run.
const LATE: f64 = 0.15;
/// The ratio of steps for stability to steps for accuracy above which a motion is stiff.
const STIFF: f64 = 2.0;
/// The condition number above which half of the digits are lost.
const ILL: f64 = 1e8;

/// A number of a spectrum.
type Number = fn(&Spectrum) -> f64;
/// A body or load, and one of its constants.
type Part<'s> = (&'s String, &'s Option<Value>);

/// The text about the survey, with the recommendation.
pub(super) fn text(setup: &Setup, survey: &Survey, limit: &Limit) -> String {
    let outcome = &survey.outcome;
    let mut text = format!(
        "{}: the linearized, constrained equations along the motion (auto, {} steps, {} of them implicit, to t = \
         {})\n\n",
        setup.description.name,
        outcome.counts.accepted,
        outcome.counts.implicit,
        seconds(outcome.end_time)
    );
    let mut line = |topic: &str, value: String| text += &format!("  {topic:20} {value}\n");
    let fastest: [(&str, &str, Number); 3] = [
        ("fastest decay", "/s", |s| s.rate),
        ("fastest oscillation", "rad/s", |s| s.frequency),
        ("fastest growth", "/s", |s| s.growth),
    ];
    for (what, unit, number) in fastest {
        let sample = survey.largest(number);
        line(what, format!("{:.4e} {unit} at t = {}", number(&sample.spectrum), seconds(sample.t)));
    }
    if limit.predicted.is_finite() {
        let mut value = format!("{:.4e} s by the linearized equations", limit.predicted);
        if limit.until > outcome.end_time {
            value += &format!(", to t = {}", seconds(limit.until));
        }
        line("longest step of RK4", value);
        line("", bisected(limit));
        line("the step used", used(setup.step(), limit.predicted));
    } else {
        line("longest step of RK4", "none: nothing decays or oscillates".to_owned());
    }
    let mass = survey.largest(|s| s.condition_mass);
    line("condition of Mbar", format!("{:.3e} at t = {}", mass.spectrum.condition_mass, seconds(mass.t)));
    if !setup.scene.constraints.is_empty() {
        let loops = survey.largest(|s| s.condition_loops);
        let value = format!("{:.3e} at t = {}", loops.spectrum.condition_loops, seconds(loops.t));
        line("condition of loops", value);
        for value in singular(setup, survey) {
            line("singular positions", value);
        }
    }
    for value in ratios(setup) {
        line("ratios", value);
    }
    text + "\n" + &recommendation(setup, survey, limit)
}

fn bisected(limit: &Limit) -> String {
    match limit.found {
        Some((bounded, fails)) => {
            let off = limit.predicted / bounded - 1.0;
            let cause =
                if off > LATE { ": a motion that is not followed any more, rather than an unstable one" } else { "" };
            let off = if off < 1.0 { format!("{:+.1} %", 100.0 * off) } else { times(1.0 + off) };
            format!(
                "{bounded:.4e} s by trial: runs to t = {} stay bounded there and fail at {fails:.4e} s ({off}{cause})",
                seconds(limit.until)
            )
        }
        None => "not found by trial".to_owned(),
    }
}

fn used(step: f64, predicted: f64) -> String {
    let ratio = step / predicted;
    let value = if ratio > 1.0 {
        format!("{} too long for them", times(ratio))
    } else {
        format!("{} shorter", times(1.0 / ratio))
    };
    format!("{}: {value}", seconds(step))
}

fn times(ratio: f64) -> String {
    if ratio < 1e4 { format!("{ratio:.3} times") } else { format!("{ratio:.1e} times") }
}

/// The finite numbers in JSON, for programs.
pub(super) fn numbers(setup: &Setup, survey: &Survey, limit: &Limit) -> serde_json::Value {
    let finite = |number: f64| number.is_finite().then_some(number);
    let largest = |number: Number| finite(number(&survey.largest(number).spectrum));
    let nearest = survey.outcome.nearest_singular;
    let constraint = nearest.map(|nearest| setup.description.constraints[nearest.constraint].name);
    serde_json::json!({
        "scene": setup.description.name,
        "step": setup.step(),
        "end_time": survey.outcome.end_time,
        "problem": survey.problem.as_ref().map(Error::to_string),
        "rate": largest(|s| s.rate),
        "frequency": largest(|s| s.frequency),
        "growth": largest(|s| s.growth),
        "predicted_step": finite(limit.predicted),
        "steps_by_trial": limit.found,
        "trial_end_time": limit.until,
        "steps_for_stability": survey.steps_for_stability(),
        "steps_of_auto": survey.outcome.counts.accepted,
        "implicit_steps_of_auto": survey.outcome.counts.implicit,
        "condition_mass": largest(|s| s.condition_mass),
        "condition_loops": largest(|s| s.condition_loops),
        "smallest_singular_value": nearest.map(|nearest| nearest.value),
        "smallest_singular_value_time": nearest.map(|nearest| nearest.t),
        "smallest_singular_value_constraint": constraint,
    })
}

fn singular(setup: &Setup, survey: &Survey) -> Vec<String> {
    let Some(nearest) = survey.outcome.nearest_singular else { return Vec::new() };
    let places = survey.singular(NEAR);
    if nearest.fraction() >= NEAR || places.is_empty() {
        let value = format!(
            "none nearer than others: the smallest singular value of C_q stays above {:.3} of what it is at most (t = \
             {})",
            nearest.fraction(),
            seconds(nearest.t)
        );
        return vec![value];
    }
    let name = &setup.scene.constraints[nearest.constraint].name;
    let what = if nearest.is_alone { "has no gradient there" } else { "depends on the others there" };
    let first = format!(
        "at t = {} the smallest singular value of C_q falls to {:.1e} of what it is at most: constraint `{name}` \
         {what}",
        seconds(nearest.t),
        nearest.fraction()
    );
    let place = |(sample, part): &(&Sample, f64)| {
        let q = setup.scene.coordinates.iter().zip(&sample.q).map(|(c, q)| format!("{} = {q:.6}", c.name));
        format!("near t = {}: {} ({part:.1e})", seconds(sample.t), q.collect::<Vec<_>>().join(", "))
    };
    std::iter::once(first).chain(places.iter().take(3).map(place)).collect()
}

/// The ratios of the largest to the smallest nonzero mass, inertia, stiffness and damping.
fn ratios(setup: &Setup) -> Vec<String> {
    let parameters = setup.parameters();
    let bodies = &setup.scene.bodies;
    let springs = setup.scene.loads.iter().filter_map(|load| match &load.kind {
        LoadKind::Spring { stiffness, damping, .. } => Some((&load.name, stiffness, damping)),
        _ => None,
    });
    let kinds: [(&str, Vec<Part>); 4] = [
        ("masses", bodies.iter().map(|body| (&body.name, &body.mass)).collect()),
        ("inertias", bodies.iter().map(|body| (&body.name, &body.inertia)).collect()),
        ("stiffnesses", springs.clone().map(|(name, stiffness, _)| (name, stiffness)).collect()),
        ("dampers", springs.map(|(name, _, damping)| (name, damping)).collect()),
    ];
    let ratio = |(what, values): (&str, Vec<Part>)| {
        let number = |(name, value): (_, &Option<Value>)| Some((name, constant(value.as_ref()?, &parameters).abs()));
        let mut numbers: Vec<(&String, f64)> = values.into_iter().filter_map(number).collect();
        numbers.retain(|(_, number)| *number > 0.0 && number.is_finite());
        numbers.sort_by(|a, b| a.1.total_cmp(&b.1));
        let ((least, low), (most, high)) = (numbers.first()?, numbers.last()?);
        (numbers.len() > 1).then(|| format!("{what} {:.3e}: `{least}` {low:e} to `{most}` {high:e}", high / low))
    };
    kinds.into_iter().filter_map(ratio).collect()
}

fn recommendation(setup: &Setup, survey: &Survey, limit: &Limit) -> String {
    let counts = &survey.outcome.counts;
    let step = setup.step();
    let mut sentences = Vec::new();
    let needed = survey.steps_for_stability();
    let compared = format!(
        "RK4 needs {needed:.0} steps for stability alone, `auto` made {} for a tolerance of {TOLERANCE}",
        counts.accepted
    );
    sentences.push(if counts.stability_bound > 0 {
        format!(
            "Stiff: stability bound {} of {} explicit steps. Write `stiff = true` under [run] in {}, for implicit \
             ones; build again if the scene is compiled.",
            counts.stability_bound, counts.accepted, setup.path
        )
    } else if needed > STIFF * counts.accepted as f64 {
        format!("Stiff: {compared}. Use `--method auto`.")
    } else {
        format!("Not stiff: {compared}; accuracy asks for more.")
    });
    // A limit that applies only for short times is ignored: the growth decays again.
    let steps = survey.outcome.end_time / step;
    let bound = limit.found.map(|(bounded, _)| bounded).or((needed > steps).then_some(limit.predicted));
    if let Some(bound) = bound.filter(|bound| step > 0.5 * bound) {
        sentences.push(if step > bound {
            format!("RK4 cannot take the step used, {}: at most {bound:.3e} s.", seconds(step))
        } else {
            format!("RK4 is near the edge with {}: faster parameters will blow it up.", seconds(step))
        });
    }
    let worst = survey.largest(|s| s.condition_mass.max(s.condition_loops)).spectrum;
    let worst = worst.condition_mass.max(worst.condition_loops);
    if worst.is_infinite() {
        sentences.push("The mass matrix is singular: the constraints make up for it, by a slower path.".to_owned());
    } else if worst > ILL {
        sentences.push(format!("Ill-conditioned: about {:.0} of 16 digits are lost in a solve.", worst.log10()));
    }
    if survey.outcome.nearest_singular.is_some_and(|nearest| nearest.fraction() < NEAR) {
        sentences.push("The motion comes near singular positions: see above which constraint fails there.".to_owned());
    }
    wrapped(&sentences.join(" "), 110)
}
