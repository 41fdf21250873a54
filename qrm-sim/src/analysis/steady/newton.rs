//! Newton's method on the return map.

use nalgebra::linalg::SVD;
use nalgebra::{DMatrix, DVector, Dyn};

use super::error::NoSteadyMotion;
use super::return_map::{Orbit, ReturnMap, largest_of};
use crate::analysis::sensitivity::EndByStart;

/// A solution.
#[derive(Clone)]
pub(super) struct Found {
    pub(super) orbit: Orbit,
    /// The motion over a period from there, with derivatives.
    pub(super) at: EndByStart,
    pub(super) residual: f64,
    /// Whether the equations are singular: other motions are near.
    pub(super) is_singular: bool,
    /// The last step of Newton's method, which was not made: rounding errors.
    pub(super) last_step: DVector<f64>,
    pub(super) iterations: u32,
}

/// A plane in which the unknowns and the varied parameter are sought, in parts of their sizes.
pub(super) struct Plane {
    pub(super) normal: DVector<f64>,
    /// Some point of the plane.
    pub(super) point: DVector<f64>,
}

/// The equations of a periodic motion. Without a plane the varied parameter keeps its value.
pub(super) struct Equations<'m, 'a> {
    pub(super) map: &'m ReturnMap<'a>,
    /// Whether steps are half as long.
    pub(super) is_halved: bool,
    pub(super) plane: Option<&'m Plane>,
}

/// The most iterations of Newton's method, and the most halvings of a step; and those on a plane, where the guess is
/// near.
const MOST_ITERATIONS: u32 = 25;
const MOST_HALVINGS: u32 = 8;
const MOST_ITERATIONS_NEARBY: u32 = 8;
const MOST_HALVINGS_NEARBY: u32 = 2;
/// The most rotations for singular values, which is never reached.
pub(super) const MOST_ROTATIONS: usize = 10_000;
/// A step below this part of the sizes is the last one, and so is one that does not become smaller below the other.
const CONVERGED: f64 = 1e-14;
const SETTLED: f64 = 1e-8;
/// The largest residual of a solution, and one that is left by rounding errors.
const CLOSED: f64 = 1e-7;
const ROUNDED: f64 = 1e-9;
/// Singular values of the linearized equations below this part of the largest belong to families of motions; or below
/// this multiple of the tolerance.
const FAMILY: f64 = 1e-8;
const LOOSER: f64 = 100.0;
/// The largest such part while residuals are large.
const ACROSS: f64 = 0.1;
/// The longest step, in parts of the sizes.
const LONGEST: f64 = 3.0;

impl Equations<'_, '_> {
    /// Solves the equations from a guess.
    ///
    /// # Errors
    /// Newton's method does not converge, or a motion cannot be followed.
    pub(super) fn solve(&self, guess: Orbit) -> Result<Found, NoSteadyMotion> {
        let mut orbit = guess;
        let mut at = self.map.follow(&orbit, self.is_halved)?;
        let mut before = f64::INFINITY;
        let family = FAMILY.max(LOOSER * self.map.settings(&orbit).tolerance);
        let most = if self.plane.is_some() { MOST_ITERATIONS_NEARBY } else { MOST_ITERATIONS };
        for iterations in 1..=most {
            let residuals = self.residuals(&orbit, &at);
            let residual = largest_of(residuals.as_slice());
            let linearized = self.linearized(&orbit, &at)?;
            let step = linearized.step(&residuals, family);
            let size = largest_of(step.as_slice());
            let is_settled = size <= CONVERGED || size < SETTLED && size > 0.5 * before;
            let next = if is_settled || residuals.is_empty() {
                None
            } else {
                // Far from a family of solutions the equations are nearly singular: a step across it leads there.
                let parts = [family, residual.clamp(family, ACROSS.max(family))];
                self.moved_along((&orbit, &residuals), &linearized, parts)?
            };
            match next {
                Some(next) => (orbit, at) = next,
                // Only rounding errors are left, which nearly singular equations make a long step of.
                None if residual < ROUNDED || size < SETTLED && residual < CLOSED => {
                    self.map.check_moves(&at)?;
                    let is_singular = linearized.is_singular(family);
                    return Ok(Found { orbit, at, residual, is_singular, last_step: step, iterations });
                }
                None => break,
            }
            before = size;
        }
        self.map.check_moves(&at)?;
        let residual = largest_of(self.map.residuals(&at).as_slice());
        Err(NoSteadyMotion::NotFound { residual, start: Box::new(orbit.start), period: orbit.period })
    }

    /// The orbit after the first step, or part of one, that makes the next step of the same equations smaller
    /// (Deuflhard's natural monotonicity test); `None` if there is none. Steps leave out directions with singular
    /// values up to these parts of the largest.
    ///
    /// # Errors
    /// The caller wanted no more.
    fn moved_along(
        &self,
        (orbit, residuals): (&Orbit, &DVector<f64>),
        linearized: &Linearized,
        parts: [f64; 2],
    ) -> Result<Option<(Orbit, EndByStart)>, NoSteadyMotion> {
        let most = if self.plane.is_some() { MOST_HALVINGS_NEARBY } else { MOST_HALVINGS };
        let distinct = if parts[0] == parts[1] { 1 } else { 2 };
        for least in parts.into_iter().take(distinct) {
            let step = linearized.step(residuals, least);
            let size = largest_of(step.as_slice());
            let mut part = (LONGEST / size).min(1.0);
            for _ in 0..most {
                if let Some(tried) = self.map.moved(orbit, &step, part) {
                    match self.map.follow(&tried, self.is_halved) {
                        Ok(at) => {
                            let found = self.residuals(&tried, &at);
                            let next = linearized.step(&found, least);
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

    /// The residuals of the return map, and the distance from the plane.
    fn residuals(&self, orbit: &Orbit, at: &EndByStart) -> DVector<f64> {
        let mut residuals = self.map.residuals(at);
        if let Some(Plane { normal, point }) = self.plane {
            let distance = normal.dot(&(self.map.unknowns(orbit) - point));
            residuals = residuals.push(distance);
        }
        residuals
    }

    fn linearized(&self, orbit: &Orbit, at: &EndByStart) -> Result<Linearized, NoSteadyMotion> {
        let by = self.map.residuals_by(orbit, at);
        let rows = by.nrows();
        let matrix = match self.plane {
            None => by.columns(0, rows).into_owned(),
            Some(plane) => bordered(by, &plane.normal),
        };
        if matrix.is_empty() {
            return Ok(Linearized(None));
        }
        let svd = SVD::try_new(matrix, true, true, f64::EPSILON, MOST_ROTATIONS);
        svd.map(|svd| Linearized(Some(svd))).ok_or(NoSteadyMotion::NoEigenvalues)
    }
}

/// A matrix with one row more.
pub(super) fn bordered(matrix: DMatrix<f64>, row: &DVector<f64>) -> DMatrix<f64> {
    let rows = matrix.nrows();
    let mut bordered = matrix.insert_row(rows, 0.0);
    bordered.row_mut(rows).copy_from(&row.transpose());
    bordered
}

/// The linearized equations in parts of the sizes: their singular values; `None` without unknowns.
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
