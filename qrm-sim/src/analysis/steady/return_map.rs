//! The map from the start of a period to its end, and Newton's method on it.

use std::f64::consts::TAU;

use nalgebra::linalg::SVD;
use nalgebra::{DMatrix, DVector, Dyn};
use qrm_core::{Mechanism, Tape};

use super::SteadyRequest;
use super::cycle::{Guess, closed};
use super::error::NoSteadyMotion;
use super::means::output_means;
use crate::analysis::revolution::wrap_angle;
use crate::analysis::sensitivity::{EndByStart, end_by_start};
use crate::integrate::{Integrator, MethodSettings};
use crate::position::Start;
use crate::solve::{Matrix, Solver};
use crate::state::State;

/// A candidate for a periodic motion: a start with all coordinates and rates, and the period.
#[derive(Clone, Debug)]
pub(super) struct Orbit {
    pub(super) start: Start,
    pub(super) period: f64,
}

/// A solution.
pub(super) struct Found {
    pub(super) orbit: Orbit,
    /// The motion over a period from there, with derivatives.
    pub(super) at: EndByStart,
    pub(super) residual: f64,
    pub(super) is_one_of_many: bool,
    /// The last step of Newton's method, which was not made: rounding errors.
    last_step: DVector<f64>,
}

/// The map over a period.
pub(super) struct ReturnMap<'a> {
    mechanism: &'a dyn Mechanism,
    tape: &'a Tape,
    settings: MethodSettings,
    keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
    /// The given coordinates, then the given rates.
    places: Vec<Place>,
    /// The place of the phase, where the period is free.
    phase: Option<usize>,
    /// The whole turns of each coordinate.
    turns: Vec<f64>,
    /// The size of each given value, and that of the period.
    sizes: Vec<f64>,
    period_size: f64,
    /// The fastest given rate of the guess.
    rate_of_guess: f64,
}

/// The linearized equations in parts of the sizes: their singular values; `None` without unknowns. The unknown in the
/// place of the phase is the period, where it is free.
struct Linearized(Option<SVD<f64, Dyn, Dyn>>);

impl Linearized {
    /// The step of Newton's method. Directions with singular values of at most a part of the largest are left out.
    fn step(&self, residuals: &DVector<f64>, least: f64) -> DVector<f64> {
        let solve = |svd: &SVD<f64, Dyn, Dyn>| svd.solve(&-residuals, least * svd.singular_values.amax()).ok();
        self.0.as_ref().and_then(solve).unwrap_or_else(|| DVector::zeros(0))
    }

    /// Whether a singular value is at most a part of the largest.
    fn is_singular(&self, least: f64) -> bool {
        self.0.as_ref().is_some_and(|svd| svd.singular_values.min() <= least * svd.singular_values.amax())
    }
}

/// A coordinate or a rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    is_rate: bool,
    coordinate: usize,
}

impl Place {
    fn of(self, [q, qd]: [&[f64]; 2]) -> f64 {
        if self.is_rate { qd[self.coordinate] } else { q[self.coordinate] }
    }
}

/// The most iterations of Newton's method, and the most halvings of a step.
const MOST_ITERATIONS: u32 = 25;
const MOST_HALVINGS: u32 = 8;
/// Far more rotations than singular values of such matrices need.
const MOST_ROTATIONS: usize = 10_000;
/// A step below this part of the sizes is the last one, and so is one that does not become smaller below the other.
const CONVERGED: f64 = 1e-14;
const SETTLED: f64 = 1e-8;
/// The largest residual of a solution, and one that is left by rounding errors.
const CLOSED: f64 = 1e-7;
const ROUNDED: f64 = 1e-9;
/// Singular values of the linearized equations below this part of the largest belong to families of motions.
const FAMILY: f64 = 1e-8;
/// The largest such part while residuals are large.
const ACROSS: f64 = 0.1;
/// A motion slower than this part of the guess has been led to rest.
const REST: f64 = 0.01;
/// The longest step, in parts of the sizes.
const LONGEST: f64 = 3.0;
/// The rounding error of period and start.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// The error of the time of a corner or jump of loads, in parts of the period.
const CROSSED: f64 = 1e-12;
/// The number of places in a period at which loads are compared with those a period later.
const PLACES: u32 = 16;
/// The largest difference between the ends of a period that belong to one position, relative to sizes.
const SAME: f64 = 1e-6;

