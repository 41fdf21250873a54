//! A branch of steady motions over a parameter.

use nalgebra::linalg::SVD;
use nalgebra::{Complex, DMatrix, DVector};
use qrm_core::{Mechanism, Tape};

use super::error::NoSteadyMotion;
use super::multipliers::values;
use super::newton::{Equations, Found, Plane, bordered};
use super::repetition::check_repetition;
use super::return_map::{Orbit, ReturnMap};
use super::solution::Solution;
use super::varied::Varied;
use super::{SteadyMotion, SteadyRequest, motion, periods_to_compare, search};

/// A request for a branch of steady motions.
#[derive(Clone, Default)]
pub struct BranchRequest<'a> {
    /// The search for the first motion, at the parameter's value in the mechanism.
    pub steady: SteadyRequest<'a>,
    /// The number of the parameter.
    pub parameter: usize,
    /// The value at the other end of the range.
    pub to: f64,
    /// The period at a value of the parameter, in s, where formulae depend on time; it replaces that of the search.
    pub period: Option<&'a dyn Fn(f64) -> Option<f64>>,
    /// The most points.
    pub most_points: usize,
}

/// A point of a branch.
#[derive(Clone, Debug)]
pub struct BranchPoint {
    /// The value of the parameter.
    pub parameter: f64,
    /// Its estimated error, at a special point or near a fold; zero at others.
    pub parameter_error: f64,
    /// What happens there.
    pub kind: PointKind,
    /// The motion.
    pub motion: SteadyMotion,
}

/// What happens at a point of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// Nothing.
    Regular,
    /// The branch turns back: two motions meet and vanish.
    Fold,
    /// A multiplier passes -1: a motion with twice the period begins.
    PeriodDoubling,
    /// A pair of complex multipliers passes the unit circle (Neimark and Sacker): a second frequency begins.
    Torus,
    /// Another branch crosses.
    BranchPoint,
}

/// Why a branch ends.
#[derive(Clone, Debug)]
pub enum BranchEnd {
    /// It comes to an end of the range.
    Reached,
    /// It has the most points that are wanted.
    MostPoints,
    /// No motion was found behind its last point.
    Lost(NoSteadyMotion),
}

/// The first, the longest and the shortest step along a branch, in parts of the sizes and of the range.
const FIRST: f64 = 0.01;
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 1e-6;
/// The least cosine of the angle between the directions at neighbouring points, and one that allows longer steps.
const BENT: f64 = 0.95;
const STRAIGHT: f64 = 0.995;
/// The largest distance between neighbouring points, in steps: a farther one lies on another branch.
const FARTHER: f64 = 1.2;
/// The most iterations of Newton's method that allow longer steps.
const FEW: u32 = 4;
/// Near a fold the cosine between the branch and the axis of the parameter is less: errors are given along the branch.
const STEEP: f64 = 1e-3;
/// The most iterations for a special point.
const MOST_ITERATIONS: u32 = 40;
/// The part of a step within which a special point is located.
const LOCATED: f64 = 1e-9;
/// Far more rotations than singular values of such matrices need.
const MOST_ROTATIONS: usize = 10_000;
/// The largest distance from the unit circle of a pair of multipliers that passes it.
const ON_CIRCLE: f64 = 1e-3;

