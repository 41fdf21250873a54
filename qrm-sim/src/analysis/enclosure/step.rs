//! One step of an enclosed motion.

use qrm_core::Interval;

use super::flow::{Expansion, Flow, NoSeries};
use super::matrix::IntervalMatrix;
use super::state_set::StateSet;

/// The number of terms of a Taylor series before its remainder.
pub(super) const ORDER: usize = 20;
/// The largest remainder of a step, relative to the size of the state.
const TOLERANCE: f64 = f64::EPSILON;
/// The smallest size of a state for that ratio.
const SMALLEST: f64 = 1e-3;
/// The fraction of its width by which the range of a series is widened on each side to guess a bound.
const INFLATION: f64 = 1e-3;
/// The number of attempts to find a bound, each with a shorter step.
const ATTEMPTS: u32 = 60;
/// The ends, in fractions of a step, of the parts in which the remainder is bounded.
const PARTS: [f64; 5] = [0.0625, 0.15625, 0.28125, 0.5, 1.0];

/// The motions from a set during a step.
pub(super) struct Step {
    from: StateSet,
    /// The time for which the bound holds.
    pub(super) length: f64,
    /// A box that no motion leaves within that time.
    pub(super) bound: Vec<Interval>,
    /// The series at the center of the set.
    center: Expansion,
    /// The series of the set, with derivatives with respect to `r`.
    hull: Expansion,
    /// The coefficients of the remainder, for all times within the step.
    remainder: Vec<Interval>,
    /// The reason why no bound was found for a longer step; `None` if it is not known or there was no such step.
    pub(super) obstacle: Option<NoSeries>,
}

impl Step {
    /// Makes a step of this length at most. It is shortened until its bound is proved and its remainder is small.
    ///
    /// # Errors
    /// No bound was found.
    pub(super) fn new(flow: &mut Flow, from: StateSet, longest: f64) -> Result<Self, NoSeries> {
        let t = Interval::point(from.t);
        let center = flow.expand(t, &from.center, None, ORDER)?;
        let hull = flow.expand(t, &from.hull, Some(&from.basis), ORDER - 1)?;
        let tolerance = TOLERANCE * from.hull.iter().map(|x| x.magnitude()).fold(SMALLEST, f64::max);
        let mut length = longest.min(estimate(&center, tolerance));
        let mut obstacle = None;
        for _ in 0..ATTEMPTS {
            match bound(flow, t, &hull, length, tolerance) {
                Ok((bound, remainder)) => {
                    let largest = remainder.iter().map(|x| x.magnitude()).fold(0.0, f64::max);
                    let error = largest * length.powi(ORDER as i32) / tolerance;
                    if error <= 1.0 {
                        return Ok(Self { from, length, bound, center, hull, remainder, obstacle });
                    }
                    // Bounds of remainders decrease faster than the remainders themselves.
                    length *= error.powf(-0.8 / ORDER as f64).clamp(0.3, 0.95);
                }
                Err(met) => {
                    obstacle = met.or(obstacle);
                    length *= 0.7;
                }
            }
        }
        Err(obstacle.unwrap_or(NoSeries::Singular))
    }

    /// The time at the beginning of the step.
    pub(super) fn begin(&self) -> f64 {
        self.from.t
    }

    /// The states at a time within the step.
    ///
    /// They follow from the mean value form: the series at the center, plus the derivatives on the whole set times the
    /// distance from the center.
    pub(super) fn states(&self, flow: &mut Flow, t: f64) -> Option<StateSet> {
        let (size, time) = (self.bound.len(), Interval::point(t) - Interval::point(self.from.t));
        let moved: Vec<Interval> =
            (0..size).map(|i| self.center.sum(ORDER, i, time)[0] + self.remainder_at(i, time)).collect();
        let derivatives: Vec<Vec<Interval>> = (0..size).map(|i| self.hull.sum(ORDER, i, time).split_off(1)).collect();
        let derivatives = IntervalMatrix::from_fn(size, size, |i, j| derivatives[i][j]);
        StateSet::from_affine(&mut flow.manifold, t, &moved, &derivatives, &self.from.parts)
    }

