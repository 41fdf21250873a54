//! Every method with a series of steps or tolerances.

use std::time::{Duration, Instant};

use qrm_sim::analysis::{Measurement, Repetitions, Trial, measure};
use qrm_sim::columns::{Column, Kind};
use qrm_sim::integrate::{METHODS, Method, MethodSettings};
use qrm_sim::run::{End, Request, simulate};
use qrm_sim::solve::{Linearization, Projection};

use crate::error::{Error, Message};
use crate::format::seconds;
use crate::methods::series_name;
use crate::progress::{Progress, interrupted};
use crate::reference::{Errors, Reference, ReferenceKind};
use crate::setup::Setup;

/// The measurements of a scene, and their reference.
pub(crate) struct Study {
    pub(super) reference: Reference,
    /// The column whose errors are measured, instead of those of the coordinates.
    pub(super) of: Option<Column>,
    /// Method by method, from coarse to fine.
    pub(super) samples: Vec<Sample>,
    /// The reason why there are no more measurements.
    pub(super) cut: Option<Cut>,
}

/// A method with one step or tolerance.
pub(super) struct Sample {
    /// The method with its projection.
    pub(super) method: String,
    pub(super) setting: Setting,
    /// The measurement, or the reason why the method did not reach the end.
    pub(super) result: Result<Measured, Message>,
}

/// The setting that controls the accuracy of a method.
#[derive(Clone, Copy, Debug)]
pub(super) enum Setting {
    /// Length of the steps.
    Step(f64),
    /// Largest error of a step.
    Tolerance(f64),
}

/// A measurement.
pub(super) struct Measured {
    pub(super) steps: u64,
    pub(super) evaluations: u64,
    /// The lower quartile, the median and the upper quartile of the run times, in s.
    pub(super) seconds: [f64; 3],
    pub(super) errors: Errors,
    pub(super) residual: f64,
    pub(super) energy_drift: Option<f64>,
    /// The estimated error at the end from an ordinary run.
    pub(super) estimate: Option<f64>,
}

/// The reason for an early end of the measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// There was no time left for finer steps.
    Budget,
    /// The user interrupted the measurements.
    Interrupted,
}

/// The repetitions of each measurement.
const REPETITIONS: Repetitions = Repetitions { least: 7, time: Duration::from_millis(15) };
/// The longest steps, in steps of the scene; each further one is half as long.
const COARSEST: f64 = 8.0;
const HALVINGS: i32 = 11;
/// The error, relative to the column or absolute for coordinates, above which a smaller step may fail to reduce the
/// error by chance. The error must also exceed a multiple of the reference's own.
const FINE: f64 = 1e-9;
const NEAR: f64 = 30.0;
/// The tolerances are negative powers of ten with these exponents.
const TOLERANCES: std::ops::RangeInclusive<i32> = 3..=14;

impl Study {
    /// Measures until the deadline: each method with its coarsest setting, then each with the next one, so that none is
    /// left out. The first measurement is always made.
    pub(crate) fn new(
        setup: &Setup,
        at: &[String],
        of: Option<Column>,
        reference: Option<ReferenceKind>,
        deadline: Instant,
    ) -> Result<Self, Error> {
        let reference = Reference::find(setup, at, of.as_ref().map(|of| of.kind), reference)?;
        let (samples, cut) = run_study(setup, &reference, deadline);
        if samples.is_empty() {
            return Err(Error::run("interrupted before anything was measured"));
        }
        match &samples[0].result {
            Err(reason) if samples.iter().all(|sample| sample.result.is_err()) => match cut {
                None => Err(reason.clone().after("no method gets to the end: ").into()),
                Some(Cut::Interrupted) => Err(Error::run("interrupted before anything got to the end")),
                Some(Cut::Budget) => {
                    let text = "nothing that was tried gets to the end, and finer steps were not measured";
                    Err(Error::run(text).help("give more time with `--budget`"))
                }
            },
            _ => Ok(Self { reference, of, samples, cut }),
        }
    }

    /// The source of the exact values.
    pub(crate) fn origin(&self) -> String {
        format!("{}, uncertain by {:.1e}", self.reference.origin, self.reference.uncertainty.judged())
    }

    pub(super) fn is_interrupted(&self) -> bool {
        self.cut == Some(Cut::Interrupted)
    }
}

/// A method with a projection, measured with finer and finer settings.
struct Series {
    method: &'static Method,
    projection: Projection,
    settings: std::vec::IntoIter<Setting>,
    samples: Vec<Sample>,
    /// The time for the last sample.
    took: Duration,
    best: f64,
    /// The number of consecutive samples without improvement.
    idle: usize,
}

