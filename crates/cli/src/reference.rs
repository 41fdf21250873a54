//! The states to which results are compared; they do not share the errors of the results.

mod errors;

use std::time::Duration;

use clap::ValueEnum;
use qrm_scene::evaluate::constant;
use qrm_scene::scene::Known;

use crate::error::Error;
use crate::options::positive;
use crate::progress::Progress;
use crate::setup::Setup;
pub(crate) use errors::Errors;

/// The source of exact values.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReferenceKind {
    /// The energy integral of a conservative motion with one degree of freedom that does not turn back
    Energy,
    /// Values in the scene's [reference], if no parameter is changed
    Scene,
    /// Extrapolation in double-double numbers at two tight tolerances; failing that, the method of order 8
    Run,
}
use qrm_sim::analysis::{
    NoEnergyIntegral, PANELS, Repetitions, StateAt, Trial, exact_states, measure, reference_states,
};
use qrm_sim::columns::Kind;
use qrm_sim::integrate::{DOP853, MethodSettings};
use qrm_sim::run::Status;

/// Reference states and their accuracy.
pub(crate) struct Reference {
    /// The source of the states.
    pub(crate) origin: String,
    /// The states, in the order of time.
    pub(crate) states: Vec<StateAt>,
    /// Upper bounds of their errors.
    pub(crate) uncertainty: Errors,
    /// The additionally compared column.
    pub(crate) of: Option<Kind>,
}

/// The default number of times for the comparison.
const TIMES: usize = 8;

/// A single run of a method suffices.
const ONCE: Repetitions = Repetitions { least: 1, time: Duration::ZERO };

/// The uncertainty of an energy integral below which no other reference is tried.
const ALMOST_EXACT: f64 = 1e-12;

/// Two tolerances in double precision; the difference of their results shows the errors.
const TIGHT: [f64; 2] = [1e-14, 1e-13];

/// Two tolerances in double-double precision; the difference of their results shows the errors.
const TIGHTEST: [f64; 2] = [1e-22, 1e-20];

impl Reference {
    /// Finds the requested reference, or the most independent one available. The scene's reference values are valid at
    /// their own times only.
    pub(crate) fn find(
        setup: &Setup,
        at: &[String],
        of: Option<Kind>,
        asked: Option<ReferenceKind>,
    ) -> Result<Self, Error> {
        match asked {
            Some(ReferenceKind::Energy) => {
                Self::from_energy_integral(setup, &times(setup, at)?, of).map_err(no_integral)
            }
            Some(ReferenceKind::Scene) if !at.is_empty() => {
                Err(Error::usage("values in [reference] hold at their own times")
                    .help("omit `--at`, or compare with `--reference run`"))
            }
            Some(ReferenceKind::Scene) => Self::from_scene(setup, of).ok_or_else(|| {
                Error::usage("the scene has no values in [reference] that hold for these parameters")
                    .help("add some, or omit `--set`")
            }),
            Some(ReferenceKind::Run) => Self::from_run(setup, &times(setup, at)?, of),
            None => Self::best(setup, at, of),
        }
    }

    /// The energy integral, unless it is less accurate than a run: it is so where the motion nearly stops.
    fn best(setup: &Setup, at: &[String], of: Option<Kind>) -> Result<Self, Error> {
        let times = times(setup, at)?;
        // Scenes have values of some columns.
        let from_scene = || Self::from_scene(setup, of).filter(|_| at.is_empty() && of.is_none());
        match (Self::from_energy_integral(setup, &times, of), from_scene()) {
            (Ok(exact), _) if exact.uncertainty.position <= ALMOST_EXACT => Ok(exact),
            (Ok(exact), _) => match Self::from_run(setup, &times, of) {
                Ok(run) if run.uncertainty.position < exact.uncertainty.position => Ok(run),
                _ => Ok(exact),
            },
            (Err(_), Some(known)) => Ok(known),
            (Err(_), None) => Self::from_run(setup, &times, of),
        }
    }

    /// Computes states from the energy integral; two different numbers of panels show the rounding errors.
    fn from_energy_integral(setup: &Setup, times: &[f64], of: Option<Kind>) -> Result<Self, NoEnergyIntegral> {
        let [states, others] = PANELS.map(|panels| exact_states(&*setup.mechanism(), times, panels));
        let (states, others) = (states?, others?);
        let uncertainty = Errors::between(&setup.scene, of, &states, &others).max(rounding(setup, of, &states));
        let origin = "the energy integral, with positions from the loops and time by quadrature".to_owned();
        Ok(Self { origin, states, uncertainty, of })
    }

    /// The reference values of the scene.
    fn from_scene(setup: &Setup, of: Option<Kind>) -> Option<Self> {
        // They are valid for the unchanged scene only.
        if setup.is_changed() {
            return None;
        }
        let scene = &setup.scene;
        let parameters = setup.parameters();
        let mut uncertainty = Errors::default();
        let mut states: Vec<StateAt> = Vec::new();
        let unknown = |t: f64| StateAt {
            t,
            q: vec![f64::NAN; scene.coordinates.len()],
            qd: vec![f64::NAN; scene.coordinates.len()],
            qdd: Vec::new(),
            multipliers: Vec::new(),
            outputs: vec![f64::NAN; scene.outputs.len()],
            residual: 0.0,
            energy: f64::NAN,
            power: f64::NAN,
        };
        for reference in &scene.references {
            let t = constant(&reference.t, &parameters);
            // Several entries may have the same time.
            let place = states.iter().position(|state| state.t == t).unwrap_or_else(|| {
                states.push(unknown(t));
                states.len() - 1
            });
            let state = &mut states[place];
            let accuracy = constant(&reference.accuracy, &parameters);
            for (known, value) in &reference.values {
                let (place, error) = match *known {
                    Known::Coordinate(i) => (&mut state.q[i], &mut uncertainty.position),
                    Known::Rate(i) => (&mut state.qd[i], &mut uncertainty.rate),
                    Known::Output(i) => (&mut state.outputs[i], &mut uncertainty.force),
                };
                *place = constant(value, &parameters);
                *error = error.max(accuracy);
            }
        }
        states.sort_by(|a, b| a.t.total_cmp(&b.t));
        let names: Vec<&str> = scene.references.iter().map(|reference| reference.name.as_str()).collect();
        let origin = format!("the values that the scene holds in [reference]: {}", names.join(", "));
        (!states.is_empty()).then_some(Self { origin, states, uncertainty, of })
    }

