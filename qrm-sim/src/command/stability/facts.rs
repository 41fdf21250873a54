//! What a survey shows, in words.

use qrm_scene::evaluate::constant;
use qrm_scene::scene::{LoadKind, Value};

use super::super::setup::Setup;
use super::super::words::{self, seconds};
use super::TOLERANCE;
use super::limit::Limit;
use super::survey::{Sample, Survey};
use crate::spectrum::Spectrum;

/// Singular values below this part of their largest are worth a word.
const NEAR: f64 = 0.1;
/// Beyond this, it is not stability that ends a run.
const LATE: f64 = 0.15;
/// Steps for stability that are so many times as many as those for accuracy make a motion stiff.
const STIFF: f64 = 2.0;
/// Conditions above this cost half of the digits.
const ILL: f64 = 1e8;

/// A number of a spectrum.
type Number = fn(&Spectrum) -> f64;
/// The name of something, and what it has of a kind.
type Part<'s> = (&'s String, &'s Option<Value>);

/// The facts, and the verdict.
pub(super) fn facts(setup: &Setup, survey: &Survey, limit: &Limit) -> String {
    let outcome = &survey.outcome;
    let mut text = format!(
        "{}: the linearized, constrained equations along the motion (auto, {} steps of which {} implicit, to t = {})\n\n",
        setup.description.name,
        outcome.counts.accepted,
        outcome.counts.implicit,
        seconds(outcome.end_time)
    );
    let mut fact = |what: &str, said: String| text += &format!("  {what:20} {said}\n");
    let fastest: [(&str, &str, Number); 3] = [
        ("fastest decay", "/s", |s| s.rate),
        ("fastest oscillation", "rad/s", |s| s.frequency),
        ("fastest growth", "/s", |s| s.growth),
    ];
    for (what, unit, number) in fastest {
        let sample = survey.largest(number);
        fact(what, format!("{:.4e} {unit} at t = {}", number(&sample.spectrum), seconds(sample.t)));
    }
    if limit.predicted.is_finite() {
        let mut said = format!("{:.4e} s by the linearized equations", limit.predicted);
        if limit.until > outcome.end_time {
            said += &format!(", to t = {}", seconds(limit.until));
        }
        fact("longest step of RK4", said);
        fact("", bisected(limit));
        fact("the step used", used(setup.step(), limit.predicted));
    } else {
        fact("longest step of RK4", "none: nothing decays or oscillates".to_owned());
    }
    let mass = survey.largest(|s| s.condition_mass);
    fact("condition of Mbar", format!("{:.3e} at t = {}", mass.spectrum.condition_mass, seconds(mass.t)));
    if !setup.text.constraints.is_empty() {
        let loops = survey.largest(|s| s.condition_loops);
        let said = format!("{:.3e} at t = {}", loops.spectrum.condition_loops, seconds(loops.t));
        fact("condition of loops", said);
        for said in singular(setup, survey) {
            fact("singular positions", said);
        }
    }
    for said in ratios(setup) {
        fact("ratios", said);
    }
    text + "\n" + &verdict(setup, survey, limit)
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
        None => "no trial tells it".to_owned(),
    }
}

fn used(step: f64, predicted: f64) -> String {
    let ratio = step / predicted;
    let said = if ratio > 1.0 {
        format!("{} too long for them", times(ratio))
    } else {
        format!("{} shorter", times(1.0 / ratio))
    };
    format!("{}: {said}", seconds(step))
}

fn times(ratio: f64) -> String {
    if ratio < 1e4 { format!("{ratio:.3} times") } else { format!("{ratio:.1e} times") }
}

/// The same for programs; what is infinite is left out.
pub(super) fn numbers(setup: &Setup, survey: &Survey, limit: &Limit) -> serde_json::Value {
    let finite = |number: f64| number.is_finite().then_some(number);
    let largest = |number: Number| finite(number(&survey.largest(number).spectrum));
    let nearest = survey.outcome.nearest_singular;
    serde_json::json!({
        "scene": setup.description.name,
        "step": setup.step(),
        "end_time": survey.outcome.end_time,
        "problem": survey.problem,
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
        "smallest_singular_value_constraint": nearest.map(|nearest| setup.text.constraints[nearest.constraint].name.clone()),
    })
}

