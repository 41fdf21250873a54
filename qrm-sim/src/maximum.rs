//! The search for the largest value.

/// Finds the time in an interval at which a value is largest, and the value, by golden section search.
///
/// # Errors
/// A value could not be computed.
pub(crate) fn largest_between<E>(
    [mut a, mut b]: [f64; 2],
    resolution: f64,
    mut at: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, f64), E> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut at_c, mut at_d) = (at(c)?, at(d)?);
    while (b - a).abs() > resolution {
        if at_c > at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - golden * (b - a);
            at_c = at(c)?;
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + golden * (b - a);
            at_d = at(d)?;
        }
    }
    Ok(if at_c > at_d { (c, at_c) } else { (d, at_d) })
}

/// The resolution of a peak, relative to the interval: the error of the value is about the square of that.
const LOCATED: f64 = 1e-5;
/// The distance, relative to the interval, of the values whose parabola is tried for a peak.
const PARABOLA: f64 = 2e-3;
/// The distance of these values for a peak that is located already.
const NARROW_PARABOLA: f64 = 1e-4;
/// The largest error of a parabola at the peak, relative to its height over the values that it passes through.
const FITTING: f64 = 1e-3;
/// The largest number of values computed for a peak.
const MOST_VALUES: usize = 60;
/// The smallest decrease next to a peak that is a corner, relative to the decrease seen so far.
const CORNER: f64 = 1e-6;
/// Lengths of lines that meet at a corner, relative to the interval.
const LINES: [f64; 2] = [2e-5, 2e-9];

/// Finds the time in an interval at which a value is largest, and the value, starting from a time near it and the value
/// there. `None` if a value could not be computed.
#[inline(never)] // One copy: pages are to be small.
pub(crate) fn peak_between(
    ends: [f64; 2],
    first: (f64, f64),
    at: &mut dyn FnMut(f64) -> Option<f64>,
) -> Option<(f64, f64)> {
    match vertex_near(first, (ends, PARABOLA), at)? {
        Some(vertex) => Some(vertex),
        None => peak_from(first, ends, at),
    }
}

/// The vertex of the parabola through a point and its two neighbours at a distance, in parts of the interval, if it is
/// a peak between them.
#[allow(clippy::option_option, reason = "no value and no vertex are different")]
fn vertex_near(
    (t, middle): (f64, f64),
    ([a, b], distance): ([f64; 2], f64),
    at: &mut dyn FnMut(f64) -> Option<f64>,
) -> Option<Option<(f64, f64)>> {
    let h = distance * (b - a);
    if t - h < a || t + h > b {
        return Some(None);
    }
    let [left, right] = [at(t - h)?, at(t + h)?];
    let (slope, bend) = (0.5 * (right - left), right - 2.0 * middle + left);
    let x = -slope / bend;
    if !(bend < 0.0 && x.abs() < 1.0) {
        return Some(None);
    }
    let vertex = (t + h * x, at(t + h * x)?);
    let told = middle + 0.5 * slope * x;
    let is_peak = (vertex.1 - told).abs() <= FITTING * (told - left.min(right));
    let best = if vertex.1 > middle { vertex } else { (t, middle) };
    Some(is_peak.then_some(best))
}

/// The peak of the parabola through a point near a peak and its two neighbours, and the value there, if it is larger
/// than the value of the point.
pub(crate) fn vertex_beside(first: (f64, f64), ends: [f64; 2], at: &mut dyn FnMut(f64) -> Option<f64>) -> (f64, f64) {
    vertex_near(first, (ends, NARROW_PARABOLA), at).flatten().unwrap_or(first)
}

