//! Whether all of a motion repeats after its period, and not only the given values.

use std::f64::consts::TAU;

use super::error::NoSteadyMotion;
use super::newton::Found;
use super::return_map::{ReturnMap, largest_of};
use qrm_core::Mechanism;

use crate::analysis::revolution::wrap_angle;
use crate::analysis::sensitivity::EndByStart;
use crate::solve::{Matrix, Solver};
use crate::state::State;

/// The largest difference between the ends of a period that belong to one position, relative to sizes.
const SAME: f64 = 1e-6;

/// Checks that a motion repeats after its period, and so do the loads after these numbers of periods.
///
/// # Errors
/// A coordinate is elsewhere, or the loads are others.
pub(super) fn check_repetition(map: &ReturnMap, found: &Found, periods: &[u32]) -> Result<(), NoSteadyMotion> {
    check_position(map, found)?;
    periods.iter().try_for_each(|periods| check_loads(map, found, f64::from(*periods)))
}

/// Checks that coordinates that are not given return too.
///
/// # Errors
/// One is elsewhere.
pub(super) fn check_position(map: &ReturnMap, found: &Found) -> Result<(), NoSteadyMotion> {
    let EndByStart { first, end, .. } = &found.at;
    let mechanism = map.mechanism(&found.orbit);
    let description = mechanism.description();
    let size = size_of_lengths(map, found);
    for (coordinate, quantity) in description.coordinates.iter().enumerate() {
        let difference = wrap_angle(end.q[coordinate] - first.q[coordinate], quantity.unit);
        if difference.abs() > SAME * if description.is_angle(coordinate) { 1.0 } else { size } {
            return Err(NoSteadyMotion::OtherBranch { coordinate, difference });
        }
    }
    Ok(())
}

/// The largest length or size of a given value, rates as lengths.
fn size_of_lengths(map: &ReturnMap, found: &Found) -> f64 {
    let first = &found.at.first;
    let travel = found.orbit.period / TAU;
    let lengths = first.q.iter().copied().chain(first.qd.iter().map(|qd| qd * travel));
    lengths.chain(map.sizes().iter().copied()).fold(0.0_f64, |most, q| most.max(q.abs()))
}

/// Compares accelerations and multipliers along the period with those some periods later. A jump of a load may lie on
/// either side of a single place.
fn check_loads(map: &ReturnMap, found: &Found, periods: f64) -> Result<(), NoSteadyMotion> {
    let first = &found.at.first;
    let mechanism = map.mechanism(&found.orbit);
    let turns = map.turns_of(&found.at);
    let failed = |error| NoSteadyMotion::Settling { t: first.t, error };
    let mut solver = Solver::new(&*mechanism);
    let n = first.q.len();
    // The largest of all accelerations and of all multipliers, and each pair of values. Rates and masses show which
    // are rounding errors.
    let mut mass_matrix = Matrix::zero(n, n);
    mechanism.mass_matrix(&first.q, mass_matrix.entries_mut());
    let of_rates = largest_of(&first.qd).max(largest_of(&found.at.end.qd)) * TAU / found.orbit.period;
    let mut largest = [of_rates, of_rates * largest_of(mass_matrix.entries())];
    let mut pairs = Vec::new();
    for (place, to) in map.states_along(&found.orbit, first)?.into_iter().enumerate() {
        let mut later = State { t: to.t + periods * found.orbit.period, ..to.clone() };
        later.q.iter_mut().zip(&turns).for_each(|(q, turns)| *q += periods * TAU * turns);
        solver.complete(&*mechanism, &mut later).map_err(failed)?;
        let values = |at: &State| [&at.qdd[..], &at.multipliers[..]].concat();
        for (i, values) in values(&to).into_iter().zip(values(&later)).enumerate() {
            let largest = &mut largest[usize::from(i >= n)];
            *largest = largest.max(values.0.abs()).max(values.1.abs());
            pairs.push((place, i, values));
        }
    }
    let differs =
        |(_, i, (a, b)): &&(usize, usize, (f64, f64))| !((a - b).abs() <= SAME * largest[usize::from(*i >= n)]);
    let mut different = pairs.iter().filter(differs);
    match different.next().filter(|(place, ..)| different.any(|(other, ..)| other != place)) {
        None => Ok(()),
        Some((_, i, values)) => Err(NoSteadyMotion::LoadsDiffer {
            quantity: if *i < n { Ok(*i) } else { Err(i - n) },
            values: [values.0, values.1],
        }),
    }
}

/// The number of times that a motion of so many cycles repeats within its period.
///
/// # Errors
/// The motion cannot be followed.
pub(super) fn repetitions(map: &ReturnMap, found: &Found, cycles: u32) -> Result<u32, NoSteadyMotion> {
    let first = &found.at.first;
    let mechanism = map.mechanism(&found.orbit);
    let description = mechanism.description();
    let turns = map.turns_of(&found.at);
    let travel = found.orbit.period / TAU;
    let size = size_of_lengths(map, found);
    let divisors = (2..=cycles).rev().filter(|parts| cycles.is_multiple_of(*parts));
    for parts in divisors {
        let time = found.orbit.period / f64::from(parts);
        let at = &map.states_at(&found.orbit, first, &[time])?[0];
        let returns = |i: usize| {
            let part = turns[i] / f64::from(parts);
            let size = if description.is_angle(i) { 1.0 } else { size };
            let [q, qd] = [at.q[i] - first.q[i] - TAU * part, at.qd[i] - first.qd[i]];
            part.fract() == 0.0 && q.abs() <= SAME * size && qd.abs() * travel <= SAME * size.max(1.0)
        };
        if (0..turns.len()).all(returns) && has_same_loads(&*mechanism, [first, at])? {
            return Ok(parts);
        }
    }
    Ok(1)
}

/// Whether accelerations are the same at two states.
fn has_same_loads(mechanism: &dyn Mechanism, [first, at]: [&State; 2]) -> Result<bool, NoSteadyMotion> {
    let mut same = State { t: at.t, ..first.clone() };
    let failed = |error| NoSteadyMotion::Settling { t: at.t, error };
    Solver::new(mechanism).complete(mechanism, &mut same).map_err(failed)?;
    let largest = largest_of(&first.qdd).max(largest_of(&same.qdd));
    Ok(first.qdd.iter().zip(&same.qdd).all(|(a, b)| (a - b).abs() <= SAME * largest))
}
