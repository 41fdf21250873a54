//! Newton's method for an equilibrium.

use std::f64::consts::{PI, TAU};

use nalgebra::{Cholesky, DMatrix, DVector};

use super::{Equilibrium, closed};
use crate::analysis::modes::{NoModes, RestEquations, RestState};

/// A search for equilibria of a mechanism.
pub(super) struct Search<'m> {
    equations: RestEquations<'m>,
    /// The coordinates that the start gives.
    pub(super) preferred: Vec<bool>,
    /// The assembled start.
    pub(super) from: Vec<f64>,
}

const ITERATIONS: u32 = 100;
/// The longest step, in rad, or relative to the largest length.
const LONGEST: f64 = 0.5;
/// Steps below the first of these end the search; those below the second, where they become no shorter.
const NO_STEP: f64 = 1e-15;
const SHORT: f64 = 1e-8;
/// The number of times that a step is halved.
const HALVINGS: i32 = 12;
/// The smallest stiffness that a step divides by, in parts of the largest.
const SOFT: f64 = 1e-10;
/// Stiffnesses that are rounding errors, in parts of the largest terms.
const NO_STIFFNESS: f64 = 1e-11;
/// The largest distance of coordinates of the same equilibrium, in rad, or relative to the largest length.
const SAME: f64 = 1e-6;
/// Positions with smaller forces, in parts of their terms, need no convergence.
const BALANCED: f64 = 1e-12;

impl<'m> Search<'m> {
    pub(super) fn new(equations: RestEquations<'m>, preferred: Vec<bool>, from: Vec<f64>) -> Self {
        Self { equations, preferred, from }
    }

    /// The equilibrium near a closed position.
    ///
    /// # Errors
    /// It is not found.
    pub(super) fn newton(&mut self, from: &[f64]) -> Result<Equilibrium, NoModes> {
        let mechanism = self.equations.mechanism;
        let mut at = self.equations.at(from, &self.preferred)?;
        let mut size = force_size(&at)?;
        let mut before = f64::INFINITY;
        for iteration in 0..ITERATIONS {
            let (change, length) = step(&at)?;
            let is_balanced = at.unbalanced().amax() <= BALANCED * force_terms(&at);
            if length <= NO_STEP || length <= SHORT && length >= 0.5 * before && is_balanced {
                return Ok(self.found(at, iteration));
            }
            before = length;
            let mut next = None;
            for halving in 0..HALVINGS {
                let part = 0.5_f64.powi(halving) * (LONGEST / length).min(1.0);
                let guess = at.q.iter().zip(change.iter()).map(|(q, change)| q + part * change).collect();
                let Some(position) = closed(mechanism, at.null_space.is_independent(), guess) else { continue };
                let Ok(other) = self.equations.at(&position.q, &self.preferred) else { continue };
                let other_size = force_size(&other)?;
                if other_size < size || length <= SHORT && other_size <= 2.0 * size {
                    next = Some((other, other_size));
                    break;
                }
            }
            match next {
                Some((other, other_size)) => (at, size) = (other, other_size),
                // The forces are rounding errors.
                None if is_balanced => return Ok(self.found(at, iteration)),
                None => break,
            }
        }
        let unbalanced = at.unbalanced();
        let place = unbalanced.iamax();
        Err(NoModes::NotFound {
            coordinate: at.null_space.independent[place],
            residual: unbalanced[place].abs(),
            q: at.q,
        })
    }

    fn found(&self, at: RestState, iterations: u32) -> Equilibrium {
        Equilibrium {
            residual: at.unbalanced().amax(),
            multipliers: at.multipliers.iter().copied().collect(),
            q: at.q,
            iterations,
            is_from_start: true,
            preferred: self.preferred.clone(),
        }
    }

