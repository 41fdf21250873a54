//! Steps of the Gauss method for one kernel and one kind of vector.

extern crate alloc;

use alloc::boxed::Box;

use super::at_nodes::{AtNodes, column, groups, lagrange_polynomials, largest, sums, sums_by};
use super::coefficients::{A, A_SQUARED, END_AND_MODES, NODES};
use super::{Convergence, GaussEnd, GaussEstimate, GaussRequest, GaussSteps};
use crate::angles::Angles;
use crate::buffers::StateRef;
use crate::kernel::{Kernel, MAX_GROWTH};
use crate::lanes::{Lanes, Token};
use crate::projection::padded;
use crate::scalar::Scalar;

/// The largest accepted coefficient of P7 in the Legendre expansion of a step, over the root of the tolerance: the
/// error at the end of a step is about the square of the error of the polynomial inside.
const HIGHEST_MODE: f64 = 4.0;
/// The weight of the coefficient of P6 relative to that of P7.
const WEIGHT_OF_P6: f64 = 0.3;
/// Larger tolerances are reduced to this one: iterations in longer steps often do not converge.
const MAX_TOLERANCE: f64 = 1e-6;
/// The iteration ends when the expected change in the next iteration, relative to the tolerance, falls below this.
const CONVERGED: f64 = 0.3;
/// The smallest contraction that is expected. The contraction is the ratio of successive changes.
const FASTEST: f64 = 0.1;
/// The largest contraction of an iteration that counts as convergent.
const SLOWEST: f64 = 0.5;
/// The largest contraction of an accepted step. Up to it the method resolves fast oscillations to its full order,
/// however small their amplitude.
const RESOLVED: f64 = 0.15;
/// The largest number of iterations of a step.
const MOST_ITERATIONS: u32 = 20;
/// The number of iterations after which a far too long step is given up.
const EARLY_EXIT_ITERATIONS: u32 = 2;
/// The error reported for such a step.
const FAR_TOO_LONG: f64 = 30.0;
/// The largest distance to which the polynomials of a step are extrapolated, in lengths of that step.
const MAX_EXTRAPOLATION: f64 = 4.0;
/// Changes up to this size, relative to the increment, are rounding errors.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Steps with one kind of vector.
pub(crate) struct Steps<K, S: Token, const N: usize, const M: usize> {
    token: S,
    kernel: K,
    /// The accelerations of the last converged step, and of the step from which it continued.
    last: Polynomials<S, N>,
    before: Polynomials<S, N>,
}

/// Polynomials of degree 7 over a step, given by their values at the nodes.
#[derive(Clone, Copy)]
struct Polynomials<S: Token, const N: usize> {
    t: f64,
    h: f64,
    values: [AtNodes<S>; N],
}

impl<K: Kernel<Lanes<S>, N, M>, S: Token, const N: usize, const M: usize> Steps<K, S, N, M> {
    /// Steps by a kernel with its parameters.
    #[inline]
    pub(crate) fn new(token: S, kernel: K) -> Self {
        let none = Polynomials { t: f64::INFINITY, h: 0.0, values: [[Lanes::zero(); 2]; N] };
        Self { token, kernel, last: none, before: none }
    }

    /// The initial accelerations at the nodes: those of the polynomials if the state lies inside their step and the new
    /// step ends near it, otherwise those at the beginning.
    #[inline(always)]
    fn first_values(known: &Polynomials<S, N>, (t, h): (f64, f64), qdd: &[f64; N]) -> [AtNodes<S>; N] {
        let mut values = [[Lanes::zero(); 2]; N];
        let (part, ratio) = ((t - known.t) / known.h, h / known.h);
        if (0.0..1.0 + 1e-9).contains(&part) && part + ratio <= MAX_EXTRAPOLATION {
            let lagrange = lagrange_polynomials::<S>(part, ratio);
            for i in 0..N {
                values[i] = sums_by(&lagrange, &known.values[i]);
            }
        } else {
            for i in 0..N {
                values[i] = [Lanes::from_f64(qdd[i]); 2];
            }
        }
        values
    }

