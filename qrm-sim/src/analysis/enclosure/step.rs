//! One step of an enclosed motion.

use nalgebra::DMatrix;
use qrm_core::Interval;

use super::flow::{Expansion, Flow, NoSeries};
use super::linear::{Linear, applied};

/// Terms of a Taylor series before its remainder.
pub(super) const ORDER: usize = 20;
/// What the remainder of a step may be, against the size of the state.
const TOLERANCE: f64 = f64::EPSILON;
/// The least size of a state that the tolerance refers to.
const SMALLEST: f64 = 1e-3;
/// What is added to the range of a series to guess a bound.
const INFLATION: f64 = 1e-3;
/// Attempts to find an a-priori bound.
const ATTEMPTS: u32 = 60;

/// States `center + basis r` for all `r` in a box, at a time.
///
/// The basis is nearly orthogonal and turns with the motion, so that boxes need not contain boxes that are turned
/// against them (R. J. Lohner, Enclosing the solutions of ordinary initial and boundary value problems, 1987).
#[derive(Clone, Debug)]
pub(super) struct StateSet {
    pub(super) t: f64,
    center: Vec<f64>,
    basis: DMatrix<f64>,
    rest: Vec<Interval>,
}

/// Where a motion from a set goes within some time.
#[derive(Debug)]
pub(super) struct Step {
    from: StateSet,
    /// How long the bound holds.
    pub(super) length: f64,
    /// A box that no motion leaves within that time.
    pub(super) bound: Vec<Interval>,
    /// The series at the center.
    center: Expansion,
    /// The series of the set, with derivatives.
    hull: Expansion,
    /// The coefficients after the last one, in the bound.
    remainder: Vec<Interval>,
}

impl StateSet {
    /// The set of a box.
    pub(super) fn new(t: f64, states: &[Interval]) -> Self {
        let center: Vec<f64> = states.iter().map(|x| x.mid()).collect();
        let rest = states.iter().zip(&center).map(|(x, center)| *x - Interval::point(*center)).collect();
        Self { t, basis: DMatrix::identity(center.len(), center.len()), center, rest }
    }

    /// The smallest box around it, but for rounding.
    pub(super) fn hull(&self) -> Vec<Interval> {
        let turned = applied(&intervals(&self.basis), &self.rest);
        turned.into_iter().zip(&self.center).map(|(x, center)| x + Interval::point(*center)).collect()
    }
}

impl Step {
    /// A step of about this length at most, which is made shorter until its bound is proved.
    ///
    /// # Errors
    /// No bound was found.
    pub(super) fn new(flow: &mut Flow, from: StateSet, longest: f64) -> Result<Self, NoSeries> {
        let (t, states) = (Interval::point(from.t), from.hull());
        let center: Vec<Interval> = from.center.iter().map(|x| Interval::point(*x)).collect();
        let center = flow.expand(t, &center, ORDER, false)?;
        let hull = flow.expand(t, &states, ORDER - 1, true)?;
        let tolerances = tolerances(&states);
        let mut length = longest.min(estimate(&center, &tolerances));
        let mut reason = NoSeries::Singular;
        for _ in 0..ATTEMPTS {
            match bound(flow, t, &hull, length, &tolerances) {
                Ok((bound, remainder)) => {
                    let power = length.powi(ORDER as i32);
                    let errors =
                        remainder.iter().zip(&tolerances).map(|(x, tolerance)| x.magnitude() * power / tolerance);
                    let error = errors.fold(0.0, f64::max);
                    if error <= 1.0 {
                        return Ok(Self { from, length, bound, center, hull, remainder });
                    }
                    length *= error.powf(-1.0 / ORDER as f64).clamp(0.3, 0.95);
                }
                Err(Some(obstacle)) => {
                    reason = obstacle;
                    length *= 0.6;
                }
                Err(None) => length *= 0.7,
            }
        }
        Err(reason)
    }

    /// When it begins.
    pub(super) fn begin(&self) -> f64 {
        self.from.t
    }