    /// The largest difference of coordinates, less whole turns of angles, in rad or relative to the largest length.
    pub(super) fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.difference(a, b).amax()
    }

    fn difference(&self, a: &[f64], b: &[f64]) -> DVector<f64> {
        let description = self.equations.mechanism.description();
        let lengths = (0..a.len()).filter(|&i| !description.is_angle(i));
        let length = lengths.map(|i| a[i].abs().max(b[i].abs())).fold(self.equations.length, f64::max);
        DVector::from_fn(a.len(), |i, _| {
            let difference = a[i] - b[i];
            if description.is_angle(i) { (difference + PI).rem_euclid(TAU) - PI } else { difference / length }
        })
    }

    /// Whether two equilibria are the same, or belong to the same line of them.
    pub(super) fn is_same(&mut self, known: &Equilibrium, other: &Equilibrium) -> bool {
        if self.distance(&known.q, &other.q) <= SAME {
            return true;
        }
        let Ok(at) = self.equations.at(&known.q, &self.preferred) else { return false };
        let free = free_motions(&at);
        if free.ncols() == 0 {
            return false;
        }
        if free.ncols() == at.null_space.freedom() {
            return true;
        }
        let difference = self.difference(&other.q, &known.q);
        let sizes = &at.null_space.sizes;
        let free = DMatrix::from_fn(free.nrows(), free.ncols(), |i, j| free[(i, j)] / sizes[i]);
        let nearest = free.clone().svd(true, true).solve(&difference, f64::EPSILON);
        nearest.is_ok_and(|nearest| (difference - free * nearest).amax() <= SAME)
    }
}

/// The step of Newton's method, and its largest change in rad or relative to the largest length.
fn step(at: &RestState) -> Result<(DVector<f64>, f64), NoModes> {
    let null_space = &at.null_space;
    let stiffness = null_space.reduced(&at.stiffness);
    let svd = stiffness.svd(true, true);
    let largest = svd.singular_values.amax();
    let (u, v_t) = svd.u.as_ref().zip(svd.v_t.as_ref()).ok_or(NoModes::NoEigenvalues)?;
    let along = u.transpose() * at.unbalanced();
    let softest = (SOFT * largest).max(NO_STIFFNESS * null_space.reduced(&at.stiffness_terms).amax());
    let rounding = BALANCED * force_terms(at);
    let parts = along.zip_map(&svd.singular_values, |force, stiffness| {
        if stiffness > softest {
            -force / stiffness
        } else if force.abs() <= rounding {
            0.0
        } else if softest > 0.0 {
            -force / softest
        } else {
            -LONGEST * force.signum()
        }
    });
    let change = &null_space.basis * (v_t.transpose() * parts);
    let length = (0..change.len()).map(|i| (change[i] / null_space.sizes[i]).abs()).fold(0.0, f64::max);
    if length.is_finite() { Ok((change, length)) } else { Err(NoModes::NotFinite { q: at.q.clone() }) }
}

/// The motions without stiffness, in all coordinates.
fn free_motions(at: &RestState) -> DMatrix<f64> {
    let null_space = &at.null_space;
    let terms = null_space.basis.transpose().abs() * &at.stiffness_terms * null_space.basis.abs();
    let svd = null_space.reduced(&at.stiffness).svd(false, true);
    let Some(v_t) = &svd.v_t else { return DMatrix::zeros(at.q.len(), 0) };
    let places: Vec<usize> =
        (0..v_t.nrows()).filter(|&i| svd.singular_values[i] <= NO_STIFFNESS * terms.amax()).collect();
    &null_space.basis * v_t.select_rows(&places).transpose()
}

/// The square of the acceleration that the forces give the mechanism at rest, in the metric of the masses.
fn force_size(at: &RestState) -> Result<f64, NoModes> {
    let mass = at.null_space.reduced(&at.mass);
    let factors = Cholesky::new(mass).ok_or_else(|| NoModes::Massless { q: at.q.clone() })?;
    let forces = at.unbalanced();
    Ok(forces.dot(&factors.solve(&forces)))
}

/// The largest sum of the sizes of forces on an independent coordinate.
fn force_terms(at: &RestState) -> f64 {
    let q = DVector::from_fn(at.q.len(), |i, _| at.q[i].abs().max(at.null_space.sizes[i]));
    let terms = at.forces.abs() + at.jacobian.transpose().abs() * at.multipliers.abs() + &at.stiffness_terms * q;
    (at.null_space.basis.transpose().abs() * terms).amax()
}
