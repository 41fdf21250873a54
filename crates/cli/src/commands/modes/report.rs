//! Equilibria and modes in numbers.

use std::f64::consts::TAU;

use qrm_core::Mechanism;
use qrm_scene::time_scales::depends_on_time;
use qrm_sim::analysis::{DampedMode, Equilibrium, EquilibriumStability, Mode, ModeKind, Modes};
use serde::Serialize;

use crate::error::Error;
use crate::format::heading;
use crate::output::Named;
use crate::setup::Setup;

/// Equilibria and modes, in the order of `modes.json`.
#[derive(Serialize)]
pub(super) struct ModesReport {
    #[serde(skip)]
    pub(super) heading: String,
    pub(super) scene: &'static str,
    pub(super) equilibrium: EquilibriumEntry,
    pub(super) iterations: u32,
    /// Whether the search from the start leads to the equilibrium.
    pub(super) is_from_start: bool,
    /// The modes without damping.
    pub(super) modes: Vec<ModeEntry>,
    /// Squares of frequencies that are not real.
    pub(super) complex_squares: Vec<[f64; 2]>,
    /// The eigenvalues with damping.
    pub(super) eigenvalues: Vec<EigenvalueEntry>,
    /// The other equilibria that were found.
    pub(super) others: Vec<EquilibriumEntry>,
    pub(super) notes: Vec<String>,
    #[serde(skip)]
    pub(super) parameters: Vec<&'static str>,
    #[serde(skip)]
    pub(super) units: Vec<&'static str>,
}

/// An equilibrium.
#[derive(Serialize)]
pub(super) struct EquilibriumEntry {
    pub(super) coordinates: Named<f64>,
    pub(super) errors: Option<Named<f64>>,
    pub(super) multipliers: Named<f64>,
    /// The largest force that is not balanced.
    pub(super) residual: f64,
    pub(super) stability: &'static str,
    /// The fastest growth of deviations, in 1/s.
    pub(super) growth: Option<f64>,
    /// The lowest natural frequency, in Hz.
    pub(super) lowest_frequency: Option<f64>,
}

/// A mode without damping.
#[derive(Serialize)]
pub(super) struct ModeEntry {
    pub(super) kind: &'static str,
    /// In Hz; zero where the mode does not oscillate.
    pub(super) frequency: f64,
    pub(super) frequency_error: f64,
    /// The frequency in rad/s, or the rate of growth in 1/s.
    pub(super) rate: f64,
    pub(super) rate_error: f64,
    pub(super) square: f64,
    pub(super) square_error: f64,
    pub(super) shape: Named<f64>,
    /// The derivatives of the rate by parameters.
    pub(super) by: Option<Named<f64>>,
}

/// An eigenvalue with damping.
#[derive(Serialize)]
pub(super) struct EigenvalueEntry {
    pub(super) re: f64,
    pub(super) im: f64,
    pub(super) error: f64,
    pub(super) frequency: f64,
    pub(super) damping_ratio: Option<f64>,
    /// The time in which a deviation falls to 1/e, or grows to e times its size; absent where it does neither.
    pub(super) time: Option<f64>,
}

/// The most degrees of freedom with which other equilibria are sought.
const MOST_FREEDOM: usize = 8;

impl ModesReport {
    /// The report of the equilibria with their modes; the first one has all of its numbers.
    pub(super) fn new(setup: &Setup, mechanism: &dyn Mechanism, found: Vec<super::WithModes>) -> Result<Self, Error> {
        let description = setup.description;
        let entries: Vec<EquilibriumEntry> = found.iter().map(|(at, modes)| entry(setup, at, modes)).collect();
        let mut notes = Vec::new();
        if description.coordinates.len().saturating_sub(description.constraints.len()) > MOST_FREEDOM {
            notes.push(format!("other equilibria are sought with up to {MOST_FREEDOM} degrees of freedom"));
        }
        if depends_on_time(&setup.scene) {
            notes.push("loads that depend on time are those at t = 0".to_owned());
        }
        let mut others = entries.into_iter();
        let mut found = found.into_iter();
        let ((Some(equilibrium), Some((at, modes))), parameters) = (
            (others.next(), found.next()),
            description.parameters.iter().map(|parameter| parameter.name).collect::<Vec<_>>(),
        ) else {
            return Err(Error::run("no equilibrium was found"));
        };
        let modes = modes?;
        if corners(mechanism, setup, &at) {
            notes.push(
                "a load has a corner or a jump at this position: the frequencies hold for the formula that counts there"
                    .to_owned(),
            );
        }
        Ok(Self {
            heading: heading(description),
            scene: description.name,
            equilibrium,
            iterations: at.iterations,
            is_from_start: at.is_from_start,
            modes: modes.undamped.iter().map(|mode| mode_entry(setup, mode)).collect(),
            complex_squares: modes.complex_squares.iter().map(|square| [square.re, square.im]).collect(),
            eigenvalues: modes.damped.iter().map(eigenvalue_entry).collect(),
            others: others.collect(),
            notes,
            parameters,
            units: description.coordinates.iter().map(|coordinate| coordinate.unit).collect(),
        })
    }
}

