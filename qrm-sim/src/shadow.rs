//! A second run beside the first, which tells its error.

use qrm_core::{Kernel, LARGE, Mechanism};

use crate::linear::{Vector, largest};
use crate::motion::{Method, Moment};
use crate::solve::Care;
use crate::stepper::Stepper;
use crate::walk::{is_walked, parameters, single};

/// How far rounding errors wander in a step, in units in the last place of the largest coordinate (measured).
const WANDER: f64 = 0.2;

/// How much larger the difference of two runs is than the error of the one with half the step: 15 times for results of order 4,
/// 7 times for order 3. Long steps do not show the full order; it is taken for 3.5, so that errors are told too large rather
/// than too small.
pub(crate) const LEVER: f64 = 10.3;

/// A run at twice the step, or at a tenth of the tolerance, where the difference is the error of the first run itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shadow<const N: usize, const M: usize> {
    method: Method,
    stepper: Stepper<N, M>,
    at: Moment<N, M>,
    /// Rows of the first run so far.
    rows: u64,
    /// Largest difference in any row, and largest coordinate.
    difference: f64,
    size: f64,
    broke_off: bool,
}

impl<const N: usize, const M: usize> Shadow<N, M> {
    /// Begins with the first run; `None` if that is not possible.
    pub(crate) fn new<X: Mechanism<N, M>>(
        mechanism: &X,
        method: &Method,
        first: Moment<N, M>,
        end_time: f64,
    ) -> Option<Self> {
        let method = method.shadow();
        let stepper = Stepper::new(mechanism, method.scheme, first, end_time, &mut Care::default()).ok()?;
        Some(Self { method, stepper, at: first, rows: 0, difference: 0.0, size: 0.0, broke_off: false })
    }

    /// Follows rows of the first run, the first of which is its start; a last one that is no whole step is left out.
    pub(crate) fn follow<X: Mechanism<N, M>>(
        &mut self,
        mechanism: &X,
        rows: &[Moment<N, M>],
        is_whole: impl Fn(u64, &Moment<N, M>) -> bool,
    ) {
        // The plain functions tell more, but of a large mechanism they take far too long.
        let is_large = is_walked(&self.method) && X::Kernel::<f64>::OPERATIONS > LARGE;
        let kernel = is_large.then(|| {
            let values = parameters(mechanism);
            X::Kernel::<f64>::with_values(|i| values[i])
        });
        for row in rows {
            let index = self.rows;
            self.rows += 1;
            let is_met = !self.stepper.is_fixed() || index.is_multiple_of(2);
            if self.broke_off || index == 0 || !is_met || !is_whole(index, row) {
                continue;
            }
            let mut care = Care::default();
            let next = match &kernel {
                Some(kernel) => single(mechanism, kernel, &self.method, &self.at, row.t, &mut care),
                None => self.stepper.next(mechanism, &self.method, &self.at, row.t, &mut care),
            };
            match next {
                Ok(at) => self.at = at,
                Err(_) => {
                    self.broke_off = true;
                    continue;
                }
            }
            let difference: Vector<N> = std::array::from_fn(|i| self.at.q[i] - row.q[i]);
            self.difference = self.difference.max(largest(&difference).1);
            self.size = self.size.max(largest(&row.q).1);
        }
    }

    /// The largest error of a coordinate in any row, after so many steps; `None` if the second run broke off or never met the
    /// first.
    pub(crate) fn error(&self, steps: u64) -> Option<f64> {
        let lever = if self.stepper.is_fixed() { LEVER } else { 1.0 };
        (!self.broke_off && self.at.t > 0.0).then_some(estimate(self.difference / lever, self.size, steps))
    }

    /// Whether it broke off.
    pub(crate) fn broke_off(&self) -> bool {
        self.broke_off
    }
}

/// The error of a run of so many steps with coordinates of this size, where the steps by themselves leave `of_steps`.
pub(crate) fn estimate(of_steps: f64, size: f64, steps: u64) -> f64 {
    // The rounding errors of both runs may agree; by themselves they wander as far as this.
    of_steps.max(WANDER * f64::EPSILON * size * (steps as f64).sqrt())
}
