//! A point of a branch with the direction of the branch.

use nalgebra::linalg::SVD;
use nalgebra::{Complex, DMatrix, DVector};

use super::branch::{BranchPoint, PointKind};
use super::error::NoSteadyMotion;
use super::motion;
use super::multipliers::values;
use super::newton::{Equations, Found, MOST_ROTATIONS, Plane, bordered};
use super::repetition::check_repetition;
use super::return_map::{Orbit, ReturnMap};
use super::solution::Solution;

/// The least cosine of the angle between the directions at neighbouring points.
pub(super) const BENT: f64 = 0.95;
/// The shortest step along a branch, in parts of the sizes and of the range.
pub(super) const SHORTEST: f64 = 1e-6;
/// The largest distance between neighbouring points, in steps: a farther one lies on another branch.
const FARTHER: f64 = 1.2;
/// Near a fold the cosine between the branch and the axis of the parameter is less: errors are given along the branch.
const STEEP: f64 = 1e-3;

/// A point with the direction of the branch there.
#[derive(Clone)]
pub(super) struct Tangent {
    pub(super) found: Found,
    pub(super) unknowns: DVector<f64>,
    /// The direction, of length one.
    pub(super) direction: DVector<f64>,
    /// The values that change their signs at special points: fold, period doubling, Neimark-Sacker, branch point.
    pub(super) tests: [f64; 4],
}

pub(super) const KINDS: [PointKind; 4] =
    [PointKind::Fold, PointKind::PeriodDoubling, PointKind::Torus, PointKind::BranchPoint];

impl Tangent {
    /// The direction at a solution, on the side of the one before it, or else with this sign of the parameter.
    pub(super) fn new(
        map: &ReturnMap,
        found: Found,
        before: Option<&DVector<f64>>,
        sign: f64,
    ) -> Result<Self, NoSteadyMotion> {
        let by = map.residuals_by(&found.orbit, &found.at);
        let count = by.ncols();
        let padded = bordered(by.clone(), &DVector::zeros(count));
        let svd = SVD::try_new(padded, false, true, f64::EPSILON, MOST_ROTATIONS);
        let rows = svd.ok_or(NoSteadyMotion::NoEigenvalues)?;
        let least = rows.singular_values.imin();
        let right = rows.v_t.ok_or(NoSteadyMotion::NoEigenvalues)?;
        let mut direction: DVector<f64> = right.row(least).transpose();
        let side = before.map_or(sign * direction[count - 1], |before| before.dot(&direction));
        if side < 0.0 {
            direction.neg_mut();
        }
        let multipliers = values(map, &found.at)?;
        let tests = [direction[count - 1], doubling(&multipliers), torus(&multipliers), determinant(by, &direction)];
        Ok(Self { unknowns: map.unknowns(&found.orbit), found, direction, tests })
    }

    /// The end of the range that a step would pass.
    pub(super) fn bound(&self, range: [f64; 2], length: f64, map: &ReturnMap) -> Option<f64> {
        let slope = self.direction[self.direction.len() - 1];
        let size = map.unknown_sizes().last().copied().unwrap_or(1.0);
        let at = self.found.orbit.parameter;
        let reached = at + length * slope * size;
        // The first point lies on an end.
        let passes = |end: &f64| (reached - end) * (at - end) <= 0.0 && (end - at) * slope > 0.0;
        range.into_iter().find(passes)
    }

    /// The end of the range behind which another point lies.
    pub(super) fn passed_end(&self, range: [f64; 2], next: &Self) -> Option<f64> {
        let reached = next.found.orbit.parameter;
        let (low, high) = (range[0].min(range[1]), range[0].max(range[1]));
        if reached < low {
            Some(low)
        } else if reached > high {
            Some(high)
        } else {
            None
        }
    }