fn entry(setup: &Setup, at: &Equilibrium, modes: &Result<Modes, Error>) -> EquilibriumEntry {
    let coordinates = setup.description.coordinates;
    let named = |values: &[f64]| {
        Named(coordinates.iter().zip(values).map(|(own, value)| (own.name.to_owned(), *value + 0.0)).collect())
    };
    let constraints = setup.description.constraints.iter().zip(&at.multipliers);
    let modes = modes.as_ref().ok();
    let growth = modes.into_iter().flat_map(|modes| &modes.damped).filter(|mode| mode.value.re > mode.error);
    let oscillations = modes.into_iter().flat_map(|modes| &modes.undamped);
    let mut oscillations = oscillations.filter(|mode| mode.kind() == ModeKind::Oscillation);
    EquilibriumEntry {
        coordinates: named(&at.q),
        errors: modes.map(|modes| named(&modes.q_errors)),
        multipliers: Named(constraints.map(|(own, value)| (own.name.to_owned(), *value)).collect()),
        residual: at.residual,
        stability: modes.map_or("unknown", |modes| stability_name(modes.stability)),
        growth: growth.map(|mode| mode.value.re).reduce(f64::max),
        lowest_frequency: oscillations.next().map(|mode| mode.rate().0 / TAU),
    }
}

fn mode_entry(setup: &Setup, mode: &Mode) -> ModeEntry {
    let (rate, rate_error) = mode.rate();
    let hertz = if mode.kind() == ModeKind::Growth { 0.0 } else { 1.0 / TAU };
    let coordinates = setup.description.coordinates.iter().zip(&mode.shape);
    let parameters = |by: &Vec<f64>| {
        let named = setup.description.parameters.iter().zip(by);
        Named(named.map(|(own, value)| (own.name.to_owned(), *value)).collect())
    };
    ModeEntry {
        kind: match mode.kind() {
            ModeKind::Oscillation => "oscillation",
            ModeKind::Free => "free",
            ModeKind::Growth => "growth",
        },
        frequency: rate * hertz,
        frequency_error: rate_error * hertz,
        rate,
        rate_error,
        square: mode.square,
        square_error: mode.square_error,
        shape: Named(coordinates.map(|(own, value)| (own.name.to_owned(), *value)).collect()),
        by: mode.by_parameters.as_ref().map(parameters),
    }
}

fn eigenvalue_entry(mode: &DampedMode) -> EigenvalueEntry {
    EigenvalueEntry {
        re: mode.value.re + 0.0,
        im: mode.value.im,
        error: mode.error,
        frequency: mode.value.im / TAU,
        damping_ratio: mode.damping_ratio(),
        time: (mode.value.re.abs() > mode.error).then(|| -1.0 / mode.value.re),
    }
}

/// The name of a stability in files.
pub(in crate::commands) fn stability_name(stability: EquilibriumStability) -> &'static str {
    match stability {
        EquilibriumStability::AsymptoticallyStable => "asymptotically_stable",
        EquilibriumStability::Stable => "stable",
        EquilibriumStability::Free => "free",
        EquilibriumStability::Unstable => "unstable",
        EquilibriumStability::Undecided => "undecided",
    }
}

/// Whether a load has a corner or a jump at an equilibrium.
fn corners(mechanism: &dyn Mechanism, setup: &Setup, at: &Equilibrium) -> bool {
    let tape = setup.model.tape();
    let mut values = vec![0.0; tape.switching_functions.results.len()];
    let mut evaluator = qrm_core::TapeEvaluator::<Vec<f64>>::with_parameters(tape, mechanism.parameters());
    evaluator.switching_functions(0.0, &at.q, &vec![0.0; at.q.len()], &mut values);
    values.iter().any(|value| value.abs() <= CORNER)
}

/// Switching functions of this size are zero.
const CORNER: f64 = 1e-12;