fn singular(setup: &Setup, survey: &Survey) -> Vec<String> {
    let Some(nearest) = survey.outcome.nearest_singular else { return Vec::new() };
    let places = survey.singular(NEAR);
    if nearest.fraction() >= NEAR || places.is_empty() {
        let said = format!(
            "none nearer than others: the smallest singular value of C_q stays above {:.3} of what it is at most (t = {})",
            nearest.fraction(),
            seconds(nearest.t)
        );
        return vec![said];
    }
    let name = &setup.text.constraints[nearest.constraint].name;
    let what = if nearest.is_alone { "says nothing" } else { "says what others say" };
    let first = format!(
        "at t = {} the smallest singular value of C_q falls to {:.1e} of what it is at most: constraint `{name}` {what}",
        seconds(nearest.t),
        nearest.fraction()
    );
    let place = |(sample, part): &(&Sample, f64)| {
        let q = setup.text.coordinates.iter().zip(&sample.q).map(|(c, q)| format!("{} = {q:.6}", c.name));
        format!("near t = {}: {} ({part:.1e})", seconds(sample.t), q.collect::<Vec<_>>().join(", "))
    };
    std::iter::once(first).chain(places.iter().take(3).map(place)).collect()
}

/// Largest to smallest mass, inertia, stiffness and damping, of those that are not zero.
fn ratios(setup: &Setup) -> Vec<String> {
    let parameters = setup.parameters();
    let bodies = &setup.text.bodies;
    let springs = setup.text.loads.iter().filter_map(|load| match &load.kind {
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

fn verdict(setup: &Setup, survey: &Survey, limit: &Limit) -> String {
    let counts = &survey.outcome.counts;
    let step = setup.step();
    let mut said = Vec::new();
    let needed = survey.steps_for_stability();
    let compared = format!(
        "RK4 needs {needed:.0} steps for stability alone, `auto` made {} for a tolerance of {TOLERANCE}",
        counts.accepted
    );
    said.push(if counts.bound > 0 {
        format!(
            "Stiff: stability bound {} of {} explicit steps. Write `stiff = true` under [run] in scenes/{}.toml and build again, for \
             implicit ones.",
            counts.bound, counts.accepted, setup.description.name
        )
    } else if needed > STIFF * counts.accepted as f64 {
        format!("Stiff: {compared}. Use `--method auto`.")
    } else {
        format!("Not stiff: {compared}; accuracy asks for more.")
    });
    // A limit that holds for moments alone is none: what grows then decays again.
    let steps = survey.outcome.end_time / step;
    let bound = limit.found.map(|(bounded, _)| bounded).or((needed > steps).then_some(limit.predicted));
    if let Some(bound) = bound.filter(|bound| step > 0.5 * bound) {
        said.push(if step > bound {
            format!("RK4 cannot take the step used, {}: at most {bound:.3e} s.", seconds(step))
        } else {
            format!("RK4 is near the edge with {}: faster parameters will blow it up.", seconds(step))
        });
    }
    let worst = survey.largest(|s| s.condition_mass.max(s.condition_loops)).spectrum;
    let worst = worst.condition_mass.max(worst.condition_loops);
    if worst.is_infinite() {
        said.push(
            "The mass matrix is singular by itself: the constraints make up for it, by a slower path.".to_owned(),
        );
    } else if worst > ILL {
        said.push(format!("Ill-conditioned: about {:.0} of 16 digits are lost in a solve.", worst.log10()));
    }
    if survey.outcome.nearest_singular.is_some_and(|nearest| nearest.fraction() < NEAR) {
        said.push("The motion comes near singular positions: see above which constraint fails there.".to_owned());
    }
    words::in_lines(&said.join(" "), 110)
}
