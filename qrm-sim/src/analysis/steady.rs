//! Steady motion: the periodic motion that a mechanism settles into, and its stability.

mod branch;
mod cycle;
mod error;
mod means;
mod multipliers;
mod newton;
mod repetition;
mod return_map;
mod solution;
mod special_point;
mod tangent;
mod varied;

use qrm_core::{Mechanism, Tape};

use crate::integrate::MethodSettings;
use crate::position::{AssemblyBranch, Start};
use crate::run::first_state;
use means::output_means;
use newton::Found;
use repetition::{check_repetition, repetitions};
use return_map::{Orbit, ReturnMap};
use solution::Solution;
use varied::Varied;

pub use branch::{BranchEnd, BranchPoint, BranchRequest, PointKind, steady_branch};
pub use error::NoSteadyMotion;
pub use multipliers::{MotionStability, Multiplier};

/// Steps are halved until the errors of multipliers are below the first of these, or below the second times the
/// tolerance; or until that does not make them smaller.
const RESOLVED: f64 = 1e-11;
const LOOSER: f64 = 100.0;
/// The most periods after which loads are compared.
const MOST_COMPARED: u32 = 1000;
/// The most times that steps are halved.
const MOST_REFINEMENTS: u32 = 6;

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
    /// The stability: the fate of small deviations.
    pub stability: MotionStability,
    /// The number of times that the motion repeats within the period; one if the period is the shortest.
    pub repetitions: u32,
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
    let (mut map, mut orbit) = search(mechanism, tape, request, None)?;
    let (mut iterations, mut refinements) = (0, 0);
    let target = RESOLVED.max(LOOSER * request.settings.tolerance);
    let mut best: Option<Solution> = None;
    loop {
        let solution = match Solution::new(&map, orbit, None) {
            Ok(solution) => solution,
            // Shorter steps have too many rounding errors.
            Err(reason) if best.is_none() || matches!(reason, NoSteadyMotion::Interrupted { .. }) => {
                return Err(reason);
            }
            Err(_) => break,
        };
        iterations += solution.iterations();
        let error = solution.multiplier_error();
        let Found { orbit: found, at, .. } = &solution.found;
        map.demand_steps(2.0 * at.steps as f64);
        orbit = found.clone();
        let before = best.as_ref().map_or(f64::INFINITY, Solution::multiplier_error);
        if error < before || best.is_none() {
            best = Some(solution);
        }
        refinements += 1;
        if error <= target || error > 0.5 * before || refinements > MOST_REFINEMENTS {
            break;
        }
    }
    let Some(solution) = best else { return Err(NoSteadyMotion::NoEigenvalues) };
    check_repetition(&map, &solution.found, &periods_to_compare(request))?;
    let repetitions = repetitions(&map, &solution.found, request.cycles.max(1))?;
    motion(&map, &solution, iterations, repetitions)
}

/// The guess of a periodic motion, and the map near it.
fn search<'a>(
    mechanism: &'a dyn Mechanism,
    tape: &'a Tape,
    request: &SteadyRequest<'a>,
    varied: Option<Varied<'a>>,
) -> Result<(ReturnMap<'a>, Orbit), NoSteadyMotion> {
    let start = request.start.clone().unwrap_or_else(|| Start::new(mechanism));
    if !request.settings.method.is_adaptive() {
        return Err(NoSteadyMotion::FixedSteps);
    }
    if request.phase.is_some_and(|phase| start.given.get(phase) != Some(&true)) {
        return Err(NoSteadyMotion::NoPhase);
    }
    let branch = AssemblyBranch::new(mechanism);
    let first = first_state(mechanism, &branch, start.clone()).map_err(NoSteadyMotion::Start)?;
    let mut guess = cycle::guess(mechanism, request, &start, &first)?;
    if let Some(varied) = varied {
        guess.orbit.parameter = mechanism.parameters()[varied.parameter];
    }
    let map = ReturnMap::new(mechanism, tape, request, varied, &guess)?;
    Ok((map, guess.orbit))
}

/// The numbers of periods after which loads are compared.
fn periods_to_compare(request: &SteadyRequest) -> [u32; 2] {
    // Rounding errors of longer times are differences too.
    [1, request.settle.clamp(2, MOST_COMPARED)]
}

impl SteadyMotion {
    /// Adds the differences of two orbits to the errors of period and start.
    fn move_by(&mut self, own: &Orbit, other: &Orbit) {
        self.period_error = self.period_error.max((own.period - other.period).abs());
        let pairs = [[&own.start.q, &other.start.q], [&own.start.qd, &other.start.qd]];
        let given = [&own.start.given, &own.start.given_rates];
        for ((errors, [own, other]), given) in self.start_errors.iter_mut().zip(pairs).zip(given) {
            for (i, error) in errors.iter_mut().enumerate().filter(|(i, _)| given[*i]) {
                *error = error.max((own[i] - other[i]).abs());
            }
        }
    }
}

/// The motion of a solution.
fn motion(
    map: &ReturnMap,
    solution: &Solution,
    iterations: u32,
    repetitions: u32,
) -> Result<SteadyMotion, NoSteadyMotion> {
    let Solution { found, accurate, multipliers } = solution;
    let (period_error, start_errors) = solution.start_errors(map);
    let first = &found.at.first;
    let means = output_means(&*map.mechanism(&found.orbit), map.settings(&found.orbit), first, found.orbit.period)
        .map_err(|error| NoSteadyMotion::Settling { t: first.t, error })?;
    Ok(SteadyMotion {
        period: found.orbit.period,
        period_error,
        start: found.orbit.start.clone(),
        start_errors,
        means,
        other_start: accurate.orbit.start.clone(),
        turns: map.turns_of(&found.at),
        multipliers: multipliers.clone(),
        stability: MotionStability::new(multipliers, found.is_singular),
        repetitions,
        iterations,
        residual: found.residual,
        steps: found.at.steps,
    })
}
