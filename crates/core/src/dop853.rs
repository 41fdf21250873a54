//! A step of order 8 by a kernel, with its error estimate, and the projection of its end onto the constraints.
//!
//! The step is generic over the number type: vectors in lanes make several steps at once, each with its own length.

mod coefficients;

pub use coefficients::{DENSE, END_3, ERROR_3, ERROR_5, NODES, ROWS, Row};

use crate::kernel::Kernel;
use crate::kernel_state::{KernelState, StepResult};
use crate::scalar::Scalar;
use crate::step_end::{StepEnd, finish, has_constraints};
use crate::vectors::{along, difference, largest, scaled, sum};

/// The number of stages; the end of the step is one stage more.
const STAGES: usize = 12;

/// A step of order 8.
pub(crate) struct Dop853Step<'a, R, P, const N: usize, const M: usize> {
    /// The projected end of the step.
    pub(crate) result: StepResult<R, P, N, M>,
    /// The estimated error of the step relative to the tolerance: 1 if they are equal.
    pub(crate) error: R,
    /// The end before its projection.
    pub(crate) unprojected: Unprojected<R, N>,
    slopes: &'a mut Slopes<R, N>,
}

/// The end of a step before its projection.
pub(crate) struct Unprojected<R, const N: usize> {
    /// Coordinates.
    pub(crate) q: [R; N],
    /// Largest residual of a constraint, in its unit.
    pub(crate) residual: R,
}

/// Rates and accelerations at the stages, at the end of the step, and at the stages of the dense output.
pub(crate) struct Slopes<R, const N: usize> {
    rates: [[R; N]; ROWS.len()],
    accelerations: [[R; N]; ROWS.len()],
    /// Coordinates at the stage evaluated last.
    q: [R; N],
}

/// One step of length `h` from time `t` by the pair of Dormand and Prince of order 8, its end projected onto the
/// constraints in the mass metric.
///
/// Errors are measured against `scale` times `1 + |x|`, or `scale` for an angle, as in the code DOP853. The work is
/// bounded: 12 evaluations of the accelerations and four corrections of the coordinates. `slopes` is overwritten.
#[inline(always)]
pub(crate) fn dop853_step<'a, K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    (t, h): (R, R),
    from: &KernelState<R, N, M>,
    scale: R,
    slopes: &'a mut Slopes<R, N>,
) -> Dop853Step<'a, R, K::Position, N, M> {
    (slopes.rates[0], slopes.accelerations[0]) = (from.qd, from.qdd);
    let mut growth = R::zero();
    macro_rules! stages {
        ($($stage:literal),*) => {
            $(slopes.evaluate::<K, M, $stage>(kernel, (t, h), from, &mut growth);)*
        };
    }
    stages!(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
    let (rate, acceleration) = slopes.sums(ROWS[STAGES]);
    let (increment, qd) = (scaled(h, &rate), along(&from.qd, h, &acceleration));
    let q = sum(&from.q, &increment);
    let error = slopes.error(kernel, h, from, (&q, &qd), (&rate, &acceleration), scale);
    let angles = from.angles.rotated_large(&q, &increment, kernel.has_angle());
    let mut end = StepEnd { q, qd, increment, angles, corrections: 0 };
    let mut unprojected = Unprojected { q, residual: R::zero() };
    let t = t + h;
    if has_constraints(kernel) {
        let position = kernel.position(t, &end.q, &end.angles);
        let open = kernel.residuals(&position);
        unprojected.residual = largest(&open);
        end.project_coordinates_first(kernel, from, &kernel.correction(&position, &open));
    }
    let position = loop {
        let position = kernel.position(t, &end.q, &end.angles);
        if !end.project_coordinates::<K, M>(kernel, &position) {
            break position;
        }
    };
    end.project_rates(kernel, &position);
    let dynamics = kernel.accelerations(&position, t, &end.q, &end.qd, &end.angles);
    let growth = kernel.growth_factor(&position).max(growth);
    let result = finish(kernel, end, dynamics, position, growth);
    slopes.rates[STAGES] = result.end.qd;
    slopes.accelerations[STAGES] = result.end.qdd;
    Dop853Step { result, error, unprojected, slopes }
}