    /// Solves for the accelerations at the nodes; returns coordinates, rates and the estimate at the end.
    #[inline(always)]
    fn solve(
        &self,
        request: &GaussRequest,
        (t, q, qd): (f64, &[f64; N], &[f64; N]),
        values: &mut [AtNodes<S>; N],
    ) -> Option<([f64; N], [f64; N], GaussEstimate)> {
        let number = Lanes::from_f64;
        let GaussRequest { h, tolerance, .. } = *request;
        let (nodes, [n, _], is_length) = (column(&NODES), self.kernel.sizes(), self.kernel.is_length());
        let mut at = [number(t); 2];
        let (mut drift, mut scales, mut of_change) = ([[number(0.0); 2]; N], [[1.0; 2]; N], [number(0.0); N]);
        for g in 0..groups::<S>() {
            at[g] = nodes[g].mul_add(number(h), number(t));
        }
        for i in 0..N {
            for g in 0..groups::<S>() {
                drift[i][g] = nodes[g].mul_add(number(h * qd[i]), number(q[i]));
            }
            let of_q = if is_length[i] { 1.0 / (1.0 + q[i].abs()) } else { 1.0 };
            let of_qd = 1.0 / (1.0 + qd[i].abs());
            scales[i] = [of_q, of_qd];
            // An error of the rates becomes an error of the coordinates too.
            of_change[i] = number(Scalar::max(0.5 * h * of_q, of_qd));
        }
        let tolerance = Scalar::min(tolerance, MAX_TOLERANCE);
        let highest = HIGHEST_MODE * tolerance.sqrt();
        let convergence = Convergence::Diverged;
        let mut estimate = GaussEstimate { error: f64::INFINITY, convergence, iterations: 0, work: 0.0 };
        let mut change_before = f64::INFINITY;
        let (mut rates, mut power) = (*values, [number(0.0); 2]);
        let slowness = loop {
            // Coordinates, rates and accelerations at the nodes, and the change of the accelerations in this iteration.
            let mut coordinates = rates;
            for i in 0..rolled(n) {
                let (once, twice) = (sums(&A, &values[i]), sums(&A_SQUARED, &values[i]));
                for g in 0..groups::<S>() {
                    rates[i][g] = once[g].mul_add(number(h), number(qd[i]));
                    coordinates[i][g] = twice[g].mul_add(number(h * h), drift[i][g]);
                }
            }
            let (mut change, mut size, mut growth) = (number(0.0), number(0.0), number(1.0));
            let mut sum = number(0.0);
            for g in 0..if groups::<S>() > 1 { rolled(groups::<S>()) } else { 1 } {
                let (mut q, mut qd) = ([number(0.0); N], [number(0.0); N]);
                for i in 0..N {
                    q[i] = coordinates[i][g];
                    qd[i] = rates[i][g];
                }
                let angles = Angles::new(&q, self.kernel.has_angle());
                let position = self.kernel.position(at[g], &q, &angles);
                let own_growth = self.kernel.growth_factor(&position);
                growth = own_growth.max(growth);
                sum = sum + own_growth;
                let (qdd, multipliers) = self.kernel.accelerations(&position, at[g], &q, &qd, &angles);
                power[g] = self.kernel.power(at[g], &q, &qd, &qdd, &multipliers);
                sum = sum + power[g];
                for i in 0..N {
                    change = change.max((qdd[i] - values[i][g]).abs() * of_change[i]);
                    size = size.max(qdd[i].abs() * of_change[i]);
                    values[i][g] = qdd[i];
                    sum = sum + qdd[i];
                }
            }
            estimate.iterations += 1;
            let (change, size) = (h * largest(change), h * largest(size));
            // A maximum may skip values that are not numbers, so the sum is tested: zero times a non-finite number is
            // not a number.
            if !(growth.is_within(MAX_GROWTH) && (sum * number(0.0)).is_within(0.0)) {
                return None;
            }
            if estimate.iterations == EARLY_EXIT_ITERATIONS {
                let error = error(n, values, &rates, h, &scales) / highest;
                if error > FAR_TOO_LONG {
                    (estimate.error, estimate.convergence) = (error, Convergence::TooLong);
                    return Some((*q, *qd, estimate));
                }
            }
            let contraction = change / change_before;
            let expected = change * contraction.max(FASTEST);
            let (is_first, rounding) = (estimate.iterations == 1, ROUNDING * largest(growth) * size);
            let goal = (CONVERGED * tolerance).max(rounding);
            if change <= goal || !is_first && contraction < SLOWEST && expected <= goal {
                estimate.convergence = Convergence::Converged;
                let is_measured = !is_first && change > 4.0 * rounding;
                // The contraction grows with the square of the step's length, the error with its eighth power.
                break if is_measured { (contraction / RESOLVED).powi(4) } else { 0.0 };
            }
            if estimate.iterations == MOST_ITERATIONS
                || estimate.iterations > EARLY_EXIT_ITERATIONS && contraction > SLOWEST
            {
                return Some((*q, *qd, estimate));
            }
            change_before = change;
        };
        let (mut end_q, mut end_qd) = (*q, *qd);
        for i in 0..N {
            let whole = sums(&END_AND_MODES, &values[i])[0];
            end_q[i] += h * (qd[i] + h * whole.get(1));
            end_qd[i] += h * whole.get(0);
        }
        estimate.error = Scalar::max(error(n, values, &rates, h, &scales) / highest, slowness);
        estimate.work = h * sums(&END_AND_MODES, &power)[0].get(0);
        Some((end_q, end_qd, estimate))
    }
}