/// Finds the largest value by parabolas through the three best points, and golden sections where they do not converge
/// (Brent, Algorithms for Minimization without Derivatives, chapter 5); at a corner, by the lines that meet there.
fn peak_from(
    mut best: (f64, f64),
    [mut a, mut b]: [f64; 2],
    at: &mut dyn FnMut(f64) -> Option<f64>,
) -> Option<(f64, f64)> {
    let ends = [a, b];
    let golden = 0.5 * (3.0 - 5.0_f64.sqrt());
    let resolution = LOCATED * (b - a);
    let (mut second, mut third) = (best, best);
    let mut lowest = best.1;
    // The last two steps.
    let [mut last, mut before] = [0.0_f64; 2];
    for _ in 0..MOST_VALUES {
        let middle = 0.5 * (a + b);
        if (best.0 - middle).abs() <= 2.0 * resolution - 0.5 * (b - a) {
            break;
        }
        let [r, q] = [(best.0 - second.0) * (best.1 - third.1), (best.0 - third.0) * (best.1 - second.1)];
        let parabolic = -0.5 * ((best.0 - third.0) * q - (best.0 - second.0) * r) / (q - r);
        let is_inside = a < best.0 + parabolic && best.0 + parabolic < b;
        if before.abs() > resolution && is_inside && parabolic.abs() < 0.5 * before.abs() {
            (before, last) = (last, parabolic);
        } else {
            before = if best.0 < middle { b - best.0 } else { a - best.0 };
            last = golden * before;
        }
        let t = best.0 + if last.abs() >= resolution { last } else { resolution.copysign(last) };
        let found = (t, at(t)?);
        lowest = lowest.min(found.1);
        if found.1 >= best.1 {
            *(if t >= best.0 { &mut a } else { &mut b }) = best.0;
            (third, second, best) = (second, best, found);
        } else {
            *(if t < best.0 { &mut a } else { &mut b }) = t;
            if found.1 >= second.1 || second.0 == best.0 {
                (third, second) = (second, found);
            } else if found.1 >= third.1 || third.0 == best.0 || third.0 == second.0 {
                third = found;
            }
        }
    }
    let is_corner = best.1 - second.1 > CORNER * (best.1 - lowest);
    if is_corner { corner_near(best, ends, at) } else { Some(best) }
}

/// Finds a peak that is a corner, and its value, starting from a point near it: the lines through two values on each
/// side meet there. `None` if a value could not be computed.
pub(crate) fn corner_near(
    mut best: (f64, f64),
    [a, b]: [f64; 2],
    at: &mut dyn FnMut(f64) -> Option<f64>,
) -> Option<(f64, f64)> {
    for length in LINES {
        let h = length * (b - a);
        let t = best.0;
        if t - 2.0 * h < a || t + 2.0 * h > b {
            break;
        }
        let [farther, left, right, beyond] = [at(t - 2.0 * h)?, at(t - h)?, at(t + h)?, at(t + 2.0 * h)?];
        let [rise, fall] = [left - farther, right - beyond];
        // `left + rise (x + 1) = right + fall (1 - x)` at `t + h x`
        let x = (right - left + fall - rise) / (rise + fall);
        if !(x.abs() < 1.0) {
            break;
        }
        let met = t + h * x;
        let found = (met, at(met)?);
        if found.1 > best.1 {
            best = found;
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::peak_between;

    /// The peak, its value, and the number of values computed.
    fn peak(ends: [f64; 2], near: f64, value: impl Fn(f64) -> f64) -> (f64, f64, usize) {
        let mut count = 0;
        let found = peak_between(ends, (near, value(near)), &mut |t| {
            count += 1;
            Some(value(t))
        });
        let (t, found) = found.expect("values");
        (t, found, count)
    }

    #[test]
    fn smooth_peaks_take_few_values() {
        let (t, value, count) = peak([1.0, 2.0], 1.5, f64::sin);
        assert!(
            (t - std::f64::consts::FRAC_PI_2).abs() < 1e-4 && 1.0 - value < 1e-9 && count < 15,
            "{t} {value} {count}"
        );
        let (t, value, count) = peak([-1.0, 1.0], 0.05, |t| -(t - 0.02) * (t - 0.02) + 0.3 * t.powi(3));
        assert!((t - 0.02).abs() < 1e-3 && value > 0.0 && count < 20, "{t} {value} {count}");
    }

    #[test]
    fn corners_and_ends_are_found() {
        let (t, value, count) = peak([0.0, 1.0], 0.6, |t| if t < 0.7 { 2.0 * t } else { 1.4 - 3.0 * (t - 0.7) });
        assert!((t - 0.7).abs() < 1e-14 && 1.4 - value < 1e-14 && count < 60, "{t} {value} {count}");
        let bent = |t: f64| if t < 0.7 { t.exp() } else { 0.7_f64.exp() * (1.0 - (t - 0.7).sin()) };
        let (t, value, count) = peak([0.0, 1.0], 0.6, bent);
        assert!((t - 0.7).abs() < 1e-13 && 0.7_f64.exp() - value < 1e-13 && count < 60, "{t} {value} {count}");
        let (t, ..) = peak([0.0, 1.0], 0.5, |t| t);
        assert!(t > 1.0 - 1e-4, "{t}");
        assert!(peak_between([0.0, 1.0], (0.5, 0.5), &mut |t| (t < 0.6).then_some(t)).is_none());
    }
}