    /// Computes a run in double-double precision, or by the method of order 8 in double precision if that fails.
    fn from_run(setup: &Setup, times: &[f64], of: Option<Kind>) -> Result<Self, Error> {
        if let Some(reference) = Self::from_double_doubles(setup, times, of) {
            return Ok(reference);
        }
        let run = |tolerance: f64| {
            let settings = MethodSettings { method: DOP853, tolerance, ..setup.settings };
            let trial = Trial { settings, step: times[times.len() - 1] };
            let measured = measure(&*setup.mechanism(), &trial, times, ONCE);
            measured.map_err(|reason| -> Error { setup.no_end(&reason).after("there is no reference: ").into() })
        };
        let runs = [run(TIGHT[0])?.states, run(TIGHT[1])?.states];
        Ok(Self::from_two_runs(setup, of, "DOP853", TIGHT, runs))
    }

    /// Extrapolation in double-double precision; `None` if the motion is too long or not smooth enough.
    fn from_double_doubles(setup: &Setup, times: &[f64], of: Option<Kind>) -> Option<Self> {
        let run = |tolerance| -> Option<Vec<StateAt>> {
            let states = reference_states(setup.model, &setup.replace(), times, tolerance).ok()?;
            Some(states.into_iter().map(|state| state.rounded).collect())
        };
        let runs = [run(TIGHTEST[0])?, run(TIGHTEST[1])?];
        Some(Self::from_two_runs(setup, of, "extrapolation in double-double numbers", TIGHTEST, runs))
    }

    /// The finer of two runs; its uncertainty is their difference.
    fn from_two_runs(
        setup: &Setup,
        of: Option<Kind>,
        method: &str,
        [finer, coarser]: [f64; 2],
        [states, others]: [Vec<StateAt>; 2],
    ) -> Self {
        let uncertainty = Errors::between(&setup.scene, of, &states, &others).max(rounding(setup, of, &states));
        let origin =
            format!("{method} at a tolerance of {finer:e}, uncertain by its difference from one at {coarser:e}");
        Self { origin, states, uncertainty, of }
    }

    /// The size of the requested column, as a power of ten; 1 for coordinates.
    pub(crate) fn size(&self) -> f64 {
        let Some(kind) = self.of else { return 1.0 };
        let largest = self.states.iter().map(|state| state.value(kind).abs()).fold(0.0, f64::max);
        if largest > 0.0 && largest.is_finite() { 10.0_f64.powi(largest.log10().ceil() as i32) } else { 1.0 }
    }

    /// The times of the states.
    pub(crate) fn times(&self) -> Vec<f64> {
        self.states.iter().map(|state| state.t).collect()
    }
}

fn no_integral(reason: NoEnergyIntegral) -> Error {
    Error::usage(format!(
        "there is no energy integral: {}",
        match reason {
            NoEnergyIntegral::NotOneGiven => "the scene does not give exactly one coordinate at its start",
            NoEnergyIntegral::Driven => "a constraint depends on time",
            NoEnergyIntegral::NotConservative => "some load has no potential",
            NoEnergyIntegral::TurnsBack => "the motion turns back or stands still on the way, or its path is not found",
        }
    ))
}

/// A few units in the last place, which no comparison can detect.
fn rounding(setup: &Setup, of: Option<Kind>, states: &[StateAt]) -> Errors {
    let zero = |state: &StateAt| StateAt {
        q: vec![0.0; state.q.len()],
        qd: vec![0.0; state.qd.len()],
        qdd: vec![0.0; state.qdd.len()],
        multipliers: vec![0.0; state.multipliers.len()],
        outputs: vec![0.0; state.outputs.len()],
        energy: 0.0,
        ..*state
    };
    let zeros: Vec<StateAt> = states.iter().map(zero).collect();
    Errors::between(&setup.scene, of, states, &zeros).times(8.0 * f64::EPSILON)
}

/// The times of the comparison in increasing order: the requested ones, or some up to the end of the scene's own run.
fn times(setup: &Setup, asked: &[String]) -> Result<Vec<f64>, Error> {
    if !asked.is_empty() {
        let mut times = asked.iter().map(|text| positive("--at", text, "s")).collect::<Result<Vec<_>, _>>()?;
        times.sort_by(f64::total_cmp);
        times.dedup();
        return Ok(times);
    }
    let outcome = setup.simulate(false, &mut Progress::new())?;
    let end = outcome.end_time;
    if matches!(outcome.status, Status::Interrupted) {
        return Err(Error::run(format!("interrupted at t = {end} s")));
    }
    if !(end > 0.0) {
        return Err(match &outcome.status {
            Status::Failed(reason) => {
                setup.step_error(reason).after("no times to compare at: the run broke off at its start: ").into()
            }
            _ => Error::run("the run has zero length: there is nothing to measure"),
        });
    }
    Ok((1..=TIMES).map(|i| end * i as f64 / TIMES as f64).collect())
}
