//! Extrapolation of the midpoint rule: Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, II.9.

use qrm_core::Scalar;

use crate::integrate::StepError;
use crate::solve::Number;

/// Makes one step from `(t, y, y')`; returns the value and an error estimate, the largest `|error| / (1 + |y|)`.
///
/// The midpoint rule makes the step in n = 2, 4, 6, ... parts. Its error is a series in `1/n^2`; its terms are removed
/// one after another by `T(j, k+1) = T(j, k) + (T(j, k) - T(j-1, k)) / ((n(j) / n(j-k))^2 - 1)`. The error estimate is
/// the difference of the last two columns. Each row uses the slope at its end through Gragg's smoothing step, so that a
/// load that jumps shortly before the end is not missed.
///
/// # Errors
/// A slope has no value.
pub(super) fn extrapolated(
    slope: &mut impl FnMut(Number, &[Number], &mut [Number]) -> Result<(), StepError>,
    from: (Number, &[Number], &[Number]),
    h: Number,
) -> Result<(Vec<Number>, f64), StepError> {
    let mut row: Vec<Vec<Number>> = Vec::with_capacity(COLUMNS);
    for j in 1..=COLUMNS {
        let mut column = midpoint(slope, from, h, 2 * j)?;
        // The new row replaces the row above.
        for (k, above) in row.iter_mut().enumerate() {
            let other = j - 1 - k;
            let weight = whole(other * other) / whole(j * j - other * other);
            let next = column.iter().zip(&*above).map(|(new, old)| *new + (*new - *old) * weight).collect();
            *above = std::mem::replace(&mut column, next);
        }
        row.push(column);
    }
    let [.., before, last] = &row[..] else { return Err(StepError::NotFinite) };
    let relative = |(a, b): (&Number, &Number)| ((*a - *b).abs() / (whole(1) + a.abs())).to_f64();
    // `max` would skip values that are not numbers.
    let larger = |most: f64, error: f64| if error <= most { most } else { error };
    let error = last.iter().zip(before).map(relative).fold(0.0, larger);
    Ok((row.pop().unwrap_or_default(), error))
}

/// The number of columns: the error of a step is of order `h^(2 COLUMNS + 1)`.
const COLUMNS: usize = 12;

/// The order of the estimated error.
pub(super) const ORDER: f64 = 2.0 * COLUMNS as f64 - 1.0;

/// The midpoint rule in an even number of parts, with its smoothing step `(y(n-1) + y(n) + h f(n)) / 2`.
fn midpoint(
    slope: &mut impl FnMut(Number, &[Number], &mut [Number]) -> Result<(), StepError>,
    (t, y, first): (Number, &[Number], &[Number]),
    h: Number,
    parts: usize,
) -> Result<Vec<Number>, StepError> {
    let part = h / whole(parts);
    let twice = part + part;
    let mut before = y.to_vec();
    let mut now: Vec<Number> = y.iter().zip(first).map(|(y, slope)| *y + part * *slope).collect();
    let mut at = first.to_vec();
    for i in 1..parts {
        slope(t + part * whole(i), &now, &mut at)?;
        for (before, slope) in before.iter_mut().zip(&at) {
            *before = *before + twice * *slope;
        }
        std::mem::swap(&mut before, &mut now);
    }
    slope(t + h, &now, &mut at)?;
    let half = Number::from_f64(0.5);
    let smooth = |((before, now), slope): ((&Number, &Number), &Number)| half * (*before + *now + part * *slope);
    Ok(before.iter().zip(&now).zip(&at).map(smooth).collect())
}

fn whole(number: usize) -> Number {
    Number::from_f64(number as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step from `y = 1` with `y' = f(t, y)`.
    fn step(f: impl Fn(Number, Number) -> Number, h: f64) -> (Number, f64) {
        let one = whole(1);
        let first = f(Number::zero(), one);
        let mut slope = |t: Number, y: &[Number], slope: &mut [Number]| {
            slope[0] = f(t, y[0]);
            Ok(())
        };
        let (y, error) = extrapolated(&mut slope, (Number::zero(), &[one], &[first]), h.into()).expect("slopes");
        (y[0], error)
    }

    #[test]
    fn a_long_step_has_many_digits() {
        let (y, error) = step(|_, y| y, 0.5);
        assert!((y - Number::from(0.5).exp()).to_f64().abs() < 1e-28, "{y:?}");
        assert!(error < 1e-25, "{error}");
    }

    #[test]
    fn jumps_are_seen_wherever_they_are() {
        for percent in 1..100 {
            let jump = whole(percent) / whole(100);
            let (_, error) = step(|t, _| whole(usize::from(t > jump)), 1.0);
            assert!(error > 1e-6, "at {percent} %: {error}");
        }
    }
}
