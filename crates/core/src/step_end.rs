//! The end of a step by a kernel, and its projection onto the constraints.

use crate::angles::Angles;
use crate::kernel::Kernel;
use crate::kernel_state::{KernelState, StepResult};
use crate::scalar::Scalar;
use crate::vectors::{difference, largest, sum};

/// Residuals up to this size, in the unit of a constraint, are rounding errors.
pub const RESIDUAL_ROUNDING: f64 = 4e-16;
/// Corrections up to this size, in rad or m, are rounding errors.
pub const CORRECTION_ROUNDING: f64 = 1e-15;
/// The largest number of corrections; a step that needs more is left to the robust method.
pub const MAX_CORRECTIONS: u32 = 4;

/// The end of a step while it is projected onto the constraints.
pub(crate) struct StepEnd<R, const N: usize> {
    pub(crate) q: [R; N],
    pub(crate) qd: [R; N],
    /// The change of the coordinates in the step, before the projection.
    pub(crate) increment: [R; N],
    pub(crate) angles: Angles<R, N>,
    pub(crate) corrections: u32,
}

impl<R: Scalar, const N: usize> StepEnd<R, N> {
    /// The first correction. It uses Jacobian and mass matrix of the last stage, which lies near enough.
    #[inline(always)]
    pub(crate) fn project_coordinates_first<K: Kernel<R, N, M>, const M: usize>(
        &mut self,
        kernel: &K,
        from: &KernelState<R, N, M>,
        correction: &[R; N],
    ) {
        self.q = sum(&from.q, &sum(&self.increment, correction));
        // The correction as added to the coordinates, rounding included.
        let moved = difference(&difference(&self.q, &from.q), &self.increment);
        self.angles = self.angles.rotated_by_correction(&self.q, &moved, kernel.has_angle());
        self.corrections = 1;
    }

    /// Corrects the coordinates again and returns true; returns false if no correction is needed.
    #[inline(always)]
    pub(crate) fn project_coordinates<K: Kernel<R, N, M>, const M: usize>(
        &mut self,
        kernel: &K,
        position: &K::Position,
    ) -> bool {
        if !has_constraints(kernel) || self.corrections == MAX_CORRECTIONS {
            return false;
        }
        let open = kernel.residuals(position);
        let residual = largest(&open);
        if residual.is_within(RESIDUAL_ROUNDING) {
            return false;
        }
        let correction = kernel.correction(position, &open);
        // Lanes without a residual stay unchanged, even if other lanes need a correction.
        let size = residual.choose(RESIDUAL_ROUNDING, R::zero(), largest(&correction));
        if size.is_within(CORRECTION_ROUNDING) {
            return false;
        }
        for i in 0..N {
            self.q[i] = self.q[i] + size.choose(CORRECTION_ROUNDING, R::zero(), correction[i]);
        }
        self.angles = self.angles.recomputed_where(&self.q, size, CORRECTION_ROUNDING, kernel.has_angle());
        self.corrections += 1;
        true
    }

    /// Projects the rates onto the tangent space of the constraints.
    #[inline(always)]
    pub(crate) fn project_rates<K: Kernel<R, N, M>, const M: usize>(&mut self, kernel: &K, position: &K::Position) {
        if has_constraints(kernel) {
            self.qd = sum(&self.qd, &kernel.correction(position, &kernel.velocity_residual(position, &self.qd)));
        }
    }
}

/// Whether there is anything to project onto.
#[inline(always)]
pub(crate) fn has_constraints<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(kernel: &K) -> bool {
    let [_, m] = kernel.sizes();
    m > 0
}

/// The result of a step.
#[inline(always)]
pub(crate) fn finish<K: Kernel<R, N, M>, R: Scalar, const N: usize, const M: usize>(
    kernel: &K,
    end: StepEnd<R, N>,
    (qdd, multipliers): ([R; N], [R; M]),
    position: K::Position,
    growth: R,
) -> StepResult<R, K::Position, N, M> {
    let residual = largest(&kernel.residuals(&position));
    // Fresh sines and cosines: the rounding errors of successive rotations would add up.
    let angles = Angles::new(&end.q, kernel.has_angle());
    let state = KernelState { q: end.q, qd: end.qd, qdd, multipliers, angles };
    StepResult { end: state, position, growth_factor: growth, residual, corrections: end.corrections }
}
