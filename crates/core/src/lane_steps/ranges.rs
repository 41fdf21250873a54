//! The smallest and the largest values of outputs, including those inside steps.

use super::StepsBy;
use crate::dop853::{DenseOutput, Dop853Step};
use crate::kernel::Kernel;
use crate::kernel_state::KernelState;
use crate::lane_layout::{DEFINED, FIFTH, PARTS, REJECTED, SMOOTH};
use crate::lanes::{Lanes, Token};
use crate::scalar::Scalar;

impl<K: Kernel<Lanes<S>, N, M>, S: Token, const N: usize, const M: usize> StepsBy<K, S, N, M> {
    /// Merges the ranges of the previous step into those of the motion. They stay separate for one step, so that the
    /// step can be undone.
    #[inline(always)]
    pub(super) fn accept_ranges(&mut self) {
        let layout = self.layout();
        for i in 0..layout.output_count {
            for (all, of_step) in [(layout.lowest(), layout.step_lowest()), (layout.least(), layout.step_least())] {
                self.set_number(all + i, self.number(of_step + i).min(self.number(all + i)));
            }
            for (all, of_step) in [(layout.highest(), layout.step_highest()), (layout.most(), layout.step_most())] {
                self.set_number(all + i, self.number(of_step + i).max(self.number(all + i)));
            }
        }
    }

    /// Finds the ranges of outputs in a step, in lanes whose error is accepted.
    ///
    /// Outputs are computed at the end of each part of the step; the polynomial through them gives the extremes
    /// between.
    #[inline(always)]
    pub(super) fn find_ranges(
        &mut self,
        (t, h): (Lanes<S>, Lanes<S>),
        from: &KernelState<Lanes<S>, N, M>,
        step: &mut Dop853Step<'_, Lanes<S>, K::Position, N, M>,
    ) {
        let error = step.error;
        let chosen = |accepted, rejected| error.choose(REJECTED, accepted, rejected);
        let layout = self.layout();
        let Self { kernel, numbers, .. } = self;
        let KernelState { q, qd, qdd, multipliers, angles } = &step.result.end;
        let outputs = &mut numbers[layout.sample(PARTS)..][..layout.output_count];
        kernel.outputs_at(&step.result.position, t + h, q, qd, angles, qdd, multipliers, outputs);
        let dense_output = step.dense_output(kernel, (t, h), from);
        for part in 1..PARTS {
            self.sample(part, (t, h), from, &dense_output);
        }
        let mut defined = self.number(DEFINED);
        for i in 0..layout.output_count {
            let before = self.number(layout.outputs() + i);
            let mut values = [before; PARTS + 1];
            for part in 1..=PARTS {
                values[part] = chosen(self.number(layout.sample(part) + i), before);
                defined = values[part].mul_add(Lanes::zero(), defined);
            }
            let [low, high, error] = range(&values);
            self.set_number(layout.step_lowest() + i, low);
            self.set_number(layout.step_highest() + i, high);
            self.set_number(layout.step_least() + i, low - error);
            self.set_number(layout.step_most() + i, high + error);
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
        let layout = self.layout();
        let Self { kernel, numbers, .. } = self;
        let outputs = &mut numbers[layout.sample(part)..][..layout.output_count];
        K::call_out_of_line(
            #[inline(always)]
            || {
                let part = part as f64 / PARTS as f64;
                let (q, qd) = dense_output.at(part);
                let t = h.mul_add(Lanes::from_f64(part), t);
                let mut dq = q;
                for i in 0..N {
                    dq[i] = q[i] - from.q[i];
                }
                let angles = from.angles.rotated_large(&q, &dq, kernel.has_angle());
                let position = kernel.position(t, &q, &angles);
                let (qdd, multipliers) = kernel.accelerations(&position, t, &q, &qd, &angles);
                kernel.outputs_at(&position, t, &q, &qd, &angles, &qdd, &multipliers, outputs);
            },
        );
    }
}

/// The smallest and the largest value over the span of five equidistant values, from the polynomial through them, and
/// their error. Extremes are searched for up to one distance from each inner value.
///
/// The error is twice that of fifth differences `d5`, `0.03 d5`. In a smooth output they follow from the others as
/// `d2 r^3`, where `r` is the larger one of `d3/d2` and `sqrt(d4/d2)`. It counts where an extreme lies between the
/// values. If fourth differences are not small against second ones, the output has a corner or jumps, or changes
/// too fast: only the five values themselves count, and second differences are their error.
#[inline(always)]
fn range<S: Token>(values: &[Lanes<S>; PARTS + 1]) -> [Lanes<S>; 3] {
    let number = Lanes::<S>::from_f64;
    let [v0, v1, v2, v3, v4] = *values;
    let [before, at, after] = [(v0 - v1) + (v2 - v1), (v1 - v2) + (v3 - v2), (v2 - v3) + (v4 - v3)];
    // The derivatives in the middle by Stirling's formula.
    let d4 = (before - at) + (after - at);
    let d3 = (after - before) * number(0.5);
    let d2 = d4.mul_add(number(-1.0 / 12.0), at);
    let d1 = d3.mul_add(number(-1.0 / 6.0), (v3 - v1) * number(0.5));
    let taylor = |s: Lanes<S>, [d1, d2, d3]: [Lanes<S>; 3]| {
        let third = d4.mul_add(s, d3);
        let second = (d4 * number(0.5)).mul_add(s, d3).mul_add(s, d2);
        let first = (d4 * number(1.0 / 3.0)).mul_add(s, d3).mul_add(s * number(0.5), d2).mul_add(s, d1);
        [first, second, third]
    };
    let most = before.abs().max(at.abs()).max(after.abs());
    let roughness = d4 / most;
    let [lowest, highest] = [v0.min(v1).min(v2).min(v3).min(v4), v0.max(v1).max(v2).max(v3).max(v4)];
    let (mut low, mut high) = (lowest, highest);
    for (value, place) in [(v1, -1.0), (v2, 0.0), (v3, 1.0)] {
        let here = taylor(number(place), [d1, d2, d3]);
        // One step of Newton's method towards the place where the polynomial is stationary.
        let near = Lanes::zero() - here[0] / here[1];
        let [slope, bend, _] = taylor(near, here);
        let s = near - slope / bend;
        let cubic = (d4 * number(0.25)).mul_add(s, here[2]) * number(1.0 / 3.0);
        let stationary = cubic.mul_add(s, here[1]).mul_add(s * number(0.5), here[0]).mul_add(s, value);
        // A quotient that is not a number is within no bound.
        let extreme = s.choose(1.0, roughness.choose(SMOOTH, stationary, value), value);
        low = low.min(extreme);
        high = high.max(extreme);
    }
    // Zero where the values themselves are the extremes.
    let beyond = (lowest - low) + (high - highest);
    let ratio = d3 / most;
    let square = roughness.abs().max(ratio * ratio);
    let smooth = beyond.choose(0.0, Lanes::zero(), number(FIFTH) * most * square * square.sqrt());
    [low, high, roughness.choose(SMOOTH, smooth, most)]
}
