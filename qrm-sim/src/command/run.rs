//! `qrm run`

use std::path::PathBuf;

use qrm_codegen::resolve;
use qrm_mechanism::Description;

use super::condition::Condition;
use super::recorder::Recorder;
use super::{Failure, RunArguments, report, settings, words};
use crate::motion::Method;
use crate::outcome::{Outcome, Status};
use crate::projection::Tolerance;
use crate::simulate::{End, Request};
use crate::summary::{Named, Summary};

/// Runs a scene and writes its files.
pub(super) fn run(scenes: &crate::scenes::Scenes, arguments: &RunArguments) -> Result<(), Failure> {
    let scene = settings::scene(scenes, &arguments.scene)?;
    let description = scene.description();
    let set = settings::parameters(&description, &arguments.set)?;
    let replace = |name: &str| set.get(name).copied();
    let path = format!("scenes/{}.toml", description.name);
    let (text, _) = resolve::read_with(&path, description.source, &replace).map_err(|r| Failure::Use(r.to_string()))?;

    let option = |name: &str, value: &Option<String>| value.as_ref().map(|v| settings::positive(name, v)).transpose();
    let step = option("--step", &arguments.step)?;
    let end_time = option("--end-time", &arguments.end_time)?;
    let residual =
        option("--closure-tolerance", &arguments.closure_tolerance)?.unwrap_or(Tolerance::default().residual);
    let condition = arguments.until.as_ref().map(|u| Condition::new(&text, u, &replace)).transpose()?;
    let until = |t: f64, q: &[f64], qd: &[f64]| condition.as_ref().map_or(0.0, |c| c.value(t, q, qd));
    let end = match (end_time, &condition) {
        (Some(t), _) => Some(End::Time(t)),
        (None, Some(_)) => Some(End::Condition(&until)),
        (None, None) => None,
    };
    let tolerance = Tolerance { residual, iterations: arguments.closure_iterations };
    let method = Method { projection: arguments.projection.projection(), tolerance };
    let request = Request { method, step, end, estimate_error: !arguments.no_error_estimate };

    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from("out").join(description.name));
    let mut recorder = Recorder::new(&out, description, arguments.every);
    let outcome = scene
        .simulate(&replace, &request, &mut recorder)
        .map_err(|reason| Failure::Use(words::no_start(&reason, &description, &text, &path)))?;
    if let Some(reason) = recorder.unusable.take() {
        return Err(Failure::Use(reason));
    }
    let until = arguments.until.as_deref().unwrap_or(description.until);
    let summary = Summary {
        scene: description.name.to_owned(),
        method: "rk4",
        projection: arguments.projection.name(),
        tolerance: residual,
        step: outcome.step,
        steps: outcome.steps,
        rows: recorder.rows(matches!(outcome.status, Status::Unwritable(_))),
        status: status(&outcome),
        message: words::ending(&outcome, &description, until),
        end_time: outcome.end_time,
        end_state: end_state(&description, &outcome),
        run_seconds: outcome.integration.as_secs_f64(),
        estimated_error: outcome.estimated_error,
        max_residual_position: outcome.residual_position.1,
        max_residual_velocity: outcome.residual_velocity.1,
        energy_drift: outcome.energy_drift,
        extremes: recorder.extremes(),
        parameters: named(description.parameters.iter().map(|p| p.name), &scene.parameters(&replace)),
        warnings: words::warnings(&outcome, &description),
    };
    let written = summary.write(&out.join("summary.json"));
    super::say(&report::report(&summary, &description, &out, written.is_ok()));
    if let Err(e) = written {
        let path = out.join("summary.json");
        return Err(Failure::Run(format!("error: {}\nerror: cannot write {}: {e}", summary.message, path.display())));
    }
    match outcome.status {
        Status::Completed | Status::Stopped | Status::StoppedAtStart => Ok(()),
        _ => Err(Failure::Run(format!("error: {}", summary.message))),
    }
}

fn status(outcome: &Outcome) -> &'static str {
    match outcome.status {
        Status::Completed => "completed",
        Status::Stopped | Status::StoppedAtStart => "stopped",
        Status::StopNotReached { .. } => "stop_not_reached",
        Status::Interrupted => "interrupted",
        Status::Broken(_) | Status::NotFinite { .. } | Status::Unwritable(_) => "failed",
    }
}

fn named<'n>(names: impl Iterator<Item = &'n str>, values: &[f64]) -> Named<f64> {
    Named(names.map(str::to_owned).zip(values.iter().copied()).collect())
}

fn end_state(description: &Description, outcome: &Outcome) -> Named<f64> {
    let states = description.coordinates.iter().zip(&outcome.q).zip(&outcome.qd);
    let each = |((coordinate, q), qd): ((&qrm_mechanism::QuantityDescription, &f64), &f64)| {
        [(coordinate.name.to_owned(), *q), (format!("{}_dot", coordinate.name), *qd)]
    };
    Named(states.flat_map(each).collect())
}
