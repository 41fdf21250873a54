//! What results are compared with: something that does not share their errors.

use std::time::Duration;

use qrm_codegen::evaluate::constant;
use qrm_codegen::scene::Known;

use super::super::arguments::ReferenceName;
use super::super::setup::Setup;
use super::super::{Failure, words};
use super::errors::Errors;
use crate::energy_integral::{NoIntegral, PANELS};
use crate::measure::{Patience, StateAt, Trial};
use crate::motion::{Method, Scheme};

/// States that are known, and how well.
pub(super) struct Reference {
    /// Where they are from.
    pub(super) origin: String,
    /// The states, in the order of time.
    pub(super) states: Vec<StateAt>,
    /// By how much they may be off.
    pub(super) uncertainty: Errors,
}

/// One run of a method is enough.
pub(super) const ONCE: Patience = Patience { least: 1, time: Duration::ZERO };

/// Two tolerances whose results tell each other's errors.
const TIGHT: [f64; 2] = [1e-14, 1e-13];

impl Reference {
    /// The one that is asked for, or the most independent one that there is.
    pub(super) fn find(setup: &Setup, times: &[f64], asked: Option<ReferenceName>) -> Result<Self, Failure> {
        let may_be = |name: ReferenceName| asked.is_none_or(|asked| asked == name);
        if may_be(ReferenceName::Energy) {
            match Self::of_energy(setup, times) {
                Ok(reference) => return Ok(reference),
                Err(reason) if asked.is_some() => return Err(no_integral(reason)),
                Err(_) => {}
            }
        }
        if may_be(ReferenceName::Scene) {
            match Self::of_scene(setup) {
                Some(reference) => return Ok(reference),
                None if asked.is_some() => {
                    return Err(Failure::Use(
                        "error: the scene has no values in [reference] that hold for these parameters\n  \
                         = help: add some, or leave `--set` away"
                            .to_owned(),
                    ));
                }
                None => {}
            }
        }
        Self::of_run(setup, times)
    }

    /// States from the energy integral, whose rounding errors two divisions of the way tell.
    fn of_energy(setup: &Setup, times: &[f64]) -> Result<Self, NoIntegral> {
        let [states, others] = PANELS.map(|panels| setup.scene.exact(&setup.replace(), times, panels));
        let (states, others) = (states?, others?);
        let uncertainty = Errors::between(&setup.text, &states, &others).max(rounding(&states));
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
            measured
                .map_err(|reason| Failure::Use(words::no_start(&reason, &setup.description, &setup.text, &setup.path)))
        };
        let (states, others) = (run(TIGHT[0])?.states, run(TIGHT[1])?.states);
        let uncertainty = Errors::between(&setup.text, &states, &others).max(rounding(&states));
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
            NoIntegral::NotConservative => "some load has no potential",
            NoIntegral::TurnsBack => "the motion turns back or stands still on the way, or its way is not found",
        }
    ))
}

/// A few units in the last place, which no comparison sees.
fn rounding(states: &[StateAt]) -> Errors {
    let size = |values: fn(&StateAt) -> &[f64]| {
        let all = states.iter().flat_map(values).fold(0.0, |most: f64, value| most.max(value.abs()));
        2.0 * f64::EPSILON * all
    };
    Errors { position: size(|s| &s.q), rate: size(|s| &s.qd), force: size(|s| &s.outputs) }
}
