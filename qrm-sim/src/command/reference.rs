//! What results are compared with: something that does not share their errors.

mod errors;

use std::time::Duration;

use qrm_scene::evaluate::constant;
use qrm_scene::scene::Known;

use super::arguments::ReferenceName;
use super::progress::Progress;
use super::setup::Setup;
use super::{Failure, settings, words};
use crate::energy_integral::{NoIntegral, PANELS};
use crate::measure::{Patience, StateAt, Trial};
use crate::motion::{Method, Scheme};
use crate::outcome::Status;
pub(super) use errors::Errors;

/// States that are known, and how well.
pub(super) struct Reference {
    /// Where they are from.
    pub(super) origin: String,
    /// The states, in the order of time.
    pub(super) states: Vec<StateAt>,
    /// By how much they may be off.
    pub(super) uncertainty: Errors,
}

/// How many times are compared where none are asked for.
const TIMES: usize = 8;

/// One run of a method is enough.
const ONCE: Patience = Patience { least: 1, time: Duration::ZERO };

/// An energy integral as certain as this needs no comparison with a run.
const ALMOST_EXACT: f64 = 1e-12;

/// Two tolerances whose results tell each other's errors.
const TIGHT: [f64; 2] = [1e-14, 1e-13];

impl Reference {
    /// The one that is asked for, or the most independent one that there is; values of the scene hold at their own times,
    /// and are left aside where others are asked for.
    pub(super) fn find(setup: &Setup, at: &[String], asked: Option<ReferenceName>) -> Result<Self, Failure> {
        match asked {
            Some(ReferenceName::Energy) => Self::of_energy(setup, &times(setup, at)?).map_err(no_integral),
            Some(ReferenceName::Scene) if !at.is_empty() => Err(Failure::Use(
                "error: values in [reference] hold at their own times\n  \
                 = help: leave `--at` away, or compare with `--reference run`"
                    .to_owned(),
            )),
            Some(ReferenceName::Scene) => Self::of_scene(setup).ok_or_else(|| {
                Failure::Use(
                    "error: the scene has no values in [reference] that hold for these parameters\n  \
                     = help: add some, or leave `--set` away"
                        .to_owned(),
                )
            }),
            Some(ReferenceName::Run) => Self::of_run(setup, &times(setup, at)?),
            None => Self::best(setup, at),
        }
    }

    /// The energy integral, unless it is less certain than a run: it is where the motion is about to stand still.
    fn best(setup: &Setup, at: &[String]) -> Result<Self, Failure> {
        let times = times(setup, at)?;
        match (Self::of_energy(setup, &times), Self::of_scene(setup).filter(|_| at.is_empty())) {
            (Ok(exact), _) if exact.uncertainty.position <= ALMOST_EXACT => Ok(exact),
            (Ok(exact), _) => match Self::of_run(setup, &times) {
                Ok(run) if run.uncertainty.position < exact.uncertainty.position => Ok(run),
                _ => Ok(exact),
            },
            (Err(_), Some(known)) => Ok(known),
            (Err(_), None) => Self::of_run(setup, &times),
        }
    }

    /// States from the energy integral, whose rounding errors two divisions of the way tell.
    fn of_energy(setup: &Setup, times: &[f64]) -> Result<Self, NoIntegral> {
        let [states, others] = PANELS.map(|panels| setup.scene.exact(&setup.replace(), times, panels));
        let (states, others) = (states?, others?);
        let uncertainty = Errors::between(&setup.text, &states, &others).max(rounding(setup, &states));
        let origin = "the energy integral, with positions from the loops and time by quadrature".to_owned();
        Ok(Self { origin, states, uncertainty })
    }

    /// Values that the scene holds.
    fn of_scene(setup: &Setup) -> Option<Self> {
        // They hold for the scene as it stands.
        if setup.is_changed() {
            return None;
        }
        let scene = &setup.text;
        let parameters = setup.parameters();
        let mut uncertainty = Errors::default();
        let mut states: Vec<StateAt> = Vec::new();
        let unknown = |t: f64| StateAt {
            t,
            q: vec![f64::NAN; scene.coordinates.len()],
            qd: vec![f64::NAN; scene.coordinates.len()],
            outputs: vec![f64::NAN; scene.outputs.len()],
            residual: 0.0,
            energy: f64::NAN,
            power: f64::NAN,
        };
        for reference in &scene.references {
            let t = constant(&reference.t, &parameters);
            // Several entries may speak of one time.
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
        (!states.is_empty()).then_some(Self { origin, states, uncertainty })
    }

    /// The method of order 8 at two tight tolerances.
    fn of_run(setup: &Setup, times: &[f64]) -> Result<Self, Failure> {
        let run = |tolerance: f64| {
            let method = Method { scheme: Scheme::Dop853 { tolerance }, ..setup.method };
            let trial = Trial { method, step: times[times.len() - 1] };
            let measured = setup.scene.measure(&setup.replace(), &trial, times, ONCE);
            measured.map_err(|reason| {
                Failure::Run(format!(
                    "error: there is no reference: {}",
                    words::no_way(&reason, &setup.description, &setup.text, &setup.path)
                ))
            })
        };
        let (states, others) = (run(TIGHT[0])?.states, run(TIGHT[1])?.states);
        let uncertainty = Errors::between(&setup.text, &states, &others).max(rounding(setup, &states));
        let [finer, coarser] = TIGHT;
        let origin = format!("DOP853 at a tolerance of {finer:e}, uncertain by its difference from one at {coarser:e}");
        Ok(Self { origin, states, uncertainty })
    }

    /// The times of the states.
    pub(super) fn times(&self) -> Vec<f64> {
        self.states.iter().map(|state| state.t).collect()
    }
}

fn no_integral(reason: NoIntegral) -> Failure {
    Failure::Use(format!(
        "error: there is no energy integral: {}",
        match reason {
            NoIntegral::Freedoms => "the mechanism has another number of freedoms than one",
            NoIntegral::Driven => "a constraint depends on time",
            NoIntegral::NotConservative => "some load has no potential",
            NoIntegral::TurnsBack => "the motion turns back or stands still on the way, or its way is not found",
        }
    ))
}

/// A few units in the last place, which no comparison sees.
fn rounding(setup: &Setup, states: &[StateAt]) -> Errors {
    let zero = |state: &StateAt| StateAt {
        q: vec![0.0; state.q.len()],
        qd: vec![0.0; state.qd.len()],
        outputs: vec![0.0; state.outputs.len()],
        ..*state
    };
    let zeros: Vec<StateAt> = states.iter().map(zero).collect();
    Errors::between(&setup.text, states, &zeros).times(8.0 * f64::EPSILON)
}

/// The times to compare at, rising: those that are asked for, or some up to the end of the scene's own run.
fn times(setup: &Setup, asked: &[String]) -> Result<Vec<f64>, Failure> {
    if !asked.is_empty() {
        let mut times = asked.iter().map(|text| settings::positive("--at", text)).collect::<Result<Vec<_>, _>>()?;
        times.sort_by(f64::total_cmp);
        times.dedup();
        return Ok(times);
    }
    let outcome = setup.simulate(false, &mut Progress::new())?;
    let end = outcome.end_time;
    if matches!(outcome.status, Status::Interrupted) {
        return Err(Failure::Run(format!("error: interrupted at t = {end} s")));
    }
    if !(end > 0.0) {
        return Err(Failure::Run("error: the run ends where it begins: there is nothing to measure".to_owned()));
    }
    Ok((1..=TIMES).map(|i| end * i as f64 / TIMES as f64).collect())
}