fn run_study(setup: &Setup, reference: &Reference, deadline: Instant) -> (Vec<Sample>, Option<Cut>) {
    let spinner = Progress::spinner();
    let floor = reference.uncertainty.judged();
    let size = reference.size();
    let mut all = all_series(setup);
    let mut cut = None;
    let mut is_first = true;
    while all.iter().any(|series| series.settings.len() > 0) {
        for series in &mut all {
            if interrupted() {
                cut = Some(Cut::Interrupted);
                series.stop();
            }
            let Some(setting) = series.settings.next() else { continue };
            // Half the step takes twice the time.
            if !is_first && Instant::now() + 2 * series.took >= deadline {
                cut = cut.or(Some(Cut::Budget));
                series.stop();
                continue;
            }
            spinner.show(format!("{}, {}", series.name(), setting.text()));
            let begun = Instant::now();
            let sample = series.measure(setup, reference, setting);
            series.take(sample, begun.elapsed(), [floor, size]);
            is_first = false;
        }
    }
    (all.into_iter().flat_map(|series| series.samples).collect(), cut)
}

/// The methods that differ in this scene, with fixed steps by each projection.
fn all_series(setup: &Setup) -> Vec<Series> {
    let mut all = Vec::new();
    let is_linearized = Linearization::is_known(&*setup.mechanism());
    for method in METHODS.into_iter().filter(|method| is_linearized || !method.is_for_stiff) {
        // Without constraints there is nothing to project.
        if !method.is_adaptive() && !setup.scene.constraints.is_empty() {
            all.extend(Projection::ALL.map(|(_, projection)| Series::new(setup, method, projection)));
        } else {
            all.push(Series::new(setup, method, Projection::default()));
        }
    }
    all
}

impl Series {
    fn new(setup: &Setup, method: &'static Method, projection: Projection) -> Self {
        let settings: Vec<Setting> = if method.is_adaptive() {
            TOLERANCES.map(|k| Setting::Tolerance(10.0_f64.powi(-k))).collect()
        } else {
            (0..HALVINGS).map(|k| Setting::Step(COARSEST * setup.step() / 2.0_f64.powi(k))).collect()
        };
        let settings = settings.into_iter();
        Self { method, projection, settings, samples: Vec::new(), took: Duration::ZERO, best: f64::INFINITY, idle: 0 }
    }

    fn name(&self) -> String {
        series_name(self.method, self.projection)
    }

    fn stop(&mut self) {
        self.settings = Vec::new().into_iter();
    }

    fn take(&mut self, sample: Sample, took: Duration, [floor, size]: [f64; 2]) {
        self.took = took;
        if let Ok(measured) = &sample.result {
            // Once rounding errors or those of the reference are reached, finer settings do not help.
            let error = measured.errors.judged();
            self.idle = if error < 0.5 * self.best { 0 } else { self.idle + 1 };
            self.best = self.best.min(error);
        }
        self.samples.push(sample);
        let patience = if self.best < NEAR * floor { 2 } else { 4 };
        if self.idle >= patience && self.best < FINE * size {
            self.stop();
        }
    }

    fn measure(&self, setup: &Setup, reference: &Reference, setting: Setting) -> Sample {
        let (tolerance, step) = match setting {
            Setting::Tolerance(tolerance) => (tolerance, setup.step()),
            Setting::Step(step) => (setup.settings.tolerance, step),
        };
        let settings = MethodSettings { method: self.method, tolerance, projection: self.projection, ..setup.settings };
        let trial = Trial { settings, step };
        let times = reference.times();
        let measured = measure(&*setup.mechanism(), &trial, &times, REPETITIONS);
        let result = measured.map_err(|reason| setup.no_end(&reason)).map(|measurement| Measured {
            estimate: estimate(setup, reference.of, &trial, times[times.len() - 1]),
            ..compare(setup, reference, &measurement)
        });
        Sample { method: self.name(), setting, result }
    }
}

fn compare(setup: &Setup, reference: &Reference, measurement: &Measurement) -> Measured {
    let quarter = |part: usize| measurement.seconds[(measurement.seconds.len() - 1) * part / 4];
    let states = &measurement.states;
    let is_conservative = states.iter().all(|state| state.power == 0.0);
    Measured {
        steps: measurement.counts.accepted,
        evaluations: measurement.counts.evaluations,
        seconds: [1, 2, 3].map(quarter),
        errors: Errors::between(&setup.scene, reference.of, states, &reference.states),
        residual: states.iter().map(|state| state.residual).fold(0.0, f64::max),
        energy_drift: is_conservative
            .then(|| states.iter().map(|state| (state.energy - measurement.energy).abs()).fold(0.0, f64::max)),
        estimate: None,
    }
}

/// The error at the last time, estimated like in `qrm run`.
fn estimate(setup: &Setup, of: Option<Kind>, trial: &Trial, end: f64) -> Option<f64> {
    let request = Request {
        settings: trial.settings,
        step: Some(trial.step),
        end: Some(End::Time(end)),
        estimate_error: true,
        ..Request::default()
    };
    let outcome = simulate(&*setup.mechanism(), &request, &mut ()).ok()?;
    match of {
        None => outcome.estimated_error(),
        Some(kind) => Some(outcome.errors?.column(kind)?.largest),
    }
}

impl Setting {
    pub(super) fn text(self) -> String {
        match self {
            Self::Step(step) => format!("step {}", seconds(step)),
            Self::Tolerance(tolerance) => format!("tolerance {tolerance:e}"),
        }
    }
}