impl<'a> ReturnMap<'a> {
    /// The map near a guess.
    ///
    /// # Errors
    /// The start does not determine the motion, or the guess cannot be followed.
    pub(super) fn new(
        mechanism: &'a dyn Mechanism,
        tape: &'a Tape,
        request: &SteadyRequest<'a>,
        start: &Start,
        guess: &Guess,
    ) -> Result<Self, NoSteadyMotion> {
        let given = |given: &[bool], is_rate| {
            let coordinates = (0..given.len()).filter(|&i| given[i]);
            coordinates.map(|coordinate| Place { is_rate, coordinate }).collect::<Vec<_>>()
        };
        let places = [given(&start.given, false), given(&start.given_rates, true)].concat();
        let rates = start.given_rates.iter().filter(|given| **given).count();
        if places.len() != 2 * rates {
            return Err(NoSteadyMotion::NotGiven);
        }
        let phase = guess.phase.map(|coordinate| Place { is_rate: false, coordinate });
        let phase = phase.map(|phase| places.iter().position(|place| *place == phase).ok_or(NoSteadyMotion::NoPhase));
        let mut map = Self {
            mechanism,
            tape,
            settings: request.settings,
            keep_running: request.keep_running,
            sizes: vec![1.0; places.len()],
            places,
            phase: phase.transpose()?,
            turns: vec![0.0; start.q.len()],
            period_size: guess.orbit.period,
            rate_of_guess: 0.0,
        };
        let at = map.follow(&guess.orbit, false)?;
        let description = mechanism.description();
        for (i, turns) in map.turns.iter_mut().enumerate() {
            let change = at.end.q[i] - at.first.q[i];
            *turns = if description.is_angle(i) { (change / TAU).round() } else { 0.0 };
        }
        map.rate_of_guess = map.fastest(&at);
        map.sizes = map.ranges(&guess.orbit, &at.first)?;
        Ok(map)
    }

    /// The sizes of the given values over a period: the largest values of coordinates and rates.
    fn ranges(&self, orbit: &Orbit, first: &State) -> Result<Vec<f64>, NoSteadyMotion> {
        let mut largest = self.places.iter().map(|place| place.of([&first.q, &first.qd]).abs()).collect::<Vec<_>>();
        let at_places = self.at_places(first, orbit.period)?;
        for at in &at_places {
            for (largest, place) in largest.iter_mut().zip(&self.places) {
                *largest = largest.max(place.of([&at.q, &at.qd]).abs());
            }
        }
        let travel = orbit.period / TAU;
        let description = self.mechanism.description();
        let largest_of = |is_rate, coordinate| {
            let place = self.places.iter().position(|place| *place == Place { is_rate, coordinate });
            place.map_or(0.0, |place| largest[place])
        };
        let size = |place: &Place| {
            let i = place.coordinate;
            let of_rate = largest_of(true, i);
            let size = if description.is_angle(i) { 1.0 } else { largest_of(false, i).max(of_rate * travel) };
            let size = if place.is_rate { of_rate.max(size / travel) } else { size };
            if size > 0.0 { size } else { 1.0 }
        };
        Ok(self.places.iter().map(size).collect())
    }

    /// The states at some places of a period.
    fn at_places(&self, first: &State, period: f64) -> Result<Vec<State>, NoSteadyMotion> {
        let failed = |error| NoSteadyMotion::Settling { t: first.t, error };
        let mut integrator = Integrator::new(self.mechanism, self.settings, first, period).map_err(failed)?;
        let (mut from, mut to) = (first.clone(), first.clone());
        let mut states = Vec::new();
        for place in 1..=PLACES {
            std::mem::swap(&mut from, &mut to);
            let t = period * f64::from(place) / f64::from(PLACES + 1);
            integrator.advance(self.mechanism, &from, t, &mut to).map_err(failed)?;
            states.push(to.clone());
        }
        Ok(states)
    }

    /// Bounds the length of steps.
    pub(super) fn limit_steps(&mut self, longest: f64) {
        let bounds = &mut self.settings.step_bounds;
        bounds.longest = bounds.longest.min(longest);
    }

