//! Special points between two points of a branch.

use super::branch::{BranchPoint, PointKind};
use super::error::NoSteadyMotion;
use super::multipliers::values;
use super::return_map::ReturnMap;
use super::tangent::{BENT, KINDS, Tangent, is_on_circle};

/// The most iterations for a special point.
const MOST_ITERATIONS: u32 = 40;
/// The most points of another branch that are met on the way.
const MOST_STRAYS: u32 = 12;
/// The part of a step within which a special point is located.
const LOCATED: f64 = 1e-9;

/// The special point between two points, and its distance from the first along its direction; `None` if it is of
/// another kind than its test.
pub(super) fn special_point(
    map: &ReturnMap,
    ends: [&Tangent; 2],
    kind: PointKind,
) -> Result<Option<(f64, BranchPoint)>, NoSteadyMotion> {
    let place = KINDS.iter().position(|other| *other == kind).unwrap_or(0);
    let own = zero(map, ends, place, false)?;
    if kind == PointKind::Torus && !is_on_circle(&values(map, &own.at.found.at)?) {
        return Ok(None);
    }
    let other = zero(map, ends, place, true)?;
    let mut point = match own.at.point(map, kind) {
        Err(NoSteadyMotion::Interrupted { t }) => return Err(NoSteadyMotion::Interrupted { t }),
        // The equations are singular there. The point before it is known.
        Err(_) => ends[0].point(map, kind)?,
        Ok(point) => point,
    };
    point.parameter = own.parameter;
    let between = (other.parameter - own.parameter).abs().max(own.error).max(other.error);
    point.parameter_error = between.max(point.parameter_error).max(f64::EPSILON * point.parameter.abs());
    point.motion.move_by(&own.at.found.orbit, &other.at.found.orbit);
    let place = ends[0].direction.dot(&(&own.at.unknowns - &ends[0].unknowns));
    Ok(Some((place, point)))
}

/// The place at which a test is zero.
struct Zero {
    /// The point, or the nearest that was found.
    at: Tangent,
    /// The parameter, and its error by what is not known of the place.
    parameter: f64,
    error: f64,
}

/// An end of the interval in which a test changes its sign.
struct End {
    /// The distance along the first direction, in parts of the step.
    part: f64,
    /// The value of the test, or a part of it.
    test: f64,
    at: Tangent,
}

/// Locates the zero of a test between two points by the Illinois method. Where another branch crosses, Newton's method
/// may lead to that one: then the interval is made smaller from its ends.
///
/// # Errors
/// The caller wanted no more, or eigenvalues cannot be computed.
fn zero(map: &ReturnMap, ends: [&Tangent; 2], place: usize, is_halved: bool) -> Result<Zero, NoSteadyMotion> {
    let [from, to] = ends;
    let whole = from.direction.dot(&(&to.unknowns - &from.unknowns));
    let mut low = End { part: 0.0, test: from.tests[place], at: from.clone() };
    let mut high = End { part: 1.0, test: to.tests[place], at: to.clone() };
    let (mut strays, mut stray, mut estimate) = (0, None::<f64>, f64::NAN);
    for _ in 0..MOST_ITERATIONS {
        let part = (low.part * high.test - high.part * low.test) / (high.test - low.test);
        let is_inside = low.part.min(high.part) < part && part < low.part.max(high.part);
        let mut part = if is_inside { part } else { 0.5 * (low.part + high.part) };
        if let Some(stray) = stray {
            // Halfway to the end that is farther.
            let [a, b] = [low.part, high.part].map(|end: f64| (end - stray).abs());
            part = 0.5 * (stray + if a > b { low.part } else { high.part });
        }
        let between = (part - low.part) / (high.part - low.part);
        let across = &high.at.unknowns - &low.at.unknowns;
        let found = match map.moved(&low.at.found.orbit, &across, between) {
            Some(guess) => from.solve(map, guess, part * whole, is_halved),
            None => break,
        };
        let at = match found {
            Err(NoSteadyMotion::Interrupted { t }) => return Err(NoSteadyMotion::Interrupted { t }),
            Err(_) => None,
            Ok(found) => Some(Tangent::new(map, found, Some(&from.direction), 1.0)?),
        };
        let Some(at) = at.filter(|at| at.direction.dot(&from.direction) >= BENT) else {
            (strays, stray) = (strays + 1, Some(part));
            if strays > MOST_STRAYS {
                break;
            }
            continue;
        };
        stray = None;
        estimate = crossing(&low.at, &high.at, place);
        let last = if high.at.tests[place].abs() < low.at.tests[place].abs() { high.part } else { low.part };
        let test = at.tests[place];
        if test == 0.0 || (part - last).abs() <= LOCATED {
            return Ok(Zero { parameter: at.found.orbit.parameter, at, error: 0.0 });
        }
        if test * high.test <= 0.0 {
            low = std::mem::replace(&mut high, End { part, test, at });
        } else {
            // The end that stays counts half.
            low.test *= 0.5;
            high = End { part, test, at };
        }
    }
    let parameter = crossing(&low.at, &high.at, place);
    let size = map.unknown_sizes().last().copied().unwrap_or(1.0);
    let width = (&high.at.unknowns - &low.at.unknowns).norm() * size;
    // As far as the last interval but one was from here; the slope of a fold is zero.
    let error = if KINDS[place] == PointKind::Fold { width } else { (parameter - estimate).abs().min(width) };
    let error = if error.is_finite() { error } else { width };
    let nearest = if high.at.tests[place].abs() < low.at.tests[place].abs() { high } else { low };
    Ok(Zero { at: nearest.at, parameter, error })
}

/// The parameter where a test would be zero if it changed evenly between two points.
fn crossing(a: &Tangent, b: &Tangent, place: usize) -> f64 {
    let [p, q] = [a, b].map(|at| at.found.orbit.parameter);
    let [f, g] = [a, b].map(|at| at.tests[place]);
    p + (q - p) * f / (f - g)
}