impl<R: Scalar, P, const N: usize, const M: usize> Dop853Step<'_, R, P, N, M> {
    /// Estimates the fastest rate of the motion times the length `h` of the step: the difference of the derivatives at
    /// the last stage and at the end of the step, over the distance of the two (Hairer, Wanner II, IV.2). Rates are
    /// weighted by the change that they cause in a step. Call it before the dense output, which overwrites the stages.
    #[inline(always)]
    pub(crate) fn stiffness(&self, h: R) -> R {
        let (slopes, end) = (&self.slopes, &self.result.end);
        // Distances below rounding errors carry no information.
        let (mut apart, mut differ) = (R::from_f64(f64::EPSILON * f64::EPSILON), R::zero());
        for i in 0..N {
            let dq = end.q[i] - slopes.q[i];
            let dv = h * (end.qd[i] - slopes.rates[STAGES - 1][i]);
            let da = h * h * (end.qdd[i] - slopes.accelerations[STAGES - 1][i]);
            apart = dv.mul_add(dv, dq.mul_add(dq, apart));
            differ = da.mul_add(da, dv.mul_add(dv, differ));
        }
        (differ / apart).sqrt()
    }

    /// Computes the higher coefficients of coordinates and rates in the dense output of order 7, with three more
    /// evaluations of the accelerations. Their growth of rounding errors counts for the step.
    #[inline(always)]
    pub(crate) fn dense_output<K: Kernel<R, N, M>>(
        &mut self,
        kernel: &K,
        (t, h): (R, R),
        from: &KernelState<R, N, M>,
    ) -> DenseOutput<R, N> {
        let growth = &mut self.result.growth_factor;
        self.slopes.evaluate::<K, M, 13>(kernel, (t, h), from, growth);
        self.slopes.evaluate::<K, M, 14>(kernel, (t, h), from, growth);
        self.slopes.evaluate::<K, M, 15>(kernel, (t, h), from, growth);
        let end = &self.result.end;
        // Closures would be compiled without vector instructions.
        let (mut of_q, mut of_qd) = ([from.q; DENSE.len()], [from.qd; DENSE.len()]);
        for k in 0..DENSE.len() {
            (of_q[k], of_qd[k]) = self.slopes.sums(DENSE[k]);
        }
        DenseOutput {
            q: coefficients(h, (&from.q, &from.qd), (&end.q, &end.qd), of_q),
            qd: coefficients(h, (&from.qd, &from.qdd), (&end.qd, &end.qdd), of_qd),
        }
    }
}

/// The polynomial between the projected ends of a step: coefficients of coordinates and of rates.
pub(crate) struct DenseOutput<R, const N: usize> {
    pub(crate) q: [[R; N]; 8],
    pub(crate) qd: [[R; N]; 8],
}

impl<R: Scalar, const N: usize> DenseOutput<R, N> {
    /// Zero if all coefficients are finite; not a number in a lane where one is not.
    #[inline(always)]
    pub(crate) fn finite_check(&self) -> R {
        let mut sum = R::zero();
        for k in 0..self.q.len() {
            for i in 0..N {
                sum = sum + self.q[k][i] + self.qd[k][i];
            }
        }
        sum * R::zero()
    }

    /// Evaluates coordinates and rates at a fraction of the step.
    #[inline(always)]
    pub(crate) fn at(&self, part: f64) -> ([R; N], [R; N]) {
        let (s, r) = (R::from_f64(part), R::from_f64(1.0 - part));
        let (mut q, mut qd) = (self.q[7], self.qd[7]);
        for i in 0..N {
            for (k, factor) in [(6, s), (5, r), (4, s), (3, r), (2, s), (1, r), (0, s)] {
                q[i] = factor.mul_add(q[i], self.q[k][i]);
                qd[i] = factor.mul_add(qd[i], self.qd[k][i]);
            }
        }
        (q, qd)
    }
}

/// The coefficients of the polynomial through both ends of a step of length `h` and the derivatives there; `higher` are
/// its higher coefficients.
#[inline(always)]
fn coefficients<R: Scalar, const N: usize>(
    h: R,
    (x0, d0): (&[R; N], &[R; N]),
    (x1, d1): (&[R; N], &[R; N]),
    higher: [[R; N]; DENSE.len()],
) -> [[R; N]; 8] {
    let mut all = [*x0; 8];
    for i in 0..N {
        let change = x1[i] - x0[i];
        let bend = h * d0[i] - change;
        all[1][i] = change;
        all[2][i] = bend;
        all[3][i] = change - h * d1[i] - bend;
        for k in 0..DENSE.len() {
            all[4 + k][i] = h * higher[k][i];
        }
    }
    all
}

