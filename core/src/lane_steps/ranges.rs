//! The smallest and the largest values of outputs, inside steps too.

use super::StepsBy;
use super::step_control::REJECTED;
use crate::batch::DEFINED;
use crate::dop853::{DenseOutput, Dop853Step};
use crate::kernel::{Generated, Kernel};
use crate::lanes::{Lanes, Token};
use crate::rk4::KernelState;
use crate::scalar::Scalar;

/// Outputs are computed at the end of each of so many equal parts of a step.
pub(crate) const PARTS: usize = 8;

type Position<X, S, const N: usize, const M: usize> =
    <<X as Generated<N, M>>::Kernel<Lanes<S>> as Kernel<Lanes<S>, N, M>>::Position;

impl<X: Generated<N, M>, S: Token, const N: usize, const M: usize> StepsBy<X, S, N, M> {
    /// Takes the ranges of outputs in the step before into those of the motion.
    #[inline(always)]
    pub(super) fn accept_ranges(&mut self) {
        let layout = self.layout();
        for i in 0..layout.output_count {
            let [lowest, highest] = [layout.lowest() + i, layout.highest() + i];
            let [low, high] = [layout.step_lowest() + i, layout.step_highest() + i];
            self.set_number(lowest, self.number(low).min(self.number(lowest)));
            self.set_number(highest, self.number(high).max(self.number(highest)));
        }
    }

    /// Finds the ranges of outputs in a step, in lanes with an error that is accepted.
    ///
    /// Outputs are computed at the end of each part of the step; a cubic polynomial near each tells an extreme between
    /// them.
    #[inline(always)]
    pub(super) fn find_ranges(
        &mut self,
        (t, h): (Lanes<S>, Lanes<S>),
        from: &KernelState<Lanes<S>, N, M>,
        step: &mut Dop853Step<Lanes<S>, Position<X, S, N, M>, N, M>,
    ) {
        let error = step.error;
        let chosen = |accepted, rejected| error.choose(REJECTED, accepted, rejected);
        let (kernel, layout) = (self.kernel, self.layout());
        let dense_output = step.dense_output(&kernel, (t, h), from);
        for part in 1..PARTS {
            self.sample(part, (t, h), from, &dense_output);
        }
        let KernelState { q, qd, qdd, multipliers, angles } = &step.result.end;
        let outputs = &mut self.numbers[layout.sample(PARTS)..][..layout.output_count];
        kernel.outputs_at(&step.result.position, t + h, q, qd, angles, qdd, multipliers, outputs);
        let mut defined = self.number(DEFINED);
        for i in 0..layout.output_count {
            let before = self.number(layout.outputs() + i);
            let mut values = [before; PARTS + 1];
            for part in 1..=PARTS {
                values[part] = chosen(self.number(layout.sample(part) + i), before);
                defined = values[part].mul_add(Lanes::zero(), defined);
            }
            let [low, high] = range(&values);
            self.set_number(layout.step_lowest() + i, low);
            self.set_number(layout.step_highest() + i, high);
            self.set_number(layout.outputs() + i, values[PARTS]);
        }
        self.set_number(DEFINED, defined);
    }

    /// Computes the outputs at the end of a part of a step.
    #[inline(always)]
    fn sample(
        &mut self,
        part: usize,
        (t, h): (Lanes<S>, Lanes<S>),
        from: &KernelState<Lanes<S>, N, M>,
        dense_output: &DenseOutput<Lanes<S>, N>,
    ) {
        let (kernel, layout) = (self.kernel, self.layout());
        let outputs = &mut self.numbers[layout.sample(part)..][..layout.output_count];
        Lanes::<S>::out_of_line(
            #[inline(always)]
            || {
                let part = part as f64 / PARTS as f64;
                let (q, qd) = dense_output.at(part);
                let t = h.mul_add(Lanes::from_f64(part), t);
                let mut dq = q;
                for i in 0..N {
                    dq[i] = q[i] - from.q[i];
                }
                let angles = from.angles.turned_far(&q, &dq, X::Kernel::<Lanes<S>>::IS_ANGLE);
                let position = kernel.position(t, &q, &angles);
                let (qdd, multipliers) = kernel.accelerations(&position, t, &q, &qd, &angles);
                kernel.outputs_at(&position, t, &q, &qd, &angles, &qdd, &multipliers, outputs);
            },
        );
    }
}

/// The smallest and the largest value between values at equal distances.
///
/// Where second differences change much, the output has a corner or jumps, and values are taken as they are.
#[inline(always)]
fn range<S: Token>(values: &[Lanes<S>; PARTS + 1]) -> [Lanes<S>; 2] {
    let number = Lanes::<S>::from_f64;
    let mut second = [Lanes::zero(); PARTS];
    for k in 1..PARTS {
        second[k] = (values[k - 1] - values[k]) + (values[k + 1] - values[k]);
    }
    let (mut low, mut high) = (values[0].min(values[PARTS]), values[0].max(values[PARTS]));
    for k in 1..PARTS {
        let [before, after] = [second[k] - second[(k - 1).max(1)], second[(k + 1).min(PARTS - 1)] - second[k]];
        let third = (before + after) * number(if (2..PARTS - 1).contains(&k) { 0.5 } else { 1.0 });
        // Stirling's formula y + p s + p^2 b / 2 + p (p^2 - 1) t / 6, and where it is stationary.
        let (slope, bend) = ((values[k + 1] - values[k - 1]) * number(0.5), second[k]);
        let part = slope / bend;
        let cubic = |p: Lanes<S>| third * number(1.0 / 6.0) * p.mul_add(p, number(-1.0));
        let p =
            Lanes::zero() - part - third * number(1.0 / 6.0) * (number(3.0) * part).mul_add(part, number(-1.0)) / bend;
        let stationary = p.mul_add((p * bend).mul_add(number(0.5), slope) + cubic(p), values[k]);
        // Quotients that are not numbers are within no bound.
        let is_smooth = (before.abs().max(after.abs()) / bend) * number(2.0);
        let extreme = p.choose(1.0, is_smooth.choose(1.0, stationary, values[k]), values[k]);
        low = low.min(extreme);
        high = high.max(extreme);
    }
    [low, high]
}