/// The largest coefficients of the Legendre polynomials of degree 7 and 6 of rates and coordinates in a step.
#[inline(always)]
fn error<S: Token, const N: usize>(
    n: usize,
    accelerations: &[AtNodes<S>; N],
    rates: &[AtNodes<S>; N],
    h: f64,
    scales: &[[f64; 2]; N],
) -> f64 {
    let mut largest = 0.0;
    for i in 0..rolled(n) {
        let [of_q, of_qd] = scales[i];
        for (scale, values) in [(of_q, &rates[i]), (of_qd, &accelerations[i])] {
            let whole = sums(&END_AND_MODES, values)[0];
            largest = Scalar::max(scale * Scalar::max(whole.get(2).abs(), WEIGHT_OF_P6 * whole.get(3).abs()), largest);
        }
    }
    h * largest
}

/// Hides a loop count from the compiler: a loop that is not unrolled compiles in a fraction of the time.
#[inline(always)]
fn rolled(count: usize) -> usize {
    core::hint::black_box(count).min(count)
}

/// Runs `solve` with the target features of the token.
struct Solve<'a, K, S: Token, const N: usize, const M: usize> {
    steps: &'a mut Steps<K, S, N, M>,
    request: &'a GaussRequest,
    from: &'a StateRef<'a>,
    end: GaussEnd<'a>,
}

impl<K, S, const N: usize, const M: usize> pulp::NullaryFnOnce for Solve<'_, K, S, N, M>
where
    K: Kernel<Lanes<S>, N, M>,
    S: Token,
{
    type Output = Option<GaussEstimate>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { steps, request, from, mut end } = self;
        let (t, h, is_within_last_step) = (from.t, request.h, request.is_within_last_step);
        let [n, _] = steps.kernel.sizes();
        let (q, qd, qdd) = (&padded(from.q, n)?, &padded(from.qd, n)?, &padded(from.qdd, n)?);
        if !is_within_last_step && t > steps.last.t {
            steps.before = steps.last;
        }
        let known = if is_within_last_step { &steps.last } else { &steps.before };
        let mut values = Steps::<K, S, N, M>::first_values(known, (t, h), qdd);
        let (q, qd, estimate) = steps.solve(request, (t, q, qd), &mut values)?;
        end.q.copy_from_slice(&q[..n]);
        end.qd.copy_from_slice(&qd[..n]);
        for (i, values) in values.iter().enumerate().take(n) {
            let whole = sums(&END_AND_MODES, values);
            for (place, to) in end.extrapolated.iter_mut().enumerate() {
                let lane = 4 + place;
                to[i] = whole[lane / S::F64_LANES].get(lane % S::F64_LANES);
            }
        }
        if !is_within_last_step && estimate.convergence == Convergence::Converged {
            steps.last = Polynomials { t, h, values };
        }
        Some(estimate)
    }
}

impl<K, S, const N: usize, const M: usize> GaussSteps for Steps<K, S, N, M>
where
    K: Kernel<Lanes<S>, N, M> + Clone + Send + 'static,
    S: Token,
{
    #[inline]
    fn step(&mut self, request: &GaussRequest, from: &StateRef, end: GaussEnd) -> Option<GaussEstimate> {
        self.token.vectorize(Solve { steps: self, request, from, end })
    }

    #[inline]
    fn boxed_clone(&self) -> Box<dyn GaussSteps> {
        let Self { token, kernel, last, before } = self;
        Box::new(Self { token: *token, kernel: kernel.clone(), last: *last, before: *before })
    }
}

impl<K, S: Token, const N: usize, const M: usize> core::fmt::Debug for Steps<K, S, N, M> {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        f.debug_struct("Steps").field("t", &self.last.t).field("h", &self.last.h).finish_non_exhaustive()
    }
}
