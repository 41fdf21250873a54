//! The map from the start of a period to its end, and Newton's method on it.

use std::f64::consts::TAU;

use nalgebra::linalg::SVD;
use nalgebra::{DMatrix, DVector};
use qrm_core::{Mechanism, Tape};

use super::SteadyRequest;
use super::cycle::Guess;
use super::error::NoSteadyMotion;
use super::means::output_means;
use crate::analysis::revolution::wrap_angle;
use crate::analysis::sensitivity::{EndByStart, end_by_start};
use crate::integrate::{Integrator, MethodSettings};
use crate::position::{Start, assemble_from_guesses};
use crate::solve::Solver;
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
/// A step below this part of the sizes is the last one, and so is one that does not become smaller below the other.
const CONVERGED: f64 = 1e-14;
const SETTLED: f64 = 1e-8;
/// Singular values of the linearized equations below this part of the largest belong to families of motions.
const FAMILY: f64 = 1e-8;
/// The largest such part while residuals are large.
const ACROSS: f64 = 0.1;
/// A motion slower than this part of the guess has been led to rest.
const REST: f64 = 0.01;
/// The longest step, in parts of the sizes.
const LONGEST: f64 = 1.0;
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
        let ends = [&at.first, &at.end];
        map.rate_of_guess = map.fastest(&at);
        let rate = |i: usize| ends.iter().map(|at| at.qd[i].abs()).fold(0.0, f64::max);
        map.sizes = map
            .places
            .iter()
            .map(|place| {
                let i = place.coordinate;
                let own = if place.is_rate { 0.0 } else { ends.iter().map(|at| at.q[i].abs()).fold(0.0, f64::max) };
                let travel = rate(i) * guess.orbit.period / TAU;
                let size = if description.is_angle(i) { 1.0 } else { own.max(travel) };
                let rate_size = rate(i).max(size * TAU / guess.orbit.period);
                let size = if place.is_rate { rate_size } else { size };
                if size > 0.0 { size } else { 1.0 }
            })
            .collect();
        Ok(map)
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
        let mut residuals = self.residuals(&at);
        let mut before = f64::INFINITY;
        for iteration in 1..=MOST_ITERATIONS {
            let (step, is_one_of_many) = self.step(&at, &residuals, FAMILY)?;
            let size = step.amax();
            if size <= CONVERGED || size < SETTLED && size > 0.5 * before || self.places.is_empty() {
                let residual = if residuals.is_empty() { 0.0 } else { residuals.amax() };
                return Ok((Found { orbit, at, residual, is_one_of_many, last_step: step }, iteration));
            }
            before = size;
            let mut next = self.shorter((&orbit, &residuals), &step, is_halved)?;
            if next.is_none() {
                // Far from a family of solutions the equations are nearly singular: a step across it leads there.
                let (across, _) = self.step(&at, &residuals, residuals.amax().clamp(FAMILY, ACROSS))?;
                next = self.shorter((&orbit, &residuals), &across, is_halved)?;
            }
            match next {
                Some(next) => (orbit, residuals, at) = next,
                None => break,
            }
        }
        if self.is_at_rest(&at) {
            return Err(NoSteadyMotion::LeadsToRest);
        }
        Err(NoSteadyMotion::NotFound { residual: residuals.amax(), start: Box::new(orbit.start), period: orbit.period })
    }

    /// The orbit after a step, or after a part of it that makes the residuals smaller; `None` if no part does.
    ///
    /// # Errors
    /// The caller wanted no more.
    fn shorter(
        &self,
        (orbit, residuals): (&Orbit, &DVector<f64>),
        step: &DVector<f64>,
        is_halved: bool,
    ) -> Result<Option<(Orbit, DVector<f64>, EndByStart)>, NoSteadyMotion> {
        let size = step.amax();
        let mut part = (LONGEST / size).min(1.0);
        for _ in 0..MOST_HALVINGS {
            let bound = residuals.norm() * (1.0 - 0.1 * part);
            if let Some(tried) = self.moved(orbit, step, part) {
                match self.follow(&tried, is_halved).map(|at| (self.residuals(&at), at)) {
                    Ok((found, at)) if found.norm() < bound || size < SETTLED => return Ok(Some((tried, found, at))),
                    Err(NoSteadyMotion::Interrupted { t }) => return Err(NoSteadyMotion::Interrupted { t }),
                    Ok(_) | Err(_) => {}
                }
            }
            part *= 0.5;
        }
        Ok(None)
    }

    /// The fastest given rate at both ends of a motion.
    fn fastest(&self, at: &EndByStart) -> f64 {
        let rates = self.places.iter().filter(|place| place.is_rate);
        let at_ends = rates.flat_map(|place| [&at.first, &at.end].map(|at| at.qd[place.coordinate].abs()));
        at_ends.fold(0.0, f64::max)
    }

    /// Whether a motion has become much slower than the guess.
    fn is_at_rest(&self, at: &EndByStart) -> bool {
        self.fastest(at) < REST * self.rate_of_guess
    }

    /// The step of Newton's method in parts of the sizes, and whether the equations have a family of solutions. The last
    /// entry is that of the period, where it is free.
    /// Directions with singular values of at most a part of the largest are left out.
    fn step(
        &self,
        at: &EndByStart,
        residuals: &DVector<f64>,
        least: f64,
    ) -> Result<(DVector<f64>, bool), NoSteadyMotion> {
        let count = self.places.len();
        if count == 0 {
            return Ok((DVector::zeros(0), false));
        }
        let (jacobian, rates) = (self.jacobian(at), self.rates(at));
        let scaled = DMatrix::from_fn(count, count, |row, column| {
            let (entry, size) = if self.phase == Some(column) {
                (rates[row], self.period_size)
            } else {
                (jacobian[(row, column)] - f64::from(u8::from(row == column)), self.sizes[column])
            };
            entry * size / self.sizes[row]
        });
        let svd = SVD::try_new(scaled, true, true, f64::EPSILON, 10_000).ok_or(NoSteadyMotion::NoEigenvalues)?;
        let least = least * svd.singular_values.amax();
        let is_singular = svd.singular_values.iter().any(|value| *value <= least);
        let step = svd.solve(&-residuals, least).map_err(|_| NoSteadyMotion::NoEigenvalues)?;
        Ok((step, is_singular))
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
        (start.q, start.qd) = assemble_from_guesses(self.mechanism, &start).ok()?;
        (period > 0.0 && period.is_finite()).then_some(Orbit { start, period })
    }

    /// Whether all of a motion repeats after its period, and not only the given values.
    ///
    /// # Errors
    /// A coordinate is elsewhere, or the loads are others.
    pub(super) fn check_end(&self, found: &Found) -> Result<(), NoSteadyMotion> {
        let EndByStart { first, end, .. } = &found.at;
        let description = self.mechanism.description();
        let size = first.q.iter().fold(1e-300_f64, |most, q| most.max(q.abs()));
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
        let Self { mechanism, settings, turns, .. } = self;
        let first = &found.at.first;
        let failed = |error| NoSteadyMotion::Settling { t: first.t, error };
        let mut integrator = Integrator::new(*mechanism, *settings, first, found.orbit.period).map_err(failed)?;
        let mut solver = Solver::new(*mechanism);
        let n = first.q.len();
        let (mut from, mut to) = (first.clone(), first.clone());
        // The largest of all accelerations and of all multipliers, and each pair of values.
        let mut largest = [0.0_f64; 2];
        let mut pairs = Vec::new();
        for place in 1..=PLACES {
            std::mem::swap(&mut from, &mut to);
            let t = found.orbit.period * f64::from(place) / f64::from(PLACES + 1);
            integrator.advance(*mechanism, &from, t, &mut to).map_err(failed)?;
            let mut later = State { t: t + found.orbit.period, ..to.clone() };
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
        let error = |own: f64, other: f64, step: f64| (own - other).abs().max(step).max(f64::EPSILON * own.abs());
        let (own, other) = (&found.orbit, &accurate.orbit);
        let mut errors = [vec![0.0; own.start.q.len()], vec![0.0; own.start.q.len()]];
        let mut of_period = 0.0;
        for (column, place) in self.places.iter().enumerate() {
            if self.phase == Some(column) {
                of_period = error(own.period, other.period, step(column) * self.period_size);
                continue;
            }
            let [own, other] = [own, other].map(|orbit| place.of([&orbit.start.q, &orbit.start.qd]));
            errors[usize::from(place.is_rate)][place.coordinate] = error(own, other, step(column) * self.sizes[column]);
        }
        (of_period, errors)
    }
}
