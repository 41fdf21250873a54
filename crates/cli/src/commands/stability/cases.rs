//! Extreme variants of a scene, run by every method.

use std::time::Duration;

use qrm_core::Model;
use qrm_scene::evaluate::constant;
use qrm_scene::scene::{Extreme, Known};
use qrm_sim::analysis::{Repetitions, Trial, measure, wrap_angle};
use qrm_sim::run::{Observer, Row, accepted_fraction};
use qrm_sim::solve::Linearization;

use super::TOLERANCE;
use crate::error::Error;
use crate::options::{MethodOptions, SceneOptions};
use crate::progress::{Progress, interrupted};
use crate::reference::Reference;
use crate::run_report::rejection_reasons;
use crate::setup::Setup;
use qrm_sim::integrate::METHODS;

/// A variant of a scene.
pub(super) struct Case {
    pub(super) name: String,
    /// The changed parameters.
    pub(super) set: String,
    /// The source of exact values, or the reason why there are none.
    pub(super) origin: String,
    pub(super) results: Vec<CaseResult>,
}

/// The result of a method in a variant.
pub(super) struct CaseResult {
    pub(super) method: &'static str,
    pub(super) steps: u64,
    /// Median run time in s, if the run reached the end.
    pub(super) seconds: Option<f64>,
    /// Largest error of a coordinate, rate or output at the end, relative for values above one.
    pub(super) error: Option<f64>,
    pub(super) verdict: Verdict,
}

/// The comparison of a run's own assessment with the truth.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The run was accepted, and is as accurate as it claims.
    Right,
    /// The run rejected its own result, for this reason.
    Refused(String),
    /// The run was accepted, but is less accurate than it claims.
    Unnoticed,
    /// The run was accepted, and its error is unknown.
    Unknown,
}

/// The repetitions of each run.
const REPETITIONS: Repetitions = Repetitions { least: 3, time: Duration::from_millis(5) };

/// Runs every method on every variant; runs left unfinished by an interrupt are omitted.
pub(super) fn cases(models: &'static [Model], options: &SceneOptions, setup: &Setup) -> Result<Vec<Case>, Error> {
    let (mut cases, spinner) = (Vec::new(), Progress::spinner());
    for extreme in &setup.scene.extremes {
        cases.extend(case(models, options, setup, extreme, &spinner)?);
    }
    Ok(cases)
}

fn case(
    models: &'static [Model],
    options: &SceneOptions,
    setup: &Setup,
    extreme: &Extreme,
    spinner: &Progress,
) -> Result<Option<Case>, Error> {
    let parameters = setup.parameters();
    let set = |(place, value): &(usize, _)| {
        format!("{}={:?}", setup.scene.parameters[*place].name, constant(value, &parameters))
    };
    let changed: Vec<String> = extreme.set.iter().map(set).collect();
    let mut varied = options.clone();
    // The values of the case override those of the command line.
    let name = |text: &str| text.split('=').next().unwrap_or_default().trim().to_owned();
    varied.set.retain(|own| changed.iter().all(|text| name(text) != name(own)));
    varied.set.extend(changed.iter().cloned());
    if let Some(t) = &extreme.end_time {
        (varied.end_time, varied.until) = (Some(format!("{:?}", constant(t, &parameters))), None);
    }
    let is_linearized = Linearization::is_known(&*setup.mechanism());
    let methods = METHODS.into_iter().filter(|method| is_linearized || !method.needs_linearization);
    let mut case =
        Case { name: extreme.name.clone(), set: changed.join(" "), origin: String::new(), results: Vec::new() };
    let mut exact: Option<Result<Exact, String>> = None;
    for method in methods {
        if interrupted() {
            return Ok(None);
        }
        spinner.show(format!("{} by {}", extreme.name, method.name));
        let tolerance = method.is_adaptive().then(|| TOLERANCE.to_owned());
        let how = MethodOptions { method: Some(method), tolerance, ..MethodOptions::default() };
        let variant = Setup::from_found(varied.name.find(models)?, &varied, &how)?;
        let exact = exact.get_or_insert_with(|| Exact::find(&variant, extreme, &parameters, setup.is_changed()));
        case.results.push(run_case(&variant, exact.as_ref().ok()));
    }
    case.origin = match exact {
        Some(Ok(exact)) => exact.origin,
        Some(Err(reason)) => reason,
        None => String::new(),
    };
    Ok((!interrupted()).then_some(case))
}

