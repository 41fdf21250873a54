//! Every method at a ladder of steps or tolerances.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::super::progress::interrupted;
use super::super::reference::{Errors, Reference};
use super::super::setup::Setup;
use super::super::{Failure, words};
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
    pub(super) energy_drift: Option<f64>,
    /// What a plain run says of its own error at the end.
    pub(super) estimate: Option<f64>,
}

/// Each rung is repeated at least so often, and for so long.
const PATIENCE: Patience = Patience { least: 7, time: Duration::from_millis(15) };
/// Steps go from so many times that of the scene downward by halves.
const COARSEST: f64 = 8.0;
const HALVINGS: i32 = 11;
/// Above this error, and above so many times the reference's own, it may be chance that a smaller step brought nothing.
const FINE: f64 = 1e-9;
const NEAR: f64 = 30.0;
/// Tolerances go from one power of ten to another.
const TOLERANCES: std::ops::RangeInclusive<i32> = 3..=14;

/// The methods, with the projections that make a difference.
const METHODS: [Way; 8] = [
    Way { name: "document", formula: Formula::Fixed(Scheme::Document), projection: Projection::Euclidean },
    Way { name: "rk4, no projection", formula: Formula::Fixed(Scheme::Rk4), projection: Projection::None },
    Way { name: "rk4, Euclidean", formula: Formula::Fixed(Scheme::Rk4), projection: Projection::Euclidean },
    Way { name: "rk4, mass metric", formula: Formula::Fixed(Scheme::Rk4), projection: Projection::Mass },
    Way { name: "dopri5, mass metric", formula: Formula::Adaptive(dopri5), projection: Projection::Mass },
    Way { name: "dop853, mass metric", formula: Formula::Adaptive(dop853), projection: Projection::Mass },
    Way { name: "rodas, mass metric", formula: Formula::Adaptive(rodas), projection: Projection::Mass },
    Way { name: "auto, mass metric", formula: Formula::Adaptive(auto), projection: Projection::Mass },
];
/// How many of them do without the derivatives of a scene that is said to be stiff.
const PLAIN: usize = 6;

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

fn rodas(tolerance: f64) -> Scheme {
    Scheme::Rodas { tolerance }
}

fn auto(tolerance: f64) -> Scheme {
    Scheme::Auto { tolerance }
}

/// What was measured.
pub(super) struct Climb {
    /// Method by method, from coarse to fine.
    pub(super) rungs: Vec<Rung>,
    /// What ended it early.
    pub(super) cut: Option<Cut>,
}

/// What ends measurements early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// There was no time left for finer steps.
    Budget,
    /// The user wanted it to end.
    Interrupted,
}

/// A method on its way to finer steps.
struct Climber {
    way: Way,
    settings: std::vec::IntoIter<Setting>,
    rungs: Vec<Rung>,
    /// How long the last rung took.
    took: Duration,
    best: f64,
    /// Rungs in a row that brought nothing.
    idle: usize,
}

/// Measures all of it, or what can be done before the deadline: each method at its coarsest setting, then each at the next,
/// so that none is forgotten. The first rung is measured in any case.
pub(super) fn climb(setup: &Setup, reference: &Reference, deadline: Instant) -> Result<Climb, Failure> {
    let bar = progress();
    let floor = reference.uncertainty.position;
    // Without constraints there is nothing to project.
    let has_constraints = !setup.text.constraints.is_empty();
    let count = if setup.text.run.stiff { METHODS.len() } else { PLAIN };
    let ways = METHODS.into_iter().take(count).filter(|way| has_constraints || way.projection == Projection::Mass);
    let mut climbers: Vec<Climber> = ways.map(|way| Climber::new(setup, way)).collect();
    let mut cut = None;
    let mut is_first = true;
    while climbers.iter().any(|climber| climber.settings.len() > 0) {
        for climber in &mut climbers {
            if interrupted() {
                cut = Some(Cut::Interrupted);
                climber.stop();
            }
            let Some(setting) = climber.settings.next() else { continue };
            // A step half as long takes twice the time.
            if !is_first && Instant::now() + 2 * climber.took >= deadline {
                cut = cut.or(Some(Cut::Budget));
                climber.stop();
                continue;
            }
            if let Some(bar) = &bar {
                bar.set_message(format!("{}, {}", climber.way.name, setting.words()));
                bar.tick();
            }
            let begun = Instant::now();
            let rung = rung(setup, reference, climber.way, setting);
            climber.take(rung, begun.elapsed(), floor);
            is_first = false;
        }
    }
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    let rungs: Vec<Rung> = climbers.into_iter().flat_map(|climber| climber.rungs).collect();
    if rungs.is_empty() {
        return Err(Failure::Run("error: interrupted before anything was measured".to_owned()));
    }
    if rungs.iter().all(|rung| rung.result.is_err()) {
        let reason = rungs.first().and_then(|rung| rung.result.as_ref().err().cloned());
        return Err(Failure::Run(format!("error: no method gets to the end: {}", reason.unwrap_or_default())));
    }
    Ok(Climb { rungs, cut })
}

impl Climber {
    fn new(setup: &Setup, way: Way) -> Self {
        let settings: Vec<Setting> = match way.formula {
            Formula::Fixed(_) => {
                (0..HALVINGS).map(|k| Setting::Step(COARSEST * setup.step() / 2.0_f64.powi(k))).collect()
            }
            Formula::Adaptive(_) => TOLERANCES.map(|k| Setting::Tolerance(10.0_f64.powi(-k))).collect(),
        };
        let settings = settings.into_iter();
        Self { way, settings, rungs: Vec::new(), took: Duration::ZERO, best: f64::INFINITY, idle: 0 }
    }

    fn stop(&mut self) {
        self.settings = Vec::new().into_iter();
    }

    fn take(&mut self, rung: Rung, took: Duration, floor: f64) {
        self.took = took;
        if let Ok(measured) = &rung.result {
            // Where rounding errors or the reference's own are reached, more work brings nothing.
            self.idle = if measured.errors.position < 0.5 * self.best { 0 } else { self.idle + 1 };
            self.best = self.best.min(measured.errors.position);
        }
        self.rungs.push(rung);
        let patience = if self.best < NEAR * floor { 2 } else { 4 };
        if self.idle >= patience && self.best < FINE {
            self.stop();
        }
    }
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
    let result = result.map_err(|reason| words::no_way(&reason, &setup.description, &setup.text, &setup.path));
    Rung { method: way.name, setting, result }
}

fn compared(setup: &Setup, reference: &Reference, measurement: &Measurement) -> Measured {
    let quarter = |part: usize| measurement.seconds[(measurement.seconds.len() - 1) * part / 4];
    let states = &measurement.states;
    let is_conservative = states.iter().all(|state| state.power == 0.0);
    Measured {
        steps: measurement.counts.accepted,
        evaluations: measurement.counts.evaluations,
        seconds: [1, 2, 3].map(quarter),
        errors: Errors::between(&setup.text, states, &reference.states),
        residual: states.iter().map(|state| state.residual).fold(0.0, f64::max),
        energy_drift: is_conservative
            .then(|| states.iter().map(|state| (state.energy - measurement.energy).abs()).fold(0.0, f64::max)),
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
