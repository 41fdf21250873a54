//! Steady motion: the periodic motion that a mechanism settles into, and its stability.

mod cycle;
mod error;
mod means;
mod multipliers;
mod return_map;

use qrm_core::{Mechanism, Tape};

use crate::integrate::MethodSettings;
use crate::position::{AssemblyBranch, Start};
use crate::run::first_state;
use return_map::{Found, ReturnMap};

pub use error::NoSteadyMotion;
pub use multipliers::Multiplier;

/// The least number of steps in a period: where nothing moves, the method would choose none of its own.
const STEPS: f64 = 32.0;
/// Steps are halved until the errors of multipliers are below the first of these, or below the second times the
/// tolerance; or until that does not make them smaller.
const RESOLVED: f64 = 1e-11;
const LOOSER: f64 = 100.0;

/// A request for a steady motion.
#[derive(Clone, Default)]
pub struct SteadyRequest<'a> {
    /// The method, which chooses its steps.
    pub settings: MethodSettings,
    /// The start of the search; the scene's if `None`.
    pub start: Option<Start>,
    /// The period, in s, where formulae depend on time; `None` finds that of the motion.
    pub period: Option<f64>,
    /// The coordinate whose turns or oscillations are the cycles of a free period; the first given one if `None`.
    pub phase: Option<usize>,
    /// The number of cycles in a period.
    pub cycles: u32,
    /// The number of periods of the ordinary motion before the search.
    pub settle: u32,
    /// The time between the states that the search for cycles looks at, in s; the scene's step if `None`.
    pub step: Option<f64>,
    /// Asked now and then, with the time and the latest end of the motion under way; nothing more is computed where it
    /// says false.
    pub keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
}

/// A periodic motion.
#[derive(Clone, Debug)]
pub struct SteadyMotion {
    /// The period, in s.
    pub period: f64,
    /// Its estimated error; zero if the period was given.
    pub period_error: f64,
    /// The start of a period: all coordinates and rates, and which of them are given.
    pub start: Start,
    /// The estimated errors of its given coordinates and rates; zero for the others.
    pub start_errors: [Vec<f64>; 2],
    /// The mean of each output over the period, and the error of its sum.
    pub means: Vec<(f64, f64)>,
    /// The start by steps half as long.
    pub other_start: Start,
    /// The whole turns of each coordinate in a period; zero for lengths.
    pub turns: Vec<f64>,
    /// The multipliers of small deviations in a period, the largest first; without that of a shift in time.
    pub multipliers: Vec<Multiplier>,
    /// Whether others of any near period or energy surround the motion, as without losses.
    pub is_one_of_many: bool,
    /// The number of iterations of Newton's method.
    pub iterations: u32,
    /// The largest difference between the end and the start of the period, relative to the ranges of coordinates and
    /// rates.
    pub residual: f64,
    /// The number of steps in the period.
    pub steps: u64,
}

/// Finds the periodic motion near the one that a start settles into.
///
/// The given coordinates and rates `x` at the start of a period solve `P(x) - x = 0`, where `P(x)` are their values
/// after the period `T`, less whole turns. Newton's method takes `dP/dx` from the steps on dual numbers. A free period
/// is an unknown too; in its place the coordinate of the phase keeps its start. The multipliers are the eigenvalues of
/// `dP/dx`, which do not depend on the choice of coordinates; at a free period, those of the return map to the same
/// phase. Their errors, and that of the start, are the differences from the motion by steps half as long.
///
/// ```
/// # use qrm_core::Model;
/// # use qrm_sim::analysis::{NoSteadyMotion, SteadyRequest, steady_motion};
/// # use qrm_sim::integrate::{DOP853, MethodSettings};
/// # fn settle(model: &Model) -> Result<(), NoSteadyMotion> {
/// let settings = MethodSettings::new(DOP853, 1e-12);
/// let request = SteadyRequest { settings, cycles: 1, settle: 30, ..SteadyRequest::default() };
/// let motion = steady_motion(&*model.mechanism(&|_| None), model.tape(), &request)?;
/// println!("{} s, the largest multiplier {:?}", motion.period, motion.multipliers.first());
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// There is no such motion, or it is not found: see [`NoSteadyMotion`].
pub fn steady_motion(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    request: &SteadyRequest,
) -> Result<SteadyMotion, NoSteadyMotion> {
    let start = request.start.clone().unwrap_or_else(|| Start::new(mechanism));
    let branch = AssemblyBranch::new(mechanism);
    let first = first_state(mechanism, &branch, start.clone()).map_err(NoSteadyMotion::Start)?;
    let guess = cycle::guess(mechanism, request, &start, &first)?;
    let mut map = ReturnMap::new(mechanism, tape, request, &start, &guess)?;
    let mut orbit = guess.orbit;
    let mut iterations = 0;
    let target = RESOLVED.max(LOOSER * request.settings.tolerance);
    let mut longest = orbit.period / STEPS;
    let mut best: Option<Solution> = None;
    loop {
        map.limit_steps(longest);
        let (found, own) = map.solve(orbit, false)?;
        let (accurate, of_accurate) = map.solve(found.orbit.clone(), true)?;
        iterations += own + of_accurate;
        let multipliers = multipliers::multipliers(&map, &found, &accurate)?;
        let error = multipliers.iter().map(|m| m.error / m.value.norm().max(1.0)).fold(0.0, f64::max);
        // Steps are as long on average as they are many.
        longest = 0.5 * longest.min(found.orbit.period / found.at.steps as f64);
        orbit = found.orbit.clone();
        let before = best.as_ref().map_or(f64::INFINITY, |best| best.error);
        if error < before {
            best = Some(Solution { found, accurate, multipliers, error });
        }
        if error <= target || error > 0.5 * before {
            break;
        }
    }
    let Some(Solution { found, accurate, multipliers, .. }) = best else { return Err(NoSteadyMotion::NoEigenvalues) };
    map.check_end(&found)?;
    let (period_error, start_errors) = map.errors(&found, &accurate);
    Ok(SteadyMotion {
        period: found.orbit.period,
        period_error,
        start_errors,
        means: map.means(&found)?,
        turns: map.turns().to_vec(),
        multipliers,
        is_one_of_many: found.is_one_of_many,
        iterations,
        residual: found.residual,
        steps: found.at.steps,
        start: found.orbit.start,
        other_start: accurate.orbit.start,
    })
}

/// A periodic motion by two lengths of steps.
struct Solution {
    found: Found,
    accurate: Found,
    multipliers: Vec<Multiplier>,
    /// The largest error of a multiplier, relative to sizes of at least one.
    error: f64,
}