/// The known values at the end of a variant.
struct Exact {
    values: Vec<(Known, f64)>,
    accuracy: f64,
    origin: String,
}

impl Exact {
    fn find(variant: &Setup, extreme: &Extreme, parameters: &[f64], is_changed: bool) -> Result<Self, String> {
        // The scene's values are valid only without other changes.
        if let (Some(accuracy), false, false) = (&extreme.accuracy, extreme.values.is_empty(), is_changed) {
            let values = extreme.values.iter().map(|(known, value)| (*known, constant(value, parameters))).collect();
            let accuracy = constant(accuracy, parameters);
            return Ok(Self { values, accuracy, origin: "the scene's values".to_owned() });
        }
        let end = variant.latest_end();
        let at: Vec<String> = if end.is_finite() { vec![format!("{end:?}")] } else { Vec::new() };
        let reference = Reference::find(variant, &at, None, None).map_err(|error| error.message().text)?;
        let last = reference.states.last().ok_or("no state is known")?;
        let coordinates = last.q.iter().enumerate().map(|(i, value)| (Known::Coordinate(i), *value));
        let rates = last.qd.iter().enumerate().map(|(i, value)| (Known::Rate(i), *value));
        Ok(Self {
            values: coordinates.chain(rates).collect(),
            accuracy: reference.uncertainty.position.max(reference.uncertainty.rate),
            origin: reference.origin.clone(),
        })
    }

    /// The largest difference from a state, angles modulo a turn.
    fn error(&self, variant: &Setup, q: &[f64], qd: &[f64], outputs: &[f64]) -> f64 {
        let difference = |(known, exact): &(Known, f64)| {
            let difference = match *known {
                Known::Coordinate(i) => wrap_angle(q[i] - exact, &variant.scene.coordinates[i].unit),
                Known::Rate(i) => qd[i] - exact,
                Known::Output(i) => outputs[i] - exact,
            };
            difference.abs() / exact.abs().max(1.0)
        };
        self.values.iter().map(difference).fold(0.0, f64::max)
    }
}

/// Keeps the outputs of the last row.
#[derive(Default)]
struct Last {
    outputs: Vec<f64>,
}

impl Observer for Last {
    fn row(&mut self, row: &Row) -> std::io::Result<()> {
        self.outputs.clear();
        self.outputs.extend_from_slice(row.outputs);
        Ok(())
    }

    fn keep_running(&mut self, _t: f64, _end_time: f64) -> std::io::Result<bool> {
        Ok(!interrupted())
    }
}

fn run_case(variant: &Setup, exact: Option<&Exact>) -> CaseResult {
    let method = variant.settings.method.name;
    let result = |steps, verdict| CaseResult { method, steps, seconds: None, error: None, verdict };
    let mut end = Last::default();
    let outcome = match variant.simulate(true, &mut end) {
        Ok(outcome) => outcome,
        Err(error) => return result(0, Verdict::Refused(error.message().text)),
    };
    let steps = outcome.counts.accepted;
    if !outcome.status.is_done() {
        let reason = variant.status(&outcome.status, (outcome.end_time, None));
        return result(steps, Verdict::Refused(reason.text));
    }
    let tolerance = variant.settings.tolerance();
    let mut reasons = rejection_reasons(variant, &outcome);
    let error = exact.map(|exact| exact.error(variant, &outcome.q, &outcome.qd, &end.outputs));
    let verdict = match (reasons.is_empty(), error, exact) {
        (false, _, _) => Verdict::Refused(reasons.swap_remove(0)),
        (true, Some(error), Some(exact)) if error <= accepted_fraction(tolerance, steps) + exact.accuracy => {
            Verdict::Right
        }
        (true, Some(_), _) => Verdict::Unnoticed,
        (true, None, _) => Verdict::Unknown,
    };
    let trial = Trial { settings: variant.settings, step: variant.step() };
    let measured = measure(&*variant.mechanism(), &trial, &[outcome.end_time], REPETITIONS);
    let seconds = measured.ok().map(|m| m.seconds[m.seconds.len() / 2]);
    CaseResult { seconds, error, ..result(steps, verdict) }
}
