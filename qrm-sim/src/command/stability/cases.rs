//! Extreme variants of a scene, each by every method.

use std::time::Duration;

use qrm_scene::evaluate::constant;
use qrm_scene::scene::{Extreme, Known};

use super::super::arguments::{MethodArguments, MethodName, SceneArguments};
use super::super::progress::interrupted;
use super::super::reference::Reference;
use super::super::setup::Setup;
use super::super::{Failure, words};
use super::TOLERANCE;
use crate::measure::{Patience, Trial};
use crate::observer::{Observer, Row};
use crate::scenes::Scenes;
use crate::turn::wrapped;

/// A variant.
pub(super) struct Case {
    pub(super) name: String,
    /// The parameters that are different.
    pub(super) set: String,
    /// Where exact values are from, or why there are none.
    pub(super) origin: String,
    pub(super) trials: Vec<Tried>,
}

/// What became of a method.
pub(super) struct Tried {
    pub(super) method: &'static str,
    pub(super) steps: u64,
    /// Median run time in s, if it got to the end.
    pub(super) seconds: Option<f64>,
    /// Largest error of a coordinate, rate or output at the end, relative to values above one.
    pub(super) error: Option<f64>,
    pub(super) verdict: Verdict,
}

/// How a run is to be judged.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    /// It was accepted, and is as accurate as it claims.
    Right,
    /// It was refused by itself, for this reason.
    Refused(String),
    /// It was accepted, and is not as accurate as it claims.
    Unnoticed,
    /// It was accepted, and nothing tells its error.
    Unknown,
}

/// Each run is repeated so often, and for so long.
const PATIENCE: Patience = Patience { least: 3, time: Duration::from_millis(5) };

/// Tries every method on every variant.
pub(super) fn cases(scenes: &Scenes, arguments: &SceneArguments, setup: &Setup) -> Result<Vec<Case>, Failure> {
    let mut cases = Vec::new();
    for extreme in &setup.text.extremes {
        if interrupted() {
            return Err(Failure::Run("error: interrupted".to_owned()));
        }
        cases.push(case(scenes, arguments, setup, extreme)?);
    }
    Ok(cases)
}

fn case(scenes: &Scenes, arguments: &SceneArguments, setup: &Setup, extreme: &Extreme) -> Result<Case, Failure> {
    let parameters = setup.parameters();
    let set = |(place, value): &(usize, _)| {
        format!("{}={:?}", setup.text.parameters[*place].name, constant(value, &parameters))
    };
    let changed: Vec<String> = extreme.set.iter().map(set).collect();
    let mut varied = arguments.clone();
    varied.set.extend(changed.iter().cloned());
    if let Some(t) = &extreme.end_time {
        (varied.end_time, varied.until) = (Some(format!("{:?}", constant(t, &parameters))), None);
    }
    let mut methods = vec![MethodName::Rk4, MethodName::Dopri5, MethodName::Dop853];
    methods.extend(setup.text.run.stiff.then_some(MethodName::Rodas));
    methods.push(MethodName::Auto);
    let mut case =
        Case { name: extreme.name.clone(), set: changed.join(" "), origin: String::new(), trials: Vec::new() };
    let mut exact: Option<Result<Exact, String>> = None;
    for name in methods {
        let tolerance = (!matches!(name, MethodName::Rk4)).then(|| TOLERANCE.to_owned());
        let how = MethodArguments { method: name, tolerance, ..MethodArguments::default() };
        let variant = Setup::new(scenes, &varied, &how)?;
        let exact = exact.get_or_insert_with(|| Exact::find(&variant, extreme, &parameters, setup.is_changed()));
        case.trials.push(tried(&variant, exact.as_ref().ok()));
    }
    case.origin = match exact {
        Some(Ok(exact)) => exact.origin,
        Some(Err(reason)) => reason,
        None => String::new(),
    };
    Ok(case)
}

/// What is known of the end of a variant.
struct Exact {
    values: Vec<(Known, f64)>,
    accuracy: f64,
    origin: String,
}

impl Exact {
    fn find(variant: &Setup, extreme: &Extreme, parameters: &[f64], is_changed: bool) -> Result<Self, String> {
        // Values hold for the scene as it stands.
        if let (Some(accuracy), false, false) = (&extreme.accuracy, extreme.values.is_empty(), is_changed) {
            let values = extreme.values.iter().map(|(known, value)| (*known, constant(value, parameters))).collect();
            let accuracy = constant(accuracy, parameters);
            return Ok(Self { values, accuracy, origin: "the scene's values".to_owned() });
        }
        let end = variant.latest_end();
        let at: Vec<String> = if end.is_finite() { vec![format!("{end:?}")] } else { Vec::new() };
        let reference = Reference::find(variant, &at, None).map_err(|failure| match failure {
            Failure::Run(reason) | Failure::Use(reason) => reason.lines().next().unwrap_or_default().to_owned(),
        })?;
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
                Known::Coordinate(i) => wrapped(q[i] - exact, &variant.text.coordinates[i].unit),
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
}

fn tried(variant: &Setup, exact: Option<&Exact>) -> Tried {
    let tried = |steps, verdict| Tried { method: variant.method_name, steps, seconds: None, error: None, verdict };
    let refused = |reason: &str| Verdict::Refused(reason.lines().next().unwrap_or_default().to_owned());
    let mut end = Last::default();
    let outcome = match variant.simulate(true, &mut end) {
        Ok(outcome) => outcome,
        Err(Failure::Run(reason) | Failure::Use(reason)) => return tried(0, refused(&reason)),
    };
    let steps = outcome.counts.accepted;
    if !outcome.status.is_done() {
        return tried(steps, refused(&words::ending(&outcome, &variant.description, &variant.until)));
    }
    let tolerance = variant.method.scheme.tolerance();
    let distrust = words::distrust(&outcome, &variant.description, tolerance);
    let error = exact.map(|exact| exact.error(variant, &outcome.q, &outcome.qd, &end.outputs));
    let verdict = match (distrust.first(), error, exact) {
        (Some(reason), _, _) => refused(reason),
        (None, Some(error), Some(exact)) if error <= words::claimed(tolerance, steps) + exact.accuracy => {
            Verdict::Right
        }
        (None, Some(_), _) => Verdict::Unnoticed,
        (None, None, _) => Verdict::Unknown,
    };
    let trial = Trial { method: variant.method, step: variant.step() };
    let measured = variant.scene.measure(&variant.replace(), &trial, &[outcome.end_time], PATIENCE);
    let seconds = measured.ok().map(|m| m.seconds[m.seconds.len() / 2]);
    Tried { seconds, error, ..tried(steps, verdict) }
}