    pub(super) fn turns(&self) -> &[f64] {
        &self.turns
    }

    /// The number of given values.
    pub(super) fn unknowns(&self) -> usize {
        self.places.len()
    }

    pub(super) fn phase(&self) -> Option<usize> {
        self.phase
    }

    fn follow(&self, orbit: &Orbit, is_halved: bool) -> Result<EndByStart, NoSteadyMotion> {
        let Self { mechanism, tape, settings, keep_running, .. } = self;
        let at = end_by_start(*mechanism, tape, *settings, &orbit.start, orbit.period, is_halved, *keep_running);
        Ok(at?)
    }

    /// The derivatives of the given values at the end by those at the start, column by column.
    pub(super) fn jacobian(&self, at: &EndByStart) -> DMatrix<f64> {
        let entry = |row: usize, column: usize| {
            let [q, qd] = &at.by[column];
            self.places[row].of([q, qd])
        };
        DMatrix::from_fn(self.places.len(), self.places.len(), entry)
    }

    /// The derivatives of the given values at the end by time.
    pub(super) fn rates(&self, at: &EndByStart) -> DVector<f64> {
        DVector::from_fn(self.places.len(), |row, _| self.places[row].of([&at.end.qd, &at.end.qdd]))
    }

    /// The differences between end and start, in parts of the sizes.
    fn residuals(&self, at: &EndByStart) -> DVector<f64> {
        DVector::from_fn(self.places.len(), |row, _| {
            let place = self.places[row];
            let turns = if place.is_rate { 0.0 } else { TAU * self.turns[place.coordinate] };
            let [end, first] = [&at.end, &at.first].map(|at| place.of([&at.q, &at.qd]));
            (end - turns - first) / self.sizes[row]
        })
    }

    /// Solves the equations of a periodic motion from a guess, by steps of the method or by steps half as long; also
    /// returns the number of iterations.
    ///
    /// # Errors
    /// Newton's method does not converge, or a motion cannot be followed.
    pub(super) fn solve(&self, guess: Orbit, is_halved: bool) -> Result<(Found, u32), NoSteadyMotion> {
        let mut orbit = guess;
        let mut at = self.follow(&orbit, is_halved)?;
        let mut before = f64::INFINITY;
        for iteration in 1..=MOST_ITERATIONS {
            let residuals = self.residuals(&at);
            let residual = largest_of(residuals.as_slice());
            let equations = self.linearized(&at)?;
            let step = equations.step(&residuals, FAMILY);
            let size = largest_of(step.as_slice());
            let is_settled = size <= CONVERGED || size < SETTLED && size > 0.5 * before;
            let next = if is_settled || self.places.is_empty() {
                None
            } else {
                // Far from a family of solutions the equations are nearly singular: a step across it leads there.
                let parts = [FAMILY, residual.clamp(FAMILY, ACROSS)];
                self.moved_along((&orbit, &residuals), &equations, parts, is_halved)?
            };
            match next {
                Some(next) => (orbit, at) = next,
                // Only rounding errors are left, which nearly singular equations make a long step of.
                None if residual < ROUNDED || size < SETTLED && residual < CLOSED => {
                    self.check_moves(&at)?;
                    let is_one_of_many = equations.is_singular(FAMILY);
                    return Ok((Found { orbit, at, residual, is_one_of_many, last_step: step }, iteration));
                }
                None => break,
            }
            before = size;
        }
        self.check_moves(&at)?;
        let residual = largest_of(self.residuals(&at).as_slice());
        Err(NoSteadyMotion::NotFound { residual, start: Box::new(orbit.start), period: orbit.period })
    }