impl<R: Scalar, const N: usize> Slopes<R, N> {
    /// Room for the slopes of a step.
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        let zero = [R::zero(); N];
        Self { rates: [zero; _], accelerations: [zero; _], q: zero }
    }

    /// Evaluates the accelerations at a stage.
    #[inline(always)]
    fn evaluate<K: Kernel<R, N, M>, const M: usize, const STAGE: usize>(
        &mut self,
        kernel: &K,
        (t, h): (R, R),
        from: &KernelState<R, N, M>,
        growth: &mut R,
    ) {
        let (rate, acceleration) = self.sums(const { ROWS[STAGE] });
        let (dq, qd) = (scaled(h, &rate), along(&from.qd, h, &acceleration));
        let q = sum(&from.q, &dq);
        let at = h.mul_add(R::from_f64(NODES[STAGE]), t);
        self.q = q;
        self.rates[STAGE] = qd;
        let (accelerations, own_growth) = accelerations(kernel, at, from, (&q, &dq, &qd));
        self.accelerations[STAGE] = accelerations;
        *growth = own_growth.max(*growth);
    }

    /// Sums rates and accelerations over the stages, with the weights of a row.
    #[inline(always)]
    fn sums(&self, row: Row) -> ([R; N], [R; N]) {
        let (mut rate, mut acceleration) = ([R::zero(); N], [R::zero(); N]);
        for &(stage, weight) in row {
            let weight = R::from_f64(weight);
            for i in 0..N {
                rate[i] = weight.mul_add(self.rates[stage][i], rate[i]);
                acceleration[i] = weight.mul_add(self.accelerations[stage][i], acceleration[i]);
            }
        }
        (rate, acceleration)
    }

    /// Estimates the error of a step against the tolerance; `rate` and `acceleration` are the sums at its end.
    #[inline(always)]
    fn error<K: Kernel<R, N, M>, const M: usize>(
        &self,
        kernel: &K,
        h: R,
        from: &KernelState<R, N, M>,
        (q, qd): (&[R; N], &[R; N]),
        (rate, acceleration): (&[R; N], &[R; N]),
        scale: R,
    ) -> R {
        let number = R::from_f64;
        let ([n, _], is_length) = (kernel.sizes(), kernel.is_length());
        let mut squares = [R::zero(); 2];
        let (fifth, (rate_3, acceleration_3)) = (self.sums(ERROR_5), self.sums(END_3));
        let third = (difference(rate, &rate_3), difference(acceleration, &acceleration_3));
        for i in 0..N {
            let one = number(1.0);
            let of_q = if is_length[i] { one / (one + from.q[i].abs().max(q[i].abs())) } else { one };
            let of_qd = one / (one + from.qd[i].abs().max(qd[i].abs()));
            for (sum, (rate, acceleration)) in squares.iter_mut().zip([&fifth, &third]) {
                let (rate, acceleration) = (rate[i] * of_q, acceleration[i] * of_qd);
                *sum = acceleration.mul_add(acceleration, rate.mul_add(rate, *sum));
            }
        }
        let [fifth, third] = squares;
        let tiny = number(f64::MIN_POSITIVE);
        let denominator = number(0.01).mul_add(third, fifth).max(tiny) * number(2.0 * n as f64);
        h.abs() * fifth / (denominator.sqrt() * scale)
    }
}

/// The accelerations at a stage, out of line: large kernels stay in the processor's cache and are compiled once.
#[inline(always)]
fn accelerations<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    t: R,
    from: &KernelState<R, N, M>,
    (q, dq, qd): (&[R; N], &[R; N], &[R; N]),
) -> ([R; N], R) {
    K::call_out_of_line(
        #[inline(always)]
        || {
            let angles = from.angles.rotated_large(q, dq, kernel.has_angle());
            let position = kernel.position(t, q, &angles);
            (kernel.stage_accelerations(&position, t, q, qd, &angles), kernel.growth_factor(&position))
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_order_3_is_the_difference_of_two_ends() {
        let weight =
            |row: Row, stage: usize| row.iter().find(|(own, _)| *own == stage).map_or(0.0, |(_, weight)| *weight);
        for stage in 0..STAGES {
            let difference = weight(ROWS[STAGES], stage) - weight(END_3, stage);
            assert!((difference - weight(ERROR_3, stage)).abs() < 1e-15, "stage {stage}");
        }
    }
}
