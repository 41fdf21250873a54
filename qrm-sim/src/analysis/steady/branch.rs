//! A branch of steady motions over a parameter.

use nalgebra::DVector;
use qrm_core::{Model, ParameterOverrides};

use super::error::NoSteadyMotion;
use super::newton::Equations;
use super::repetition::check_repetition;
use super::special_point::special_point;
use super::tangent::{BENT, SHORTEST, Tangent};
use super::varied::Varied;
use super::{SteadyMotion, SteadyRequest, periods_to_compare, search};

/// A request for a branch of steady motions.
#[derive(Clone, Default)]
pub struct BranchRequest<'a> {
    /// The search for the first motion, at the value that replaces the parameter, or that of the scene.
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

/// The first and the longest step along a branch, in parts of the sizes and of the range.
const FIRST: f64 = 0.01;
const LONGEST: f64 = 0.1;
/// The least cosine of the angle between the directions at neighbouring points that allows longer steps.
const STRAIGHT: f64 = 0.995;
/// The most iterations of Newton's method that allow longer steps.
const FEW: u32 = 4;

/// Follows the steady motion of a mechanism over a parameter, by steps along the arc of the branch (Keller's
/// pseudo-arclength continuation), around folds.
///
/// The unknowns are those of [`steady_motion`](super::steady_motion) and the parameter. A step along the tangent
/// predicts the next point; Newton's method finds it on the plane across the tangent. Between neighbouring points,
/// folds are zeros of the tangent's component along the parameter, period doublings of `det(M + I)`, Neimark-Sacker
/// points of the product of all `m_i m_j - 1`, and branch points of the determinant of the equations with the tangent;
/// `M` is the matrix of the return map, and `m` are its eigenvalues. `point` takes the points in their order.
///
/// # Errors
/// The first motion is not found, or the search is interrupted: see [`NoSteadyMotion`].
///
/// # Panics
/// There is no such parameter.
pub fn steady_branch(
    model: &Model,
    replace: ParameterOverrides,
    request: &BranchRequest,
    point: &mut dyn FnMut(BranchPoint),
) -> Result<BranchEnd, NoSteadyMotion> {
    let mechanism = &*model.mechanism(replace);
    let from = mechanism.parameters()[request.parameter];
    if from == request.to {
        return Err(NoSteadyMotion::NoRange);
    }
    let cycles = f64::from(request.steady.cycles.max(1));
    let of_cycles = request.period.map(|period| move |value: f64| Some(period(value)? * cycles));
    let period = of_cycles.as_ref().map(|period| period as &dyn Fn(f64) -> Option<f64>);
    let size = (request.to - from).abs();
    let varied = Varied { model, replace, parameter: request.parameter, size, period };
    let steady = match request.period {
        Some(period) => SteadyRequest { period: period(from), ..request.steady.clone() },
        None => request.steady.clone(),
    };
    let (mut map, guess) = search(mechanism, model.tape(), &steady, Some(varied))?;
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