    /// A component in an interval of time since the beginning of the step.
    pub(super) fn range(&self, i: usize, time: Interval) -> Interval {
        self.hull.sum(ORDER, i, time)[0] + self.remainder_at(i, time)
    }

    /// The remainder of a component.
    fn remainder_at(&self, i: usize, time: Interval) -> Interval {
        (0..ORDER).fold(self.remainder[i], |rest, _| rest * time)
    }
}

/// Finds a box that no motion from the set leaves within a time, and the coefficients of the remainder. Fails if the
/// box is not proved; the error is the reason, if the box has no series.
///
/// This is the high-order enclosure of G. F. Corliss and R. Rihm (1996): if the series with its remainder over the box
/// lies inside the box at all times, no motion reaches its border. The remainder `p (1 - s)^(p - 1) x_p ds`, integrated
/// over the step, has most of its weight at the beginning of the step, so it is bounded in parts.
fn bound(
    flow: &mut Flow,
    t: Interval,
    hull: &Expansion,
    length: f64,
    tolerance: f64,
) -> Result<(Vec<Interval>, Vec<Interval>), Option<NoSeries>> {
    let size = hull.states();
    let within = |part: f64| powers((Interval::point(length) * Interval::point(part)).hi());
    let polynomials = |powers: &[Interval]| -> Vec<Interval> {
        let polynomial = |i| (0..ORDER).fold(Interval::ZERO, |sum, k| sum + powers[k] * hull.at(k, i)[0]);
        (0..size).map(polynomial).collect()
    };
    let mut remainder = |time: Interval, states: &[Interval]| -> Result<Vec<Interval>, Option<NoSeries>> {
        let series = flow.expand(t + time, states, None, ORDER).map_err(Some)?;
        Ok((0..size).map(|i| series.at(ORDER, i)[0]).collect())
    };
    let all = within(1.0);
    let series = polynomials(&all);
    let wider = |x: &Interval| {
        let more = INFLATION * x.width() + 4.0 * tolerance;
        *x + Interval::new(-more, more)
    };
    let bound: Vec<Interval> = series.iter().map(wider).collect();
    let of_bound = remainder(all[1], &bound)?;
    let add = |series: &[Interval], power: Interval| -> Vec<Interval> {
        series.iter().zip(&of_bound).map(|(x, remainder)| *x + power * *remainder).collect()
    };
    if !add(&series, all[ORDER]).iter().zip(&bound).all(|(reached, bound)| reached.is_inside(*bound)) {
        return Err(None);
    }
    let mut sum = vec![Interval::ZERO; size];
    let mut begin = 0.0;
    for end in PARTS {
        let powers = within(end);
        let of_part = match end < 1.0 {
            true => remainder(powers[1], &add(&polynomials(&powers), powers[ORDER]))?,
            false => of_bound.clone(),
        };
        let [before, after] = [begin, end].map(|s| power(Interval::ONE - Interval::point(s)));
        sum.iter_mut().zip(of_part).for_each(|(sum, of_part)| *sum = *sum + (before - after) * of_part);
        begin = end;
    }
    Ok((bound, sum))
}

/// The powers of all numbers between zero and `end`.
fn powers(end: f64) -> Vec<Interval> {
    let mut powers = vec![Interval::ONE, Interval::new(0.0, end)];
    while powers.len() <= ORDER {
        let last = powers[powers.len() - 1].hi();
        powers.push(Interval::new(0.0, (Interval::point(last) * Interval::point(end)).hi()));
    }
    powers
}

/// The power of `x` whose exponent is the order of a series.
fn power(x: Interval) -> Interval {
    (0..ORDER).fold(Interval::ONE, |power, _| power * x)
}