/// Follows the steady motion of a mechanism over a parameter, by steps along the arc of the branch (Keller's
/// pseudo-arclength continuation), around folds.
///
/// The unknowns are those of [`steady_motion`](super::steady_motion) and the parameter. A step along the tangent predicts
/// the next point; Newton's method finds it on the plane across the tangent. Between neighbouring points, folds are
/// zeros of the tangent's component along the parameter, period doublings of `det(M + I)`, Neimark-Sacker points of the
/// product of all `m_i m_j - 1`, and branch points of the determinant of the equations with the tangent; `M` is the
/// matrix of the return map, and `m` are its eigenvalues. `point` takes the points in their order.
///
/// # Errors
/// The first motion is not found, or the search is interrupted: see [`NoSteadyMotion`].
///
/// # Panics
/// There is no such parameter.
pub fn steady_branch(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    request: &BranchRequest,
    point: &mut dyn FnMut(BranchPoint),
) -> Result<BranchEnd, NoSteadyMotion> {
    let from = mechanism.parameters()[request.parameter];
    if from == request.to {
        return Err(NoSteadyMotion::NoRange);
    }
    if mechanism.with_parameters(mechanism.parameters().to_vec()).is_none() {
        return Err(NoSteadyMotion::NotGenerated);
    }
    let cycles = f64::from(request.steady.cycles.max(1));
    let of_cycles = request.period.map(|period| move |value: f64| Some(period(value)? * cycles));
    let period = of_cycles.as_ref().map(|period| period as &dyn Fn(f64) -> Option<f64>);
    let varied = Varied { parameter: request.parameter, size: (request.to - from).abs(), period };
    let steady = match request.period {
        Some(period) => SteadyRequest { period: period(from), ..request.steady.clone() },
        None => request.steady.clone(),
    };
    let (mut map, guess) = search(mechanism, tape, &steady, Some(varied))?;
    let found = Equations { map: &map, is_halved: false, plane: None }.solve(guess)?;
    check_repetition(&map, &found, &periods_to_compare(&steady))?;
    if found.is_singular {
        return Err(NoSteadyMotion::OneOfMany);
    }
    let mut last = Tangent::new(&map, found, None, (request.to - from).signum())?;
    point(last.point(&map, PointKind::Regular)?);
    let (mut length, mut count) = (FIRST, 1);
    loop {
        if count >= request.most_points {
            return Ok(BranchEnd::MostPoints);
        }
        let mut bound = last.bound([from, request.to], length, &map);
        let mut next = last.next(&map, length, bound);
        // The point behind the tangent may lie beyond an end of the range.
        if let (Ok(found), None) = (&next, bound) {
            bound = last.passed_end([from, request.to], found);
            if bound.is_some() {
                next = last.next(&map, length, bound);
            }
        }
        let mut next = match next {
            Err(reason) if length < SHORTEST || matches!(reason, NoSteadyMotion::Interrupted { .. }) => {
                return lost(reason);
            }
            Err(_) => {
                length *= 0.5;
                continue;
            }
            Ok(next) if last.direction.dot(&next.direction) < BENT && length > SHORTEST => {
                length *= 0.5;
                continue;
            }
            Ok(next) => next,
        };
        let mut special = Vec::new();
        for kind in last.passed(&next) {
            special.extend(special_point(&map, [&last, &next], kind)?);
        }
        special.sort_by(|a, b| a.0.total_cmp(&b.0));
        special.into_iter().for_each(|(_, special)| point(special));
        let is_straight = last.direction.dot(&next.direction) > STRAIGHT && next.found.iterations <= FEW;
        let sizes = map.unknown_sizes().to_vec();
        if map.move_to(&next.found.orbit, &next.found.at) {
            let sizes = DVector::from_vec(sizes).component_div(&DVector::from_column_slice(map.unknown_sizes()));
            let direction = next.direction.component_mul(&sizes);
            next = match Tangent::new(&map, next.found, Some(&direction), 1.0) {
                Ok(next) => next,
                Err(reason) => return lost(reason),
            };
        }
        match next.point(&map, PointKind::Regular) {
            Ok(next) => point(next),
            Err(reason) => return lost(reason),
        }
        count += 1;
        last = next;
        if bound.is_some() {
            return Ok(BranchEnd::Reached);
        }
        if is_straight {
            length = LONGEST.min(1.5 * length);
        }
    }
}

/// The end of a branch behind which no motion was found.
///
/// # Errors
/// The caller wanted no more.
fn lost(reason: NoSteadyMotion) -> Result<BranchEnd, NoSteadyMotion> {
    match reason {
        NoSteadyMotion::Interrupted { .. } => Err(reason),
        reason => Ok(BranchEnd::Lost(reason)),
    }
}

/// A point with the direction of the branch there.
#[derive(Clone)]
struct Tangent {
    found: Found,
    unknowns: DVector<f64>,
    /// The direction, of length one.
    direction: DVector<f64>,
    /// The values that change their signs at special points: fold, period doubling, Neimark-Sacker, branch point.
    tests: [f64; 4],
}

const KINDS: [PointKind; 4] = [PointKind::Fold, PointKind::PeriodDoubling, PointKind::Torus, PointKind::BranchPoint];

