//! Every method at a ladder of steps or tolerances.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::super::setup::Setup;
use super::super::{Failure, words};
use super::errors::Errors;
use super::reference::Reference;
use crate::measure::{Measurement, Patience, Trial};
use crate::motion::{Method, Scheme};
use crate::projection::Projection;
use crate::simulate::{End, Request};

/// A method with one step or tolerance.
pub(super) struct Rung {
    /// The method's name.
    pub(super) method: &'static str,
    /// Its step, or its tolerance.
    pub(super) setting: Setting,
    /// Why it did not get to the end, or what it gave.
    pub(super) result: Result<Measured, String>,
}

/// What makes a method more or less accurate.
#[derive(Clone, Copy, Debug)]
pub(super) enum Setting {
    /// Length of the steps.
    Step(f64),
    /// Largest error of a step.
    Tolerance(f64),
}

/// What a rung gave.
pub(super) struct Measured {
    pub(super) steps: u64,
    pub(super) evaluations: u64,
    /// Seconds: a quarter of the repetitions were faster, the median, a quarter were slower.
    pub(super) seconds: [f64; 3],
    pub(super) errors: Errors,
    pub(super) residual: f64,
    pub(super) energy_drift: f64,
    /// What a plain run says of its own error at the end.
    pub(super) estimate: Option<f64>,
}

/// Each rung is repeated at least so often, and for so long.
const PATIENCE: Patience = Patience { least: 7, time: Duration::from_millis(15) };
/// Steps go from so many times that of the scene downward by halves.
const COARSEST: f64 = 8.0;
const HALVINGS: i32 = 11;
/// Above this error it may be chance that a smaller step brought nothing.
const FINE: f64 = 1e-9;
/// Tolerances go from one power of ten to another.
const TOLERANCES: std::ops::RangeInclusive<i32> = 3..=14;

/// The methods, with the projections that make a difference.
const METHODS: [Way; 6] = [
    Way { name: "document", formula: Formula::Fixed(Scheme::Document), projection: Projection::Euclidean },
    Way { name: "rk4, no projection", formula: Formula::Fixed(Scheme::Rk4), projection: Projection::None },
    Way { name: "rk4, Euclidean", formula: Formula::Fixed(Scheme::Rk4), projection: Projection::Euclidean },
    Way { name: "rk4, mass metric", formula: Formula::Fixed(Scheme::Rk4), projection: Projection::Mass },
    Way { name: "dopri5, mass metric", formula: Formula::Adaptive(dopri5), projection: Projection::Mass },
    Way { name: "dop853, mass metric", formula: Formula::Adaptive(dop853), projection: Projection::Mass },
];

/// A method with its projection.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    formula: Formula,
    projection: Projection,
}

/// A formula, and what makes it more accurate.
#[derive(Clone, Copy)]
enum Formula {
    Fixed(Scheme),
    Adaptive(fn(f64) -> Scheme),
}

fn dopri5(tolerance: f64) -> Scheme {
    Scheme::Dopri5 { tolerance }
}

fn dop853(tolerance: f64) -> Scheme {
    Scheme::Dop853 { tolerance }
}

/// Measures all of it, or what can be begun before the deadline.
pub(super) fn climb(setup: &Setup, reference: &Reference, deadline: Instant) -> Result<Vec<Rung>, Failure> {
    let bar = progress();
    let mut rungs = Vec::new();
    for way in METHODS {
        // Without constraints there is nothing to project.
        if setup.text.constraints.is_empty() && way.projection != Projection::Mass {
            continue;
        }
        let settings: Vec<Setting> = match way.formula {
            Formula::Fixed(_) => {
                (0..HALVINGS).map(|k| Setting::Step(COARSEST * setup.step() / 2.0_f64.powi(k))).collect()
            }
            Formula::Adaptive(_) => TOLERANCES.map(|k| Setting::Tolerance(10.0_f64.powi(-k))).collect(),
        };
        let mut best = f64::INFINITY;
        let mut idle = 0;
        for setting in settings {
            if Instant::now() >= deadline {
                break;
            }
            if let Some(bar) = &bar {
                bar.set_message(format!("{}, {}", way.name, setting.words()));
                bar.tick();
            }
            let rung = rung(setup, reference, way, setting);
            if let Ok(measured) = &rung.result {
                // Where rounding errors or the reference's own are reached, more work brings nothing.
                idle = if measured.errors.position < 0.5 * best { 0 } else { idle + 1 };
                best = best.min(measured.errors.position);
            }
            rungs.push(rung);
            if idle >= 2 && best < FINE {
                break;
            }
        }
    }
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    if rungs.iter().all(|rung| rung.result.is_err()) {
        let reason = rungs.first().and_then(|rung| rung.result.as_ref().err().cloned());
        return Err(Failure::Run(format!("error: no method gets to the end: {}", reason.unwrap_or_default())));
    }
    Ok(rungs)
}

fn rung(setup: &Setup, reference: &Reference, way: Way, setting: Setting) -> Rung {
    let (scheme, step) = match (way.formula, setting) {
        (Formula::Adaptive(scheme), Setting::Tolerance(tolerance) | Setting::Step(tolerance)) => {
            (scheme(tolerance), setup.step())
        }
        (Formula::Fixed(scheme), Setting::Step(step) | Setting::Tolerance(step)) => (scheme, step),
    };
    let trial = Trial { method: Method { scheme, projection: way.projection, ..setup.method }, step };
    let times = reference.times();
    let measured = setup.scene.measure(&setup.replace(), &trial, &times, PATIENCE);
    let result = measured.map(|measurement| Measured {
        estimate: estimate(setup, &trial, times[times.len() - 1]),
        ..compared(setup, reference, &measurement)
    });
    let result = result.map_err(|reason| words::no_start(&reason, &setup.description, &setup.text, &setup.path));
    Rung { method: way.name, setting, result }
}

fn compared(setup: &Setup, reference: &Reference, measurement: &Measurement) -> Measured {
    let quarter = |part: usize| measurement.seconds[(measurement.seconds.len() - 1) * part / 4];
    let states = &measurement.states;
    Measured {
        steps: measurement.counts.accepted,
        evaluations: measurement.counts.evaluations,
        seconds: [1, 2, 3].map(quarter),
        errors: Errors::between(&setup.text, states, &reference.states),
        residual: states.iter().map(|state| state.residual).fold(0.0, f64::max),
        energy_drift: states.iter().map(|state| (state.energy - measurement.energy).abs()).fold(0.0, f64::max),
        estimate: None,
    }
}

/// What `qrm run` would say of the error at the last time.
fn estimate(setup: &Setup, trial: &Trial, end: f64) -> Option<f64> {
    let request =
        Request { method: trial.method, step: Some(trial.step), end: Some(End::Time(end)), estimate_error: true };
    setup.scene.simulate(&setup.replace(), &request, &mut ()).ok()?.estimated_error
}

fn progress() -> Option<ProgressBar> {
    if !std::io::stderr().is_terminal() {
        return None;
    }
    let style = ProgressStyle::with_template("{spinner} {elapsed} {msg}").ok()?;
    Some(ProgressBar::new_spinner().with_style(style))
}

impl Setting {
    pub(super) fn words(self) -> String {
        match self {
            Self::Step(step) => format!("step {}", words::seconds(step)),
            Self::Tolerance(tolerance) => format!("tolerance {tolerance:e}"),
        }
    }
}