/// Estimates the length of a step whose last terms are within the tolerance.
fn estimate(center: &Expansion, tolerance: f64) -> f64 {
    let length = |order: usize| {
        let largest = (0..center.states()).map(|i| center.at(order, i)[0].magnitude()).fold(0.0, f64::max);
        (largest / tolerance).powf(-1.0 / order as f64)
    };
    length(ORDER - 1).min(length(ORDER))
}

#[cfg(test)]
mod tests {
    use qrm_core::{Operation as Op, Tape, TapeFunction};

    use super::*;

    /// The motion `x'' = 6 x^2`, with the solution `1 / (1 - t)^2` from `x = 1`, `x' = 2`.
    fn flow() -> Flow {
        let operations = vec![Op::Number(1.0), Op::Mul(1, 1), Op::Number(6.0), Op::Mul(8, 7)];
        let dynamics = TapeFunction { operations: operations.into(), results: vec![6, 9].into() };
        let tape = Tape { coordinates: 1, dynamics, ..Tape::default() };
        Flow::new(&tape, &|_| None, ORDER)
    }

    fn exact(t: f64) -> [f64; 2] {
        [1.0 / (1.0 - t).powi(2), 2.0 / (1.0 - t).powi(3)]
    }

    fn start(flow: &mut Flow) -> StateSet {
        StateSet::from_box(&mut flow.manifold, 0.0, &[Interval::ONE, Interval::point(2.0)]).expect("no constraints")
    }

    #[test]
    fn steps_contain_the_exact_motion() {
        let mut flow = flow();
        let mut set = start(&mut flow);
        while set.t < 0.9 {
            let step = Step::new(&mut flow, set, 1.0).expect("a step");
            let to = (step.begin() + step.length).next_down();
            for part in [0.2, 0.7, 1.0] {
                let t = step.begin() + part * (to - step.begin());
                let at = step.states(&mut flow, t).expect("states");
                for ((i, exact), x) in exact(t).into_iter().enumerate().zip(&at.hull) {
                    let rounding = 1e-13 * exact;
                    assert!(x.lo() <= exact + rounding && exact - rounding <= x.hi(), "{t}: {x:?} {exact}");
                    assert!(step.bound[i].contains(exact) && x.width() < 1e-10 * exact, "{t}: {x:?}");
                }
            }
            set = step.states(&mut flow, to).expect("states");
        }
    }

    #[test]
    fn a_wrong_bound_is_rejected() {
        let mut flow = flow();
        let set = start(&mut flow);
        let hull = flow.expand(Interval::ZERO, &set.hull, Some(&set.basis), ORDER - 1).expect("a series");
        let mut proved = 0;
        for k in 1..=40 {
            // The motion goes to infinity at t = 1: every bound beyond that is wrong.
            let length = 0.05 * f64::from(k);
            let found = bound(&mut flow, Interval::ZERO, &hull, length, 1e-16);
            assert!(found.is_err() || length < 1.0, "{length}");
            let Ok((bound, _)) = found else { continue };
            proved += 1;
            assert!(bound.iter().zip(exact(length)).all(|(bound, exact)| bound.contains(exact)), "{length}");
        }
        assert!(proved >= 4, "{proved}");
    }

    #[test]
    fn remainders_bound_what_the_series_leaves() {
        let mut flow = flow();
        let set = start(&mut flow);
        let step = Step::new(&mut flow, set, 0.1).expect("a step");
        // The coefficient of `t^k` is `k + 1`; the rest of the series from `t^20` on.
        for time in [0.5 * step.length, step.length] {
            let rest: f64 = (ORDER..ORDER + 60).map(|k| (k + 1) as f64 * time.powi((k - ORDER) as i32)).sum();
            assert!(step.remainder[0].contains(rest) && step.remainder[0].lo() >= 20.0, "{:?}", step.remainder[0]);
        }
    }
}
