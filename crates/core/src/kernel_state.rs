//! The states at both ends of a step by a kernel.

use crate::angles::Angles;
use crate::kernel::{Kernel, MAX_GROWTH};
use crate::scalar::Scalar;

/// A state, and the sines and cosines that a step needs at its beginning.
#[derive(Clone, Copy, Debug)]
pub struct KernelState<R, const N: usize, const M: usize> {
    /// Coordinates, in rad or m.
    pub q: [R; N],
    /// Rates.
    pub qd: [R; N],
    /// Accelerations.
    pub qdd: [R; N],
    /// Multipliers.
    pub multipliers: [R; M],
    /// Sines and cosines of `q`.
    pub angles: Angles<R, N>,
}

impl<R: Scalar, const N: usize, const M: usize> KernelState<R, N, M> {
    /// Creates the state at time `t` from coordinates and rates that satisfy the constraints.
    #[inline]
    pub fn new<K: Kernel<R, N, M>>(kernel: &K, t: R, q: [R; N], qd: [R; N]) -> Self {
        let angles = Angles::new(&q, kernel.has_angle());
        let position = kernel.position(t, &q, &angles);
        let (qdd, multipliers) = kernel.accelerations(&position, t, &q, &qd, &angles);
        Self { q, qd, qdd, multipliers, angles }
    }

    /// Combines two states number by number: `choose` takes the number of `other` and that of `self`.
    #[cfg(feature = "simd")]
    #[inline(always)]
    pub(crate) fn replaced(&self, other: &Self, choose: impl Fn(R, R) -> R) -> Self {
        let mut state = *self;
        for i in 0..N {
            state.q[i] = choose(other.q[i], self.q[i]);
            state.qd[i] = choose(other.qd[i], self.qd[i]);
            state.qdd[i] = choose(other.qdd[i], self.qdd[i]);
            state.angles.sin[i] = choose(other.angles.sin[i], self.angles.sin[i]);
            state.angles.cos[i] = choose(other.angles.cos[i], self.angles.cos[i]);
        }
        for k in 0..M {
            state.multipliers[k] = choose(other.multipliers[k], self.multipliers[k]);
        }
        state
    }

    /// Zero if all numbers are finite; not a number in a lane where one is not.
    #[inline(always)]
    pub fn finite_check(&self) -> R {
        // Accelerations and multipliers depend on all the other numbers. Zero times a number that is not finite is not
        // a number.
        let mut sum = R::zero();
        for i in 0..N {
            sum = sum + self.qdd[i];
        }
        for k in 0..M {
            sum = sum + self.multipliers[k];
        }
        sum * R::zero()
    }
}

/// The end of a step and its quality.
#[derive(Clone, Copy, Debug)]
pub struct StepResult<R, P, const N: usize, const M: usize> {
    /// The state at the end.
    pub end: KernelState<R, N, M>,
    /// The quantities that follow from the position at the end.
    pub position: P,
    /// Largest growth of rounding errors at any stage: see [`Kernel::growth_factor`].
    pub growth_factor: R,
    /// Largest residual of a constraint at the end, in its unit.
    pub residual: R,
    /// The number of corrections of the coordinates, at most 4.
    pub corrections: u32,
}

impl<R: Scalar, P, const N: usize, const M: usize> StepResult<R, P, N, M> {
    /// Whether the step is reliable: all numbers are finite, no residual is larger than `tolerance`, and the kernel is
    /// valid at the position.
    #[inline(always)]
    pub fn is_good(&self, tolerance: f64) -> bool {
        self.growth_factor.is_within(MAX_GROWTH)
            && self.residual.is_within(tolerance)
            && self.end.finite_check().is_within(0.0)
    }
}