    /// The orbit after the first step, or part of one, that makes the next step of the same equations smaller (Deuflhard's
    /// natural monotonicity test); `None` if there is none. Steps leave out directions with singular values up to these
    /// parts of the largest.
    ///
    /// # Errors
    /// The caller wanted no more.
    fn moved_along(
        &self,
        (orbit, residuals): (&Orbit, &DVector<f64>),
        equations: &Linearized,
        parts: [f64; 2],
        is_halved: bool,
    ) -> Result<Option<(Orbit, EndByStart)>, NoSteadyMotion> {
        for least in parts {
            let step = equations.step(residuals, least);
            let size = largest_of(step.as_slice());
            let mut part = (LONGEST / size).min(1.0);
            for _ in 0..MOST_HALVINGS {
                if let Some(tried) = self.moved(orbit, &step, part) {
                    match self.follow(&tried, is_halved) {
                        Ok(at) => {
                            let found = self.residuals(&at);
                            let next = equations.step(&found, least);
                            // A short step is made in any case, if the equations are smooth so far.
                            let is_last = size < SETTLED && largest_of(found.as_slice()) < CLOSED;
                            if is_last || largest_of(next.as_slice()) < size * (1.0 - 0.25 * part) {
                                return Ok(Some((tried, at)));
                            }
                        }
                        Err(NoSteadyMotion::Interrupted { t }) => return Err(NoSteadyMotion::Interrupted { t }),
                        Err(_) => {}
                    }
                }
                part *= 0.5;
            }
        }
        Ok(None)
    }

    /// The fastest given rate at both ends of a motion.
    fn fastest(&self, at: &EndByStart) -> f64 {
        let rates = self.places.iter().filter(|place| place.is_rate);
        let at_ends = rates.flat_map(|place| [&at.first, &at.end].map(|at| at.qd[place.coordinate]));
        largest_of(&at_ends.collect::<Vec<f64>>())
    }

    /// Returns an error if a motion with a period of its own has become much slower than the guess.
    fn check_moves(&self, at: &EndByStart) -> Result<(), NoSteadyMotion> {
        let is_at_rest = self.phase.is_some() && self.fastest(at) < REST * self.rate_of_guess;
        if is_at_rest { Err(NoSteadyMotion::LeadsToRest) } else { Ok(()) }
    }

    /// The linearized equations of a periodic motion.
    fn linearized(&self, at: &EndByStart) -> Result<Linearized, NoSteadyMotion> {
        let count = self.places.len();
        let (jacobian, rates) = (self.jacobian(at), self.rates(at));
        let scaled = DMatrix::from_fn(count, count, |row, column| {
            let (entry, size) = if self.phase == Some(column) {
                (rates[row], self.period_size)
            } else {
                (jacobian[(row, column)] - f64::from(u8::from(row == column)), self.sizes[column])
            };
            entry * size / self.sizes[row]
        });
        if count == 0 {
            return Ok(Linearized(None));
        }
        let svd = SVD::try_new(scaled, true, true, f64::EPSILON, MOST_ROTATIONS);
        svd.map(|svd| Linearized(Some(svd))).ok_or(NoSteadyMotion::NoEigenvalues)
    }

    /// A start moved by a part of a step; `None` if it cannot be assembled, or has no period.
    fn moved(&self, orbit: &Orbit, step: &DVector<f64>, part: f64) -> Option<Orbit> {
        let Orbit { mut start, mut period } = orbit.clone();
        for (column, place) in self.places.iter().enumerate() {
            if self.phase == Some(column) {
                period += part * step[column] * self.period_size;
            } else {
                let value = if place.is_rate { &mut start.qd } else { &mut start.q };
                value[place.coordinate] += part * step[column] * self.sizes[column];
            }
        }
        let start = closed(self.mechanism, start)?;
        (period > 0.0 && period.is_finite()).then_some(Orbit { start, period })
    }

    /// Whether all of a motion repeats after its period, and not only the given values.
    ///
    /// # Errors
    /// A coordinate is elsewhere, or the loads are others.
    pub(super) fn check_end(&self, found: &Found) -> Result<(), NoSteadyMotion> {
        let EndByStart { first, end, .. } = &found.at;
        let description = self.mechanism.description();
        let travel = found.orbit.period / TAU;
        let lengths = first.q.iter().copied().chain(first.qd.iter().map(|qd| qd * travel));
        let size = lengths.chain(self.sizes.iter().copied()).fold(0.0_f64, |most, q| most.max(q.abs()));
        for (coordinate, turns) in self.turns.iter().enumerate() {
            let change = end.q[coordinate] - first.q[coordinate] - TAU * turns;
            let difference = wrap_angle(change, description.coordinates[coordinate].unit);
            if difference.abs() > SAME * if description.is_angle(coordinate) { 1.0 } else { size } {
                return Err(NoSteadyMotion::OtherBranch { coordinate, difference });
            }
        }
        self.check_loads(found)
    }