    /// The states after a time within the step, which ends at `t`.
    ///
    /// The mean value form: the series at the center, and the derivatives on the whole set times the distance from it.
    pub(super) fn states(&self, t: f64) -> Option<StateSet> {
        let n = self.from.center.len();
        let time = Interval::point(t) - Interval::point(self.from.t);
        let moved: Vec<Interval> = (0..n).map(|i| self.center.sum(ORDER, i, time)[0] + self.rest(i, time)).collect();
        let jacobian: Vec<Interval> = (0..n).flat_map(|i| self.hull.sum(ORDER, i, time).split_off(1)).collect();
        let old_basis = intervals(&self.from.basis);
        let moved_basis = super::linear::product(&jacobian, &old_basis, n);
        let basis = orthogonal(&moved_basis, &self.from.rest);
        let inverse = Linear::new(&intervals(&basis), n)?;
        let center: Vec<f64> = moved.iter().map(|x| x.mid()).collect();
        let shift: Vec<Interval> = moved.iter().zip(&center).map(|(x, center)| *x - Interval::point(*center)).collect();
        let mut turned = vec![Interval::ZERO; n * n];
        for j in 0..n {
            let column: Vec<Interval> = moved_basis.iter().skip(j).step_by(n).copied().collect();
            inverse.solve(&column).into_iter().enumerate().for_each(|(i, x)| turned[i * n + j] = x);
        }
        let rest =
            applied(&turned, &self.from.rest).into_iter().zip(inverse.solve(&shift)).map(|(a, b)| a + b).collect();
        Some(StateSet { t, center, basis, rest })
    }

    /// A component in an interval of time within the step.
    pub(super) fn range(&self, i: usize, time: Interval) -> Interval {
        self.hull.sum(ORDER, i, time)[0] + self.rest(i, time)
    }

    fn rest(&self, i: usize, time: Interval) -> Interval {
        (0..ORDER).fold(self.remainder[i], |rest, _| rest * time)
    }
}

/// A box that no motion from the set leaves within a time, and the coefficients of the remainder in it; an error where
/// the box is not proved, with its reason if there is no series in it.
///
/// The high-order enclosure of G. F. Corliss and R. Rihm (1996): where the series with its remainder over the box lies
/// inside the box for all times, no motion gets to its border.
fn bound(
    flow: &mut Flow,
    t: Interval,
    hull: &Expansion,
    length: f64,
    tolerances: &[f64],
) -> Result<(Vec<Interval>, Vec<Interval>), Option<NoSeries>> {
    // The powers of all times up to the length.
    let mut powers = vec![Interval::ONE];
    for k in 1..=ORDER {
        powers.push(Interval::new(0.0, (Interval::point(powers[k - 1].hi()) * Interval::point(length)).hi()));
    }
    let polynomials: Vec<Interval> = (0..tolerances.len())
        .map(|i| (0..ORDER).fold(Interval::ZERO, |sum, k| sum + powers[k] * hull.at(k, i)[0]))
        .collect();
    let wider = |(polynomial, tolerance): (&Interval, &f64)| {
        let more = INFLATION * polynomial.width() + 4.0 * tolerance;
        *polynomial + Interval::new(-more, more)
    };
    let bound: Vec<Interval> = polynomials.iter().zip(tolerances).map(wider).collect();
    let series = flow.expand(t + powers[1], &bound, ORDER, false).map_err(Some)?;
    let remainder: Vec<Interval> = (0..bound.len()).map(|i| series.at(ORDER, i)[0]).collect();
    let mut reached = polynomials.iter().zip(&remainder).map(|(x, remainder)| *x + powers[ORDER] * *remainder);
    if reached.by_ref().zip(&bound).all(|(reached, bound)| reached.is_inside(*bound)) {
        Ok((bound, remainder))
    } else {
        Err(None)
    }
}

/// What a remainder may be, for each component.
fn tolerances(states: &[Interval]) -> Vec<f64> {
    let size = states.iter().map(|x| x.magnitude()).fold(SMALLEST, f64::max);
    vec![TOLERANCE * size; states.len()]
}

/// The length of a step whose last terms are within the tolerances.
fn estimate(center: &Expansion, tolerances: &[f64]) -> f64 {
    let length = |order: usize| {
        let terms = tolerances.iter().enumerate();
        let largest = terms.map(|(i, tolerance)| center.at(order, i)[0].magnitude() / tolerance).fold(0.0, f64::max);
        largest.powf(-1.0 / order as f64)
    };
    length(ORDER - 1).min(length(ORDER))
}

/// An orthogonal basis near to a moved one, whose longest sides come first.
fn orthogonal(moved: &[Interval], rest: &[Interval]) -> DMatrix<f64> {
    let n = rest.len();
    let sides = DMatrix::from_fn(n, n, |i, j| moved[i * n + j].mid() * rest[j].width());
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| sides.column(*b).norm().total_cmp(&sides.column(*a).norm()));
    // The directions alone count: short sides would be lost in rounding.
    let directions = DMatrix::from_fn(n, n, |i, j| moved[i * n + order[j]].mid());
    directions.qr().q()
}

/// The entries of a matrix, row by row.
fn intervals(matrix: &DMatrix<f64>) -> Vec<Interval> {
    matrix.transpose().iter().map(|entry| Interval::point(*entry)).collect()
}