impl Tangent {
    /// The direction at a solution, on the side of the one before it, or else with this sign of the parameter.
    fn new(map: &ReturnMap, found: Found, before: Option<&DVector<f64>>, sign: f64) -> Result<Self, NoSteadyMotion> {
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
    fn bound(&self, range: [f64; 2], length: f64, map: &ReturnMap) -> Option<f64> {
        let slope = self.direction[self.direction.len() - 1];
        let size = map.unknown_sizes().last().copied().unwrap_or(1.0);
        let at = self.found.orbit.parameter;
        let reached = at + length * slope * size;
        // The first point lies on an end.
        let passes = |end: &f64| (reached - end) * (at - end) <= 0.0 && (end - at) * slope > 0.0;
        range.into_iter().find(passes)
    }

    /// The end of the range behind which another point lies.
    fn passed_end(&self, range: [f64; 2], next: &Self) -> Option<f64> {
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
    fn next(&self, map: &ReturnMap, length: f64, bound: Option<f64>) -> Result<Self, NoSteadyMotion> {
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
        map.check_phase(&found.at)?;
        check_repetition(map, &found, &[1])?;
        let next = Self::new(map, found, Some(&self.direction), 1.0)?;
        let distance = (&next.unknowns - &self.unknowns).norm();
        if distance <= FARTHER * length.abs().max(SHORTEST) { Ok(next) } else { Err(lost()) }
    }

    /// The solution on the plane across the branch at a distance.
    fn solve(&self, map: &ReturnMap, guess: Orbit, length: f64, is_halved: bool) -> Result<Found, NoSteadyMotion> {
        let plane = Plane { normal: self.direction.clone(), point: &self.unknowns + &self.direction * length };
        Equations { map, is_halved, plane: Some(&plane) }.solve(guess)
    }

    /// The kinds of special points between two points.
    fn passed(&self, next: &Self) -> Vec<PointKind> {
        let passed = |(kind, (a, b)): (PointKind, (&f64, &f64))| {
            (a.is_finite() && b.is_finite() && (*a < 0.0) != (*b < 0.0)).then_some(kind)
        };
        KINDS.into_iter().zip(self.tests.iter().zip(&next.tests)).filter_map(passed).collect()
    }

    /// The point with the errors of its motion.
    fn point(&self, map: &ReturnMap, kind: PointKind) -> Result<BranchPoint, NoSteadyMotion> {
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

/// The special point between two points, and its distance from the first along its direction; `None` if it is of another
/// kind than its test.
fn special_point(
    map: &ReturnMap,
    ends: [&Tangent; 2],
    kind: PointKind,
) -> Result<Option<(f64, BranchPoint)>, NoSteadyMotion> {
    let place = KINDS.iter().position(|other| *other == kind).unwrap_or(0);
    let (own, width) = zero(map, ends, place, false)?;
    if kind == PointKind::Torus && !is_on_circle(&values(map, &own.found.at)?) {
        return Ok(None);
    }
    let (other, other_width) = zero(map, ends, place, true)?;
    let mut point = match own.point(map, kind) {
        Err(NoSteadyMotion::Interrupted { t }) => return Err(NoSteadyMotion::Interrupted { t }),
        // The equations are singular there. The point before it is known.
        Err(_) => ends[0].point(map, kind)?,
        Ok(point) => point,
    };
    let between = (other.found.orbit.parameter - own.found.orbit.parameter).abs().max(width).max(other_width);
    point.parameter_error = between.max(point.parameter_error).max(f64::EPSILON * point.parameter.abs());
    point.motion.move_by(&own.found.orbit, &other.found.orbit);
    let place = ends[0].direction.dot(&(&own.unknowns - &ends[0].unknowns));
    Ok(Some((place, point)))
}

/// The point between two others at which a test is zero (by the Illinois method), and the error of the parameter there.
/// Another branch may be near: the search ends at the last point on this one.
fn zero(map: &ReturnMap, ends: [&Tangent; 2], place: usize, is_halved: bool) -> Result<(Tangent, f64), NoSteadyMotion> {
    let [from, to] = ends;
    let whole = from.direction.dot(&(&to.unknowns - &from.unknowns));
    let mut low = End { part: 0.0, test: from.tests[place], at: from.clone() };
    let mut high = End { part: 1.0, test: to.tests[place], at: to.clone() };
    for _ in 0..MOST_ITERATIONS {
        let part = (low.part * high.test - high.part * low.test) / (high.test - low.test);
        let is_inside = low.part.min(high.part) < part && part < low.part.max(high.part);
        let part = if is_inside { part } else { 0.5 * (low.part + high.part) };
        let across = &high.at.unknowns - &low.at.unknowns;
        let between = (part - low.part) / (high.part - low.part);
        let Some(guess) = map.moved(&low.at.found.orbit, &across, between) else { break };
        let found = match from.solve(map, guess, part * whole, is_halved) {
            Err(NoSteadyMotion::Interrupted { t }) => return Err(NoSteadyMotion::Interrupted { t }),
            Err(_) => break,
            Ok(found) => found,
        };
        let at = Tangent::new(map, found, Some(&from.direction), 1.0)?;
        if at.direction.dot(&from.direction) < BENT {
            break;
        }
        let last = if high.at.tests[place].abs() < low.at.tests[place].abs() { high.part } else { low.part };
        let test = at.tests[place];
        if test == 0.0 || (part - last).abs() <= LOCATED {
            return Ok((at, 0.0));
        }
        if test * high.test <= 0.0 {
            low = std::mem::replace(&mut high, End { part, test, at });
        } else {
            // The end that stays counts half.
            low.test *= 0.5;
            high = End { part, test, at };
        }
    }
    let size = map.unknown_sizes().last().copied().unwrap_or(1.0);
    let width = (&high.at.unknowns - &low.at.unknowns).norm() * size;
    let nearest = if high.at.tests[place].abs() < low.at.tests[place].abs() { high } else { low };
    Ok((nearest.at, width))
}

/// An end of the interval in which a test changes its sign.
struct End {
    /// The distance along the first direction, in parts of the step.
    part: f64,
    /// The value of the test, or a part of it.
    test: f64,
    at: Tangent,
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

/// Whether a pair of complex multipliers lies on the unit circle.
fn is_on_circle(multipliers: &[Complex<f64>]) -> bool {
    multipliers.iter().any(|m| (m.norm() - 1.0).abs() < ON_CIRCLE && m.im.abs() > ON_CIRCLE)
}

/// The determinant of the equations with the direction as their last row.
fn determinant(by: DMatrix<f64>, direction: &DVector<f64>) -> f64 {
    bordered(by, direction).determinant()
}
