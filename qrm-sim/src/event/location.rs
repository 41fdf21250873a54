//! The location of an event inside a step.

use std::convert::Infallible;

use crate::maximum::peak_between;
use crate::state::State;

/// The part of a step over which slopes are taken.
pub(crate) const SHIFT: f64 = 1e-4;
/// A value that is zero this many resolutions of the time before a zero stays there: it does not cross.
const FLAT: f64 = 16.0;

/// The state inside a step at which a value rises through zero, by steps of other lengths from its beginning.
///
/// The method is that of T. R. Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero of a
/// nonlinear function without using derivatives, Adv. Eng. Softw. 28 (1997).
///
/// # Errors
/// A step could not be made.
pub(crate) fn locate<E>(
    from: &State,
    beyond: &State,
    value: &mut dyn FnMut(&State) -> f64,
    step: &mut dyn FnMut(f64) -> Result<State, E>,
) -> Result<State, E> {
    // The zero lies between `a`, the last time, and `b`; `c` is the time before.
    let (mut b, mut f_b) = (from.t, value(from));
    let (mut a, mut f_a) = (beyond.t, value(beyond));
    let mut found = beyond.clone();
    let mut part = f_a / (f_a - f_b);
    let mut is_flat = false;
    for _ in 0..100 {
        let resolution = f64::EPSILON * a.abs().max(b.abs());
        if (a - b).abs() <= 2.0 * resolution {
            break;
        }
        if f_a == 0.0 && !is_flat {
            // A zero, or a time at which the value has been zero for a while.
            is_flat = value(&step(a - (FLAT * resolution).min((a - b).abs()))?) >= 0.0;
            if !is_flat {
                break;
            }
        }
        let shortest = (resolution / (a - b).abs()).min(0.5);
        // Written so that a part that is not a number becomes a half.
        let part_within = if part >= 0.0 && !is_flat { part.clamp(shortest, 1.0 - shortest) } else { 0.5 };
        let t = a + part_within * (b - a);
        let at = step(t)?;
        let f = value(&at);
        let (c, f_c) = if (f >= 0.0) == (f_a >= 0.0) { (a, f_a) } else { (b, f_b) };
        if (f >= 0.0) != (f_a >= 0.0) {
            (b, f_b) = (a, f_a);
        }
        (a, f_a) = (t, f);
        if f >= 0.0 {
            found = at;
        }
        part = inverse_quadratic([(a, f_a), (b, f_b), (c, f_c)]).unwrap_or(0.5);
    }
    Ok(found)
}

/// The change of a value along the motion from a state, by its difference over a time.
pub(crate) fn slope(at: &State, h: f64, value: &mut dyn FnMut(&State) -> Option<f64>) -> Option<f64> {
    Some((value(&at.moved_along(h))? - value(at)?) / h)
}

/// The time from a state on to the event nearest to it, within a time, where the motion goes on by its rates and
/// accelerations.
pub(crate) fn time_to_event(at: &State, longest: f64, value: &mut dyn FnMut(&State) -> Option<f64>) -> Option<f64> {
    let is_behind = value(at)? >= 0.0;
    let mut reach = f64::EPSILON * at.t.abs().max(f64::MIN_POSITIVE);
    while reach <= longest {
        let other = at.moved_along(if is_behind { -reach } else { reach });
        if (value(&other)? >= 0.0) != is_behind {
            let ends = if is_behind { [&other, at] } else { [at, &other] };
            let mut value = |at: &State| value(at).unwrap_or(f64::NAN);
            let Ok(found) =
                locate(ends[0], ends[1], &mut value, &mut |t| Ok::<_, Infallible>(at.moved_along(t - at.t)));
            return Some(found.t - at.t);
        }
        reach *= 4.0;
    }
    None
}

/// The state inside a step at which a value that is negative at both ends is largest, if it rises from the beginning
/// and falls to the end; also where it turns at a corner.
#[inline(never)] // One copy: pages are to be small.
pub(crate) fn touched(
    from: &State,
    to: &State,
    value: &mut dyn FnMut(&State) -> Option<f64>,
    at: &mut dyn FnMut(f64) -> Option<State>,
) -> Option<State> {
    let h = to.t - from.t;
    if !(slope(from, SHIFT * h, value)? > 0.0 && slope(to, -SHIFT * h, value)? < 0.0) {
        return None;
    }
    let first = from.t + 0.5 * h;
    let mut value_at = |t: f64| value(&at(t)?);
    let (peak, _) = peak_between([from.t, to.t], (first, value_at(first)?), &mut value_at)?;
    at(peak)
}

/// The zero by the inverse quadratic through three points, as a part of the way from the first to the second one;
/// `None` where it does not rise or fall throughout.
fn inverse_quadratic([(a, f_a), (b, f_b), (c, f_c)]: [(f64, f64); 3]) -> Option<f64> {
    let xi = (a - b) / (c - b);
    let phi = (f_a - f_b) / (f_c - f_b);
    let is_monotonic = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
    is_monotonic
        .then(|| f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn at(t: f64) -> State {
        State { t, ..State::zero(0, 0) }
    }

    /// The zero of a function between 0 and 2, and the number of its evaluations.
    fn zero_of(f: impl Fn(f64) -> f64) -> (f64, u32) {
        let count = Cell::new(0);
        let mut value = |at: &State| {
            count.set(count.get() + 1);
            f(at.t)
        };
        let found = locate::<()>(&at(0.0), &at(2.0), &mut value, &mut |t| Ok(at(t))).expect("no step fails");
        assert!(f(found.t) >= 0.0, "the value is negative still");
        (found.t, count.get())
    }

    #[test]
    fn a_smooth_zero_takes_few_steps() {
        let (t, count) = zero_of(|t| t.exp() - 3.0);
        assert!((t - 3.0_f64.ln()).abs() <= 4.0 * f64::EPSILON, "{t}");
        assert!(count <= 10, "{count} evaluations");
    }

    #[test]
    fn zeros_of_many_kinds_take_few_steps() {
        let functions: [fn(f64) -> f64; 6] = [
            |t| t * t - 0.5,
            |t| (20.0 * (t - 0.3)).tanh(),
            |t| (t - 0.1).powi(3) + 0.01 * (t - 0.1),
            |t| 1.0 - 1.9 / (t + 1e-3),
            |t| t.powi(20) - 1e-3,
            |t| (t - 1.1).cbrt(),
        ];
        let counts = functions.map(|f| zero_of(f).1);
        assert!(counts.iter().sum::<u32>() <= 118, "{counts:?}");
    }

    #[test]
    fn a_jump_and_a_flat_zero_take_no_more_than_bisections() {
        let (t, count) = zero_of(|t| if t < 0.7 { -1.0 } else { 1e-9 });
        assert!((t - 0.7).abs() <= 4.0 * f64::EPSILON && count <= 70, "{t}, {count} evaluations");
        let (t, count) = zero_of(|t| (t - 0.7).min(0.0));
        assert!((t - 0.7).abs() <= 4.0 * f64::EPSILON && count <= 70, "{t}, {count} evaluations");
        let (t, count) = zero_of(|t| (t - 0.7).powi(9));
        assert!((t - 0.7).abs() <= 1e-3 && count <= 102, "{t}, {count} evaluations");
    }
}