    /// Compares accelerations and multipliers along the period with those a period later. A jump of a load may lie on
    /// either side of a single place.
    fn check_loads(&self, found: &Found) -> Result<(), NoSteadyMotion> {
        let Self { mechanism, turns, .. } = self;
        let first = &found.at.first;
        let failed = |error| NoSteadyMotion::Settling { t: first.t, error };
        let mut solver = Solver::new(*mechanism);
        let n = first.q.len();
        // The largest of all accelerations and of all multipliers, and each pair of values. Rates and masses show which
        // are rounding errors.
        let mut mass_matrix = Matrix::zero(n, n);
        mechanism.mass_matrix(&first.q, mass_matrix.entries_mut());
        let of_rates = largest_of(&first.qd).max(largest_of(&found.at.end.qd)) * TAU / found.orbit.period;
        let mut largest = [of_rates, of_rates * largest_of(mass_matrix.entries())];
        let mut pairs = Vec::new();
        for to in self.at_places(first, found.orbit.period)? {
            let mut later = State { t: to.t + found.orbit.period, ..to.clone() };
            later.q.iter_mut().zip(turns).for_each(|(q, turns)| *q += TAU * turns);
            solver.complete(*mechanism, &mut later).map_err(failed)?;
            let values = |at: &State| [&at.qdd[..], &at.multipliers[..]].concat();
            for (i, values) in values(&to).into_iter().zip(values(&later)).enumerate() {
                let largest = &mut largest[usize::from(i >= n)];
                *largest = largest.max(values.0.abs()).max(values.1.abs());
                pairs.push((i, values));
            }
        }
        let differs = |(i, (a, b)): &&(usize, (f64, f64))| (a - b).abs() > SAME * largest[usize::from(*i >= n)];
        let mut different = pairs.iter().filter(differs);
        let first = different.next();
        match first.filter(|(i, _)| different.filter(|(other, _)| other == i).count() > 0) {
            None => Ok(()),
            Some((i, values)) => Err(NoSteadyMotion::LoadsDiffer {
                quantity: if *i < n { Ok(*i) } else { Err(i - n) },
                values: [values.0, values.1],
            }),
        }
    }

    /// The means of the outputs over the period.
    pub(super) fn means(&self, found: &Found) -> Result<Vec<(f64, f64)>, NoSteadyMotion> {
        let first = &found.at.first;
        let means = output_means(self.mechanism, self.settings, first, found.orbit.period);
        means.map_err(|error| NoSteadyMotion::Settling { t: first.t, error })
    }

    /// The errors of the period, and of given coordinates and rates at the start, by a more accurate solution. Others have
    /// none.
    pub(super) fn errors(&self, found: &Found, accurate: &Found) -> (f64, [Vec<f64>; 2]) {
        let step = |column: usize| {
            [found, accurate].map(|found| found.last_step[column].abs()).into_iter().fold(0.0, f64::max)
        };
        // The time of a corner or a jump is not known better.
        let late = if self.mechanism.description().has_corners { CROSSED * found.orbit.period } else { 0.0 };
        let error = |own: f64, other: f64, step: f64, rate: f64| {
            (own - other).abs().max(step).max(ROUNDING * own.abs()).max(late * rate)
        };
        let rates = [&found.at.end.qd, &found.at.end.qdd].map(|rates| largest_of(rates));
        let (own, other) = (&found.orbit, &accurate.orbit);
        let mut errors = [vec![0.0; own.start.q.len()], vec![0.0; own.start.q.len()]];
        let mut of_period = 0.0;
        for (column, place) in self.places.iter().enumerate() {
            if self.phase == Some(column) {
                of_period = error(own.period, other.period, step(column) * self.period_size, 1.0);
                continue;
            }
            let [own, other] = [own, other].map(|orbit| place.of([&orbit.start.q, &orbit.start.qd]));
            errors[usize::from(place.is_rate)][place.coordinate] =
                error(own, other, step(column) * self.sizes[column], rates[usize::from(place.is_rate)]);
        }
        (of_period, errors)
    }
}

/// The size of the largest of some numbers.
fn largest_of(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, number| most.max(number.abs()))
}
