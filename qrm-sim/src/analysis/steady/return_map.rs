//! The map from the start of a period to its end.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use qrm_core::{Mechanism, Tape};

use super::SteadyRequest;
use super::cycle::{Guess, closed};
use super::error::NoSteadyMotion;
use super::varied::{OwnedOr, Varied};
use crate::analysis::sensitivity::{EndByStart, MotionByStart, SensitivityError, end_by_start};
use crate::integrate::{Integrator, MethodSettings};
use crate::position::Start;
use crate::state::State;

/// A candidate for a periodic motion: a start with all coordinates and rates, and the period.
#[derive(Clone, Debug)]
pub(super) struct Orbit {
    pub(super) start: Start,
    pub(super) period: f64,
    /// The value of the varied parameter; not used where none is varied.
    pub(super) parameter: f64,
}

/// The map over a period.
pub(super) struct ReturnMap<'a> {
    mechanism: &'a dyn Mechanism,
    tape: &'a Tape,
    settings: MethodSettings,
    /// The least number of steps in a period.
    least_steps: f64,
    keep_running: Option<&'a dyn Fn(f64, f64) -> bool>,
    /// The given coordinates, then the given rates.
    places: Vec<Place>,
    /// The place of the phase, where the period is free.
    phase: Option<usize>,
    /// The parameter that is varied.
    varied: Option<Varied<'a>>,
    /// The whole turns of each coordinate.
    turns: Vec<f64>,
    /// The size of each given value.
    sizes: Vec<f64>,
    /// The size of each unknown: of the given values, but of the period in the place of the phase where it is free;
    /// then of the varied parameter.
    unknown_sizes: Vec<f64>,
    /// The period of the motion nearby, and its fastest given rate.
    period_nearby: f64,
    rate_nearby: f64,
}

/// A coordinate or a rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) is_rate: bool,
    pub(super) coordinate: usize,
}

impl Place {
    pub(super) fn value_in(self, [q, qd]: [&[f64]; 2]) -> f64 {
        if self.is_rate { qd[self.coordinate] } else { q[self.coordinate] }
    }
}

/// A motion slower than this part of the motion nearby has been led to rest.
const REST: f64 = 0.01;
/// A rate below this part of the size of its coordinate in the time of a radian of the cycle tells no phase.
const HARDLY: f64 = 1e-2;
/// Sizes grow with values that are this many times as large.
const GROWN: f64 = 1.5;
/// The period stays within these multiples of that of the motion nearby: `P(x, 0) = x` for all `x`.
const NEAR: [f64; 2] = [0.5, 1.8];
/// The least number of steps in a period: where nothing moves, the method would choose none of its own.
const STEPS: f64 = 32.0;
/// The number of places in a period at which motions are looked at.
const PLACES: u32 = 16;

impl<'a> ReturnMap<'a> {
    /// The map near a guess.
    ///
    /// # Errors
    /// The start does not determine the motion, or the guess cannot be followed.
    pub(super) fn new(
        mechanism: &'a dyn Mechanism,
        tape: &'a Tape,
        request: &SteadyRequest<'a>,
        varied: Option<Varied<'a>>,
        guess: &Guess,
    ) -> Result<Self, NoSteadyMotion> {
        let start = &guess.orbit.start;
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
        let phase = phase.transpose()?;
        let period = guess.orbit.period;
        let mut map = Self {
            mechanism,
            tape,
            settings: request.settings,
            least_steps: STEPS,
            keep_running: request.keep_running,
            sizes: Vec::new(),
            unknown_sizes: Vec::new(),
            places,
            phase,
            varied,
            turns: vec![0.0; start.q.len()],
            period_nearby: period,
            rate_nearby: 0.0,
        };
        let at = map.follow(&guess.orbit, false)?;
        map.turns = map.turns_of(&at);
        map.rate_nearby = map.fastest(&at);
        map.sizes = map.ranges(&guess.orbit, &at.first)?;
        map.unknown_sizes = map.sizes.clone();
        if let Some(phase) = phase {
            map.unknown_sizes[phase] = period;
        }
        map.unknown_sizes.extend(map.varied.as_ref().map(|varied| varied.size));
        Ok(map)
    }

    /// The whole turns of each coordinate in a motion.
    pub(super) fn turns_of(&self, at: &EndByStart) -> Vec<f64> {
        let description = self.mechanism.description();
        let turns = |(i, (end, first)): (usize, (&f64, &f64))| {
            if description.is_angle(i) { ((end - first) / TAU).round() } else { 0.0 }
        };
        at.end.q.iter().zip(&at.first.q).enumerate().map(turns).collect()
    }