    /// The point at a distance along the branch, or at a value of the parameter.
    pub(super) fn next(&self, map: &ReturnMap, length: f64, bound: Option<f64>) -> Result<Self, NoSteadyMotion> {
        let count = self.direction.len();
        let length = match bound {
            Some(bound) => {
                let size = map.unknown_sizes()[count - 1];
                (bound - self.found.orbit.parameter) / (size * self.direction[count - 1])
            }
            None => length,
        };
        let lost = || NoSteadyMotion::NotFound {
            residual: f64::NAN,
            start: Box::new(self.found.orbit.start.clone()),
            period: self.found.orbit.period,
        };
        let mut guess = map.moved(&self.found.orbit, &self.direction, length).ok_or_else(lost)?;
        let found = match bound {
            Some(bound) => {
                guess = map.with_parameter(guess, bound).ok_or_else(lost)?;
                Equations { map, is_halved: false, plane: None }.solve(guess)?
            }
            None => self.solve(map, guess, length, false)?,
        };
        map.check_phase(&self.found.at, &found.at)?;
        check_repetition(map, &found, &[1])?;
        let next = Self::new(map, found, Some(&self.direction), 1.0)?;
        let distance = (&next.unknowns - &self.unknowns).norm();
        if distance <= FARTHER * length.abs().max(SHORTEST) { Ok(next) } else { Err(lost()) }
    }

    /// The solution on the plane across the branch at a distance.
    pub(super) fn solve(
        &self,
        map: &ReturnMap,
        guess: Orbit,
        length: f64,
        is_halved: bool,
    ) -> Result<Found, NoSteadyMotion> {
        let plane = Plane { normal: self.direction.clone(), point: &self.unknowns + &self.direction * length };
        Equations { map, is_halved, plane: Some(&plane) }.solve(guess)
    }

    /// The kinds of special points between two points.
    pub(super) fn passed(&self, next: &Self) -> Vec<PointKind> {
        let passed = |(kind, (a, b)): (PointKind, (&f64, &f64))| {
            (a.is_finite() && b.is_finite() && (*a < 0.0) != (*b < 0.0)).then_some(kind)
        };
        KINDS.into_iter().zip(self.tests.iter().zip(&next.tests)).filter_map(passed).collect()
    }

    /// The point with the errors of its motion.
    pub(super) fn point(&self, map: &ReturnMap, kind: PointKind) -> Result<BranchPoint, NoSteadyMotion> {
        let count = self.direction.len();
        let plane = Plane { normal: self.direction.clone(), point: self.unknowns.clone() };
        let is_steep = self.direction[count - 1].abs() < STEEP || kind != PointKind::Regular;
        let plane = is_steep.then_some(&plane);
        let solution = Solution::refine(map, self.found.clone(), plane)?;
        let parameter_error = if is_steep { solution.errors(map)[count - 1] } else { 0.0 };
        let motion = motion(map, &solution, self.found.iterations, 1)?;
        Ok(BranchPoint { parameter: self.found.orbit.parameter, parameter_error, kind, motion })
    }
}

/// `det(M + I)`.
fn doubling(multipliers: &[Complex<f64>]) -> f64 {
    multipliers.iter().map(|m| m + 1.0).product::<Complex<f64>>().re
}

/// The product of all `m_i m_j - 1`; one without pairs.
fn torus(multipliers: &[Complex<f64>]) -> f64 {
    let pairs = multipliers.iter().enumerate().flat_map(|(i, a)| multipliers[..i].iter().map(move |b| a * b - 1.0));
    pairs.product::<Complex<f64>>().re
}

/// The largest distance from the unit circle of a pair of multipliers that passes it.
const ON_CIRCLE: f64 = 1e-3;

/// Whether a pair of complex multipliers lies on the unit circle.
pub(super) fn is_on_circle(multipliers: &[Complex<f64>]) -> bool {
    multipliers.iter().any(|m| (m.norm() - 1.0).abs() < ON_CIRCLE && m.im.abs() > ON_CIRCLE)
}

/// The determinant of the equations with the direction as their last row.
fn determinant(by: DMatrix<f64>, direction: &DVector<f64>) -> f64 {
    bordered(by, direction).determinant()
}
