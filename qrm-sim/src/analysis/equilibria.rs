//! Equilibria: positions at which a mechanism stays at rest under its loads.

mod search;
mod starts;

use qrm_core::{Mechanism, Tape};

use super::modes::{NoModes, RestEquations};
use crate::position::{LoopSolver, Position, Start, assemble};
use crate::solve::constraint_rank;
use search::Search;

/// A position at which a mechanism stays at rest, with no force but its loads at `t = 0`.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// The coordinates.
    pub q: Vec<f64>,
    /// The multipliers.
    pub multipliers: Vec<f64>,
    /// The largest generalized force on an independent coordinate that is not balanced.
    pub residual: f64,
    /// The number of iterations of Newton's method.
    pub iterations: u32,
    /// Whether they began at the start.
    pub is_from_start: bool,
    /// The coordinates that the start gives: the independent ones where they are a good choice.
    pub(super) preferred: Vec<bool>,
}

/// Finds the equilibrium near a start, which is that of the scene if `None`, by Newton's method in independent
/// coordinates.
///
/// [`static_equilibrium`](super::static_equilibrium) is another question: which forces hold a given position.
///
/// # Errors
/// No equilibrium is near, or none exists: see [`NoModes`].
pub fn equilibrium(mechanism: &dyn Mechanism, tape: &Tape, start: Option<Start>) -> Result<Equilibrium, NoModes> {
    let mut search = prepared(mechanism, tape, start)?;
    let from = search.from.clone();
    search.newton(&from)
}

/// Finds the equilibria of a mechanism by Newton's method from many positions, in the order of their distance from the
/// start. The given coordinates of these positions fill a turn of angles, and lengths around the start, evenly; the
/// mechanism moves to them without being taken apart. With more than eight degrees of freedom the equilibrium near the
/// start is the only one that is sought.
///
/// # Errors
/// None is found: see [`NoModes`].
pub fn equilibria(mechanism: &dyn Mechanism, tape: &Tape, start: Option<Start>) -> Result<Vec<Equilibrium>, NoModes> {
    let mut search = prepared(mechanism, tape, start)?;
    let from = search.from.clone();
    let first = search.newton(&from);
    let mut found: Vec<Equilibrium> = first.iter().cloned().collect();
    for position in starts::positions(mechanism, &search)? {
        if let Ok(other) = search.newton(&position)
            && !found.iter().any(|known| search.is_same(known, &other))
        {
            found.push(Equilibrium { is_from_start: false, ..other });
        }
    }
    if found.is_empty() {
        return first.map(|only| vec![only]);
    }
    let distances: Vec<f64> = found.iter().map(|own| search.distance(&own.q, &from)).collect();
    let mut places: Vec<usize> = (0..found.len()).collect();
    places.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
    // The one that the start leads to is the first.
    if first.is_ok() {
        places.retain(|place| *place != 0);
        places.insert(0, 0);
    }
    Ok(places.into_iter().map(|place| found[place].clone()).collect())
}

/// The search from the assembled start.
fn prepared<'m>(mechanism: &'m dyn Mechanism, tape: &'m Tape, start: Option<Start>) -> Result<Search<'m>, NoModes> {
    let [n, m] = [mechanism.description().coordinates.len(), mechanism.description().constraints.len()];
    let mut start = start.unwrap_or_else(|| Start::new(mechanism));
    if mechanism.is_driven() {
        return Err(if n == m { NoModes::NoFreedom } else { NoModes::Driven });
    }
    // A position at rest: rates of the start do not matter.
    start.qd.fill(0.0);
    let (q, _) = assemble(mechanism, start.clone()).map_err(NoModes::NotAssembled)?;
    let rank = constraint_rank(mechanism, 0.0, &q);
    if rank < m {
        return Err(NoModes::Redundant { rank });
    }
    if n == m {
        return Err(NoModes::NoFreedom);
    }
    Ok(Search::new(RestEquations::new(mechanism, tape), start.given, q))
}

/// The closed position near a guess with these coordinates held.
fn closed(mechanism: &dyn Mechanism, held: Vec<bool>, guess: Vec<f64>) -> Option<Position> {
    LoopSolver::new(mechanism, held)?.solve_loops(guess)
}