    /// The sizes of the given values over a period: the largest values of coordinates and rates.
    fn ranges(&self, orbit: &Orbit, first: &State) -> Result<Vec<f64>, NoSteadyMotion> {
        let mut largest =
            self.places.iter().map(|place| place.value_in([&first.q, &first.qd]).abs()).collect::<Vec<_>>();
        for at in self.states_along(orbit, first)? {
            for (largest, place) in largest.iter_mut().zip(&self.places) {
                *largest = largest.max(place.value_in([&at.q, &at.qd]).abs());
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
    pub(super) fn states_along(&self, orbit: &Orbit, first: &State) -> Result<Vec<State>, NoSteadyMotion> {
        let times = (1..=PLACES).map(|place| orbit.period * f64::from(place) / f64::from(PLACES + 1));
        self.states_at(orbit, first, &times.collect::<Vec<_>>())
    }

    /// The states at some times of a period.
    pub(super) fn states_at(&self, orbit: &Orbit, first: &State, times: &[f64]) -> Result<Vec<State>, NoSteadyMotion> {
        let mechanism = self.mechanism(orbit);
        let failed = |error| NoSteadyMotion::Motion(SensitivityError::Step { t: first.t, error });
        let mut integrator = Integrator::new(&*mechanism, self.settings(orbit), first, orbit.period).map_err(failed)?;
        let (mut from, mut to) = (first.clone(), first.clone());
        let mut states = Vec::new();
        for t in times {
            std::mem::swap(&mut from, &mut to);
            integrator.advance(&*mechanism, &from, *t, &mut to).map_err(failed)?;
            states.push(to.clone());
        }
        Ok(states)
    }

    /// The mechanism with the parameter of an orbit.
    pub(super) fn mechanism(&self, orbit: &Orbit) -> OwnedOr<'a> {
        let varied = self.varied.as_ref();
        varied.map_or(OwnedOr::Borrowed(self.mechanism), |varied| OwnedOr::Owned(varied.mechanism(orbit.parameter)))
    }

    /// Demands a number of steps in a period.
    pub(super) fn demand_steps(&mut self, count: f64) {
        self.least_steps = self.least_steps.max(count);
    }

    /// The method, for a period of an orbit.
    pub(super) fn settings(&self, orbit: &Orbit) -> MethodSettings {
        let mut settings = self.settings;
        let bounds = &mut settings.step_bounds;
        bounds.longest = bounds.longest.min(orbit.period / self.least_steps);
        settings
    }

    pub(super) fn places(&self) -> &[Place] {
        &self.places
    }

    /// The sizes of the given values.
    pub(super) fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// The sizes of the unknowns.
    pub(super) fn unknown_sizes(&self) -> &[f64] {
        &self.unknown_sizes
    }

    pub(super) fn phase(&self) -> Option<usize> {
        self.phase
    }

    pub(super) fn follow(&self, orbit: &Orbit, is_halved: bool) -> Result<EndByStart, NoSteadyMotion> {
        let motion = MotionByStart {
            settings: self.settings(orbit),
            start: &orbit.start,
            parameter: self.varied.as_ref().map(|varied| (varied.parameter, varied.replace)),
            end_time: orbit.period,
            is_halved,
            keep_running: self.keep_running,
        };
        Ok(end_by_start(&*self.mechanism(orbit), self.tape, &motion)?)
    }

    /// The derivatives of the given values at the end by those at the start, column by column.
    pub(super) fn jacobian(&self, at: &EndByStart) -> DMatrix<f64> {
        DMatrix::from_fn(self.places.len(), self.places.len(), |row, column| self.by(at, row, column))
    }

    fn by(&self, at: &EndByStart, row: usize, column: usize) -> f64 {
        let [q, qd] = &at.by[column];
        self.places[row].value_in([q, qd])
    }

    /// The derivatives of the given values at the end by time.
    pub(super) fn rates(&self, at: &EndByStart) -> DVector<f64> {
        DVector::from_fn(self.places.len(), |row, _| self.places[row].value_in([&at.end.qd, &at.end.qdd]))
    }

    /// The differences between end and start, in parts of the sizes.
    pub(super) fn residuals(&self, at: &EndByStart) -> DVector<f64> {
        DVector::from_fn(self.places.len(), |row, _| {
            let place = self.places[row];
            let turns = if place.is_rate { 0.0 } else { TAU * self.turns[place.coordinate] };
            let [end, first] = [&at.end, &at.first].map(|at| place.value_in([&at.q, &at.qd]));
            (end - turns - first) / self.sizes[row]
        })
    }

    /// The derivatives of the residuals by the unknowns in parts of their sizes; the last column is that of the varied
    /// parameter.
    pub(super) fn residuals_by(&self, orbit: &Orbit, at: &EndByStart) -> DMatrix<f64> {
        let count = self.places.len();
        let rates = self.rates(at);
        let by_parameter = self.varied.as_ref().map_or(0.0, |varied| varied.period_by(orbit.parameter));
        DMatrix::from_fn(count, self.unknown_sizes.len(), |row, column| {
            let entry = if column == count {
                self.by(at, row, column) + rates[row] * by_parameter
            } else if self.phase == Some(column) {
                rates[row]
            } else {
                self.by(at, row, column) - f64::from(u8::from(row == column))
            };
            entry * self.unknown_sizes[column] / self.sizes[row]
        })
    }

    /// The unknowns of an orbit in parts of their sizes.
    pub(super) fn unknowns(&self, orbit: &Orbit) -> DVector<f64> {
        DVector::from_fn(self.unknown_sizes.len(), |column, _| {
            let value = match self.places.get(column) {
                None => orbit.parameter,
                Some(_) if self.phase == Some(column) => orbit.period,
                Some(place) => place.value_in([&orbit.start.q, &orbit.start.qd]),
            };
            value / self.unknown_sizes[column]
        })
    }

    /// An orbit moved by a part of a step, in parts of the sizes; `None` if it cannot be assembled, or its period is
    /// far from that of the motion nearby. A step of the given values alone keeps the parameter.
    pub(super) fn moved(&self, orbit: &Orbit, step: &DVector<f64>, part: f64) -> Option<Orbit> {
        let mut moved = orbit.clone();
        for (column, step) in step.iter().enumerate() {
            let change = part * step * self.unknown_sizes[column];
            match self.places.get(column) {
                None => moved.parameter += change,
                Some(_) if self.phase == Some(column) => moved.period += change,
                Some(place) if place.is_rate => moved.start.qd[place.coordinate] += change,
                Some(place) => moved.start.q[place.coordinate] += change,
            }
        }
        let parameter = moved.parameter;
        let moved = self.with_parameter(moved, parameter)?;
        let [least, most] = NEAR.map(|part| part * self.period_nearby);
        let is_near = self.phase.is_none() || least < moved.period && moved.period < most;
        is_near.then_some(moved)
    }

    /// An orbit with another value of the parameter, with its period and closed loops; `None` if there is none.
    pub(super) fn with_parameter(&self, mut orbit: Orbit, parameter: f64) -> Option<Orbit> {
        orbit.parameter = parameter;
        if let Some(period) = self.varied.as_ref().and_then(|varied| varied.period) {
            orbit.period = period(parameter)?;
        }
        orbit.start = closed(&*self.mechanism(&orbit), orbit.start)?;
        Some(orbit)
    }

    /// The fastest given rate at both ends of a motion.
    fn fastest(&self, at: &EndByStart) -> f64 {
        let rates = self.places.iter().filter(|place| place.is_rate);
        let at_ends = rates.flat_map(|place| [&at.first, &at.end].map(|at| at.qd[place.coordinate]));
        largest_of(&at_ends.collect::<Vec<f64>>())
    }

    /// Takes an orbit as the motion nearby; true if sizes have grown with it.
    pub(super) fn move_to(&mut self, orbit: &Orbit, at: &EndByStart) -> bool {
        (self.period_nearby, self.rate_nearby) = (orbit.period, self.fastest(at));
        let mut has_grown = false;
        for (row, place) in self.places.iter().enumerate() {
            // The size of an angle is a radian.
            let is_angle = !place.is_rate && self.mechanism.description().is_angle(place.coordinate);
            let value = place.value_in([&at.first.q, &at.first.qd]).abs();
            if !is_angle && value > GROWN * self.sizes[row] {
                self.sizes[row] = value;
                has_grown = true;
                if self.phase != Some(row) {
                    self.unknown_sizes[row] = value;
                }
            }
        }
        has_grown
    }

    /// Returns an error if the coordinate of the phase hardly moves at the start, or moves the other way than on the
    /// motion before: it tells no phase.
    pub(super) fn check_phase(&self, before: &EndByStart, at: &EndByStart) -> Result<(), NoSteadyMotion> {
        let Some(phase) = self.phase else { return Ok(()) };
        let coordinate = self.places[phase].coordinate;
        let way = at.end.qd[coordinate] * before.end.qd[coordinate].signum() * self.period_nearby / TAU;
        if way < HARDLY * self.sizes[phase] { Err(NoSteadyMotion::PhaseTurnsBack { coordinate }) } else { Ok(()) }
    }

    /// Returns an error if a motion with a period of its own has become much slower than the motion nearby.
    pub(super) fn check_moves(&self, at: &EndByStart) -> Result<(), NoSteadyMotion> {
        let is_at_rest = self.phase.is_some() && self.fastest(at) < REST * self.rate_nearby;
        if is_at_rest { Err(NoSteadyMotion::LeadsToRest) } else { Ok(()) }
    }
}

/// The size of the largest of some numbers; not a number if one is none.
pub(super) fn largest_of(numbers: &[f64]) -> f64 {
    if numbers.iter().any(|number| number.is_nan()) {
        return f64::NAN;
    }
    numbers.iter().fold(0.0, |most, number| most.max(number.abs()))
}
